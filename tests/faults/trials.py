"""One try: a command on a fresh copy of its folder, with a fault in it; then what is left is looked at, and it is tried
again without one.

What must be true, whatever happened where:

- it ends, without a traceback, with 0, 1 or 2 (or by the signal that was sent), never with 3;
- with 2 each line it says has a reason and a mend;
- the store can be read, whole, and holds what it held or what the command makes: no half of either;
- every file that the user has is as it was, or as the command makes it;
- when the fault is mended (space, rights, the file put back), the same command ends as it does without any fault.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiffcal.errors import InputError
from stiffcal.store import Store
from stiffcal.trust.content import from_json
from stiffcal.trust.pending import PENDING, all_pending
from tests.faults.commands import Command
from tests.faults.forking import Forker

PATIENCE_S = 120.0
KINDS = (
    "killed", "killed in time", "interrupted", "terminated", "disk full", "disk really full", "files cut",
    "right revoked", "file truncated",
)  # fmt: skip
# Its work is done by other processes, which an audit hook here does not hear.
KINDS_OF_BATCH = (
    "killed in time", "interrupted", "terminated", "a process killed", "disk really full", "files cut",
)  # fmt: skip
VOLATILE = frozenset({
    "time", "seconds", "created", "mtime_ns", "mtime", "unchanged", "changed", "versions", "made", "steps", "key",
    "memory_bytes", "peak_memory_bytes", "sha256", "pace",
})  # fmt: skip
SIGNALLED = {"killed": (-9,), "killed in time": (-14,), "interrupted": (130,), "terminated": (-15, 130)}
"""Exit codes that a signal gives; a batch that is asked to end does so in order, as after Ctrl-C."""

Prints = dict[str, str]


class FoundError(AssertionError):
    """A promise that was not kept."""


@dataclass(frozen=True)
class Reference:
    """A command without a fault.

    Attributes
    ----------
    code : its exit code. before, after : prints of the folder. events, dealings : how often it changes files, and how
        often it opens them at all. seconds : how long it takes. largest : bytes of the largest file it leaves.
    """

    code: int
    before: Prints
    after: Prints
    events: int
    dealings: int
    seconds: float
    largest: int


@dataclass(frozen=True)
class Outcome:
    """A try: what was done to the command, how it ended ("before": nothing of it is there, "after": all)."""

    command: str
    kind: str
    code: int
    left: str


def prints_of(place: Path) -> Prints:
    """Return what lies in a folder: a digest per file, and per table and document of each store.

    Raises
    ------
    FoundError : a store cannot be read.
    """
    found: Prints = {}
    stores = [path for path in place.rglob("store") if path.is_dir()]
    for store in stores:
        found |= {f"{store.relative_to(place)}: {name}": text for name, text in _store_prints(store).items()}
    for file in sorted(place.rglob("*")):
        noted = file.parent.name == PENDING  # generations that the record could not take: counted with it
        if file.is_file() and not noted and not any(file.is_relative_to(store) for store in stores):
            found[str(file.relative_to(place))] = _file_print(file)
    return found


def _file_print(file: Path) -> str:
    if file.name in ("j.xml", "s.md"):
        return "a summary"  # holds times
    if file.name == "trust.lock":
        return "a lock"
    if file.name == "trust.json":
        return _record_print(file)
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _record_print(file: Path) -> str:
    """Return what a record of trust holds, but for times and hashes that hold times."""
    try:
        content = from_json(file.read_text(encoding="ascii"))
    except ValueError as error:
        return f"damaged: {error}"
    return f"{sorted(content.allowed)}, own generations: {bool(content.generations or all_pending(file.parent))}"


def _store_prints(folder: Path) -> Prints:
    from stiffcal.stages.steps import key_of_table

    store = Store(folder)
    if not store.exists:
        return {}
    try:
        with store.snapshot() as snapshot:
            found = {name: key_of_table(snapshot.read_table(name)) for name in snapshot.tables}
            for name in snapshot.documents:
                found[name] = json.dumps(_lasting(snapshot.read_document(name)), sort_keys=True)
    except InputError as error:
        raise FoundError(f"the store is not whole: {error}") from None
    return found


def _lasting(value: Any) -> Any:
    """Leave out what differs from one run of a command to the next."""
    if isinstance(value, dict):
        return {key: _lasting(held) for key, held in value.items() if key not in VOLATILE}
    return [_lasting(held) for held in value] if isinstance(value, list) else value


class Bench:
    """Where tries are made.

    Parameters
    ----------
    bases : folder of the bases (`make_bases`). place : an empty folder for the tries. forker : runs the commands.
    """

    def __init__(self, bases: Path, place: Path, forker: Forker) -> None:
        self._bases, self._place, self._forker = bases, place, forker
        self._references: dict[str, Reference] = {}

    def reference(self, command: Command) -> Reference:
        """Run a command without a fault, once for all tries."""
        if command.name not in self._references:
            with self._fresh(command) as work:
                before = prints_of(work)
                answer = self._run(command, work, {"kind": "none", "folder": str(work)})
                code, seconds = answer["code"], answer["seconds"]
                if code not in (0, 1):
                    raise FoundError(f"{command.name} without a fault: {code}: {self._said()}")
                events, dealings = map(int, (self._place / "events").read_text().split())
                largest = max(file.stat().st_size for file in work.rglob("*") if file.is_file())
                reference = Reference(code, before, prints_of(work), events, dealings, seconds, largest)
                self._references[command.name] = reference
        return self._references[command.name]

    def try_once(self, command: Command, kind: str, chance: random.Random) -> Outcome:
        """Make one try.

        Raises
        ------
        FoundError : a promise was not kept; says which.
        """
        reference = self.reference(command)
        with self._fresh(command, small=kind == "disk really full", chance=chance, extra=reference.largest) as work:
            fault = self._fault(kind, reference, work, chance)
            answer = self._run(command, work, fault)
            reported = f"{command.name}, {fault}: "
            self._judge_ending(answer["code"], kind, reference, reported)
            self._mend(kind, fault, command, work)
            left = self._judge_left(command, kind, work, reference, reported)
            self._judge_repeat(command, kind, work, reference, left, reported)
        return Outcome(command.name, kind, answer["code"], left)

    def _run(self, command: Command, work: Path, fault: dict[str, Any]) -> dict[str, Any]:
        words = [word.replace("{}", str(work)) for word in command.words]
        files = {name: str(self._place / name) for name in ("out", "err", "events")}
        # On a machine that others use too a command takes longer without hanging.
        crowd = max(os.getloadavg()[0] / (os.cpu_count() or 1), 1.0)
        state = {"STIFFCAL_STATE": str(work / "state")} if command.own_state else {}
        return self._forker.run(words=words, environment=state, fault=fault, patience=crowd * PATIENCE_S, **files)

    def _said(self) -> str:
        return "".join((self._place / name).read_text(encoding="utf-8", errors="replace") for name in ("err", "out"))

    @contextmanager
    def _fresh(
        self, command: Command, small: bool = False, chance: random.Random | None = None, extra: int = 0
    ) -> Iterator[Path]:
        """Copy the base; `small`: onto a disk of its own that has little space left."""
        work = self._place / "work"
        work.mkdir()
        mounted = small and chance is not None and _mount(work, 8_000_000)
        try:
            shutil.copytree(self._bases / command.base, work, symlinks=True, dirs_exist_ok=True)
            if mounted and chance is not None:
                _fill(work, int(chance.random() ** 2 * 2 * extra))
            yield work
        finally:
            if mounted:
                subprocess.run(["umount", str(work)], check=True)
            shutil.rmtree(work)

    def _fault(self, kind: str, reference: Reference, work: Path, chance: random.Random) -> dict[str, Any]:
        fault: dict[str, Any] = {"kind": kind, "folder": str(work)}
        if reference.events == 0 or kind in ("killed in time", "a process killed"):
            fault |= {"after": chance.uniform(0.0, reference.seconds), "seed": chance.random()}
        fault["at"] = chance.randint(1, max(reference.events, 1))
        if kind == "files cut":
            fault["size"] = int(chance.random() ** 3 * reference.largest)
        elif kind in ("right revoked", "file truncated"):
            # Nothing but what is there before: a folder that the command makes for itself is its own.
            paths = [path for path in (work, *work.rglob("*")) if not path.is_symlink()]
            wanted = [path for path in paths if path.is_file() or kind == "right revoked"]
            fault |= {"target": str(chance.choice(sorted(wanted))), "at": chance.randint(1, max(reference.dealings, 1))}
            fault |= {"mode": chance.choice([0, 0o444, 0o555]), "share": chance.random()}
        return fault

    def _judge_ending(self, code: int | None, kind: str, reference: Reference, reported: str) -> None:
        said = self._said()
        if code is None:
            raise FoundError(f"{reported}it hung")
        if code not in (0, 1, 2, *SIGNALLED.get(kind, ())):
            raise FoundError(f"{reported}exit code {code}: {said[-2000:]}")
        if "Traceback" in said:
            raise FoundError(f"{reported}a traceback: {said[-2000:]}")
        if code == 1 and reference.code != 1 and not reported.startswith("batch"):
            raise FoundError(f"{reported}exit code 1: {said[-2000:]}")
        if code == 2:
            lines = (self._place / "err").read_text(encoding="utf-8").splitlines()
            # What was done before is reported above it.
            if not lines or "; " not in lines[-1] or ": " not in lines[-1]:
                raise FoundError(f"{reported}no clear line: {lines}")

    def _mend(self, kind: str, fault: dict[str, Any], command: Command, work: Path) -> None:
        """Put right what the fault did, as a user would who reads what was said."""
        if kind == "disk really full":
            with suppress(FileNotFoundError):
                (work / "filled").unlink()
        if kind == "right revoked":
            target = Path(fault["target"])
            with suppress(FileNotFoundError):  # an old generation goes with the command
                target.chmod(0o755 if target.is_dir() else 0o644)
        if kind == "file truncated":
            target = Path(fault["target"])
            original = self._bases / command.base / target.relative_to(work)
            if "store" in target.relative_to(work).parts:
                # "damaged: delete the store and run ingest again (its history goes too)"
                shutil.rmtree(next(one for one in target.parents if one.name == "store"), ignore_errors=True)
            elif target.exists() and target.read_bytes() != original.read_bytes():
                shutil.copy2(original, target)

    def _judge_left(self, command: Command, kind: str, work: Path, reference: Reference, reported: str) -> str:
        found = {name: text for name, text in prints_of(work).items() if not _is_litter(name)}
        if kind == "file truncated":
            found = {name: text for name, text in found.items() if "store: " not in name}
        for name, text in found.items():
            if text not in (reference.before.get(name), reference.after.get(name)) and not _may_lie_between(name, kind):
                raise FoundError(f"{reported}{name} is neither what it was nor what it is to be")
        users = [name for name in reference.before if "store: " not in name and name not in found]
        if users:
            raise FoundError(f"{reported}lost: {users}")
        # A stranger's results go with the states that they were made from, before they are computed again.
        if kind != "file truncated" and command.base != "stranger":
            gone = [name for name in reference.before if name in reference.after and name not in found]
            if gone:
                raise FoundError(f"{reported}gone from the store: {gone}")
        if found == reference.after:
            return "after"
        return "before" if found == reference.before else "between"

    def _judge_repeat(
        self, command: Command, kind: str, work: Path, reference: Reference, left: str, reported: str
    ) -> None:
        users = {name: text for name, text in reference.after.items() if "store: " not in name}
        if command.name in ("remove", "init", "init --from") and users.items() <= prints_of(work).items():
            return  # once done these cannot be done again
        if command.name.startswith("init") and (work / "new").exists():
            return  # made of what the table held just then
        answer = self._run(command, work, {"kind": "none", "folder": str(work)})
        if kind == "file truncated" and command.base == "two models" and answer["code"] == 2:
            return  # the history went with the store
        if answer["code"] != reference.code:
            raise FoundError(f"{reported}when mended: {answer['code']}: {self._said()[-2000:]}")
        again = {name: text for name, text in prints_of(work).items() if not _is_litter(name)}
        if kind == "file truncated":
            again = {name: text for name, text in again.items() if "store: " not in name}
        wrong = [name for name, text in again.items() if reference.after.get(name) != text]
        if wrong and kind != "file truncated":
            raise FoundError(f"{reported}when mended, other than without a fault: {wrong}")
        litter = [str(path) for path in work.rglob("*") if _is_litter(path.name)]
        tidies = kind not in SIGNALLED and kind != "right revoked"  # without the right nothing can be taken away
        generations = [len(list(path.iterdir())) for path in work.rglob("generations")]
        if litter and tidies:
            raise FoundError(f"{reported}left lying about: {litter}")
        if any(count > 1 for count in generations):
            raise FoundError(f"{reported}old generations were left")


def _is_litter(name: str) -> bool:
    return any(part.startswith(".") for part in Path(name).parts) or name == "filled"


def _may_lie_between(name: str, kind: str) -> bool:
    """Tell what has its own steps: the history grows by one fit after another, a batch by one campaign."""
    return "store: " in name or kind == "file truncated"


def _mount(folder: Path, size: int) -> bool:
    """Mount a disk of its own in memory, where that may be done."""
    words = ["mount", "-t", "tmpfs", "-o", f"size={size}", "stiffcal-faults", str(folder)]
    with suppress(OSError):
        return subprocess.run(words, check=False, capture_output=True).returncode == 0
    return False


def _fill(disk: Path, leave: int) -> None:
    """Fill the disk but for so many bytes."""
    free = shutil.disk_usage(disk).free - leave
    with (disk / "filled").open("wb") as file:
        file.write(bytes(max(free, 0)))
