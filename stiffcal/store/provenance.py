"""Where results come from: the hash of every source, the settings, the versions of what computed them."""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Literal

from stiffcal.documents import Document
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.store.file_systems import shows_mapped_writes, write_back

CHUNK = 1 << 20
PACKAGES = ("numpy", "scipy", "pyarrow", "h5py", "pandas", "pydantic")
# A file changed within this time of being hashed may carry the same time of change: clocks of file systems are coarse.
RACY_NS = 3_000_000_000
ALWAYS_HASHED = 64 << 20
"""Bytes of sources, the smallest first, that are compared by their content in every command: 0.05 to 0.2 s of SHA-256.

Of thousands of logs no command reads gigabytes only to learn that nothing has changed."""


MOST_NAMED = 6
"""Files of one kind that a message names: those of two runs of three devices."""


@dataclass(frozen=True)
class SourceFile:
    """A source as it was when it was read."""

    file: str
    """Path relative to the campaign folder, with forward slashes, as in the manifest."""
    bytes: int
    """Size."""
    modified_ns: int
    """Time of the last change, ns since 1970."""
    sha256: str
    """Hexadecimal."""


@dataclass(frozen=True, kw_only=True)
class IngestSettings:
    """What besides the logs decides what is made of them."""

    manifest: Document
    """campaign.toml, without thresholds, report, trend, effects and name."""
    robot: Document
    """robot.toml."""
    revision: int
    """Of what computes."""


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """What a generation was made from; the store's document ``provenance``."""

    schema: Literal["stiffcal/provenance/1"] = "stiffcal/provenance/1"
    warnings: list[str] = field(default_factory=list)
    """None: there is nothing to warn of."""
    created: str
    """UTC, ISO 8601."""
    command: str
    """The command that made it."""
    sources: tuple[SourceFile, ...]
    """Every file that was read."""
    settings: Document
    """Manifest, robot and whatever else shaped the result, as JSON values."""
    versions: dict[str, str]
    """Of Python, stiffcal and the packages that compute."""

    @classmethod
    def now(cls, command: str, sources: Sequence[SourceFile], settings: Mapping[str, Any]) -> Provenance:
        """Return a record of this moment and these versions."""
        return cls(
            created=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            command=command,
            sources=tuple(sources),
            settings=dict(settings),
            versions=versions(),
        )


@dataclass(frozen=True)
class SourceChanges:
    """How the sources differ from those that were read."""

    changed: tuple[str, ...] = ()
    """Other content than then."""
    missing: tuple[str, ...] = ()
    """In the manifest, not on the disk."""
    new: tuple[str, ...] = ()
    """In the manifest, not read then."""
    dropped: tuple[str, ...] = ()
    """Read then, no longer in the manifest."""
    state: str = ""
    """`sources_state` of the sources that were compared, to be remembered where nothing differs."""

    def __bool__(self) -> bool:
        return bool(self.changed or self.missing or self.new or self.dropped)

    def __str__(self) -> str:
        words = {"changed": "changed", "missing": "missing", "new": "new", "dropped": "no longer named"}
        parts = [f"{word}: {_first_of(getattr(self, kind))}" for kind, word in words.items() if getattr(self, kind)]
        return "; ".join(parts) or "no source changed"


def _first_of(files: Sequence[str]) -> str:
    more = len(files) - MOST_NAMED
    return ", ".join([*files[:MOST_NAMED], *([f"{more} more"] if more > 0 else [])])


def versions() -> dict[str, str]:
    """Return the versions of Python, stiffcal and the packages that compute, without importing them.

    Examples
    --------
    >>> sorted(versions())[:2]
    ['h5py', 'numpy']
    """
    return dict(_package_versions())


@cache
def _package_versions() -> tuple[tuple[str, str], ...]:
    from stiffcal import __version__

    versions = {"python": sys.version.split()[0], "stiffcal": __version__}
    for package in PACKAGES:
        with suppress(importlib.metadata.PackageNotFoundError):
            versions[package] = importlib.metadata.version(package)
    return tuple(versions.items())


class SourceHashes:
    """The hashes of files, taken in a thread of their own. Made by `hash_sources`."""

    def __init__(self, folder: Path, files: Sequence[str]) -> None:
        self._folder = folder
        self._files = tuple(dict.fromkeys(files))
        # before anything is read: what is written through a mapping from now on moves the files' times
        self._state = sources_state(folder, self._files, settle=True)
        self._found: list[SourceFile] = []
        self._error: BaseException | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="hash sources", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self._found = _hash_files(self._folder, self._files, self._stop)
        except BaseException as error:  # it belongs to the thread that waits for the result
            self._error = error

    def stop(self) -> None:
        """Give up."""
        self._stop.set()
        self._thread.join()

    def result(self) -> tuple[SourceFile, ...]:
        """Wait for the hashes.

        Raises
        ------
        InputError
            If a file cannot be read, or was changed meanwhile.
        """
        self._thread.join()
        if self._error is not None:
            raise self._error
        for source in self._found:
            state = _state(self._folder, source.file)
            if state != (source.bytes, source.modified_ns):
                raise _changed_meanwhile(source.file)
        return tuple(self._found)

    @property
    def state(self) -> str:
        """`sources_state` of the files that were hashed, "" where one of them has changed since."""
        return self._state if self._state == sources_state(self._folder, self._files) else ""


@contextmanager
def hash_sources(folder: Path, files: Sequence[str]) -> Iterator[SourceHashes]:
    """Hash files while something else is done inside the block; ``result()`` gives the hashes.

    Parameters
    ----------
    folder : the campaign folder.
    files : paths relative to it, as in the manifest.
    """
    hashes = SourceHashes(folder, files)
    try:
        yield hashes
    finally:
        hashes.stop()


def sources_state(folder: Path, files: Sequence[str], *, settle: bool = False) -> str:
    """Return one digest over the file system's data on the large sources, "" where that cannot show a change.

    Name, device, inode, size, times of change of content and of inode: whoever writes a file without changing these has
    changed the clock of the machine. Of the smallest, `ALWAYS_HASHED` bytes of them together, nothing is taken: their
    content is compared. A file that was changed just now may be changed again within the same tick of the file system's
    clock; not every file system shows what is written through a mapping (`file_systems`). Both must be hashed.

    Parameters
    ----------
    folder : the campaign folder.
    files : paths relative to it.
    settle : have what is written but not yet on the disk written back first, so that whatever comes later shows; for a
        digest that is to be remembered, taken before the files are hashed.
    """
    rows = []
    try:
        compared = _always_compared(folder, files)
        for file in files:
            if file in compared:
                continue
            for path in _parts(folder / file):
                if not shows_mapped_writes(path) or _is_recent(path) or (settle and not write_back(path)):
                    return ""
                if _is_recent(path):
                    return ""
                status = path.stat()
                name = path.relative_to(folder).as_posix()
                times = (status.st_mtime_ns, status.st_ctime_ns)
                rows.append((name, status.st_dev, status.st_ino, status.st_size, *times))
    except OSError:
        return ""
    return hashlib.sha256(repr(rows).encode("utf-8", "surrogateescape")).hexdigest() if rows else ""


def _is_recent(path: Path) -> bool:
    status = path.stat()
    return max(status.st_mtime_ns, status.st_ctime_ns) + RACY_NS > time.time_ns()


def _always_compared(folder: Path, files: Sequence[str]) -> frozenset[str]:
    """Return the sources whose content is compared in every command: the smallest, up to `ALWAYS_HASHED` together."""
    sizes = sorted((sum(path.stat().st_size for path in _parts(folder / file)), file) for file in dict.fromkeys(files))
    compared, total = set(), 0
    for size, file in sizes:
        total += size
        if total > ALWAYS_HASHED:
            break
        compared.add(file)
    return frozenset(compared)


def changed_sources(
    provenance: Provenance,
    folder: Path,
    files: Sequence[str] | None = None,
    thorough: bool = False,
    elsewhere: Sequence[SourceFile] = (),
    known_state: str = "",
) -> SourceChanges:
    """Compare the sources on the disk with those that were read.

    Parameters
    ----------
    provenance : the record of what was read.
    folder : the campaign folder.
    files : what the manifest names now; None: the same as then.
    thorough : hash large files too, whatever the file system's data.
    elsewhere : sources that are no files, as they are now.
    known_state : `sources_state` when they were hashed, from the user's own record and not from the store; where it is
        the present one, no large file is hashed.
    """
    known = {source.file: source for source in provenance.sources}
    outside = {source.file: source.sha256 for source in elsewhere}
    named = list(dict.fromkeys(files)) if files is not None else list(known)
    missing = [file for file in named if not (folder / file).exists()]
    absent = frozenset(missing)
    new = [file for file in named if file not in known and file not in absent]
    new += [name for name in outside if name not in known]
    still = frozenset(named)
    dropped = [file for file in known if file not in still and file not in outside]
    changed = [name for name, digest in outside.items() if name in known and known[name].sha256 != digest]
    settled = not thorough and known_state != "" and known_state == sources_state(folder, named)
    state = known_state if settled else sources_state(folder, named, settle=True)
    always = _always_compared(folder, [file for file in named if file not in absent]) if settled else frozenset(named)
    compared = [file for file in named if file in known and file not in absent and file in always]
    resized = {file for file in compared if _state(folder, file)[0] != known[file].bytes}
    found = {source.file: source for source in _hash_files(folder, [file for file in compared if file not in resized])}
    changed += [file for file in compared if file in resized or found[file].sha256 != known[file].sha256]
    if not settled and state != sources_state(folder, named):  # a source has changed since it was hashed
        state = ""
    return SourceChanges(tuple(changed), tuple(missing), tuple(new), tuple(dropped), state)


def changed_settings(provenance: Provenance, settings: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the settings that differ from the recorded ones, as dotted keys.

    Examples
    --------
    >>> then = Provenance.now("ingest", (), {"robot": {"a": 1, "b": [2]}})
    >>> changed_settings(then, {"robot": {"a": 1, "b": [3]}, "name": "x"})
    ('robot.b', 'name')
    """
    return tuple(_differences(provenance.settings, settings, ""))


def _differences(then: Mapping[str, Any], now: Mapping[str, Any], prefix: str) -> Iterator[str]:
    for key in dict.fromkeys((*then, *now)):
        old, new = then.get(key), now.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from _differences(old, new, f"{prefix}{key}.")
        elif old != new or (key in then) != (key in now):
            yield f"{prefix}{key}"


def _hash_files(folder: Path, files: Sequence[str], stop: threading.Event | None = None) -> list[SourceFile]:
    """Return the hashes of files, each processor taking one at a time: what hashes holds no lock of the interpreter."""
    workers = min(os.cpu_count() or 1, len(files))
    if workers < 2:
        return [_hash_file(folder, file, stop) for file in files]
    with ThreadPoolExecutor(workers, thread_name_prefix="hash sources") as pool:
        waiting = [pool.submit(_hash_file, folder, file, stop) for file in files]
        try:
            return [one.result() for one in waiting]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _hash_file(folder: Path, file: str, stop: threading.Event | None = None) -> SourceFile:
    before = _state(folder, file)
    digest = hashlib.sha256()
    try:
        for path in _parts(folder / file):
            with open_regular(path, file, buffering=0) as stream:
                while (chunk := stream.read(CHUNK)) and not (stop is not None and stop.is_set()):
                    digest.update(chunk)
    except OSError as error:
        raise _unreadable(file, error) from None
    if _state(folder, file) != before:
        raise _changed_meanwhile(file)
    return SourceFile(file, *before, digest.hexdigest())


def _state(folder: Path, file: str) -> tuple[int, int]:
    try:
        states = [path.stat() for path in _parts(folder / file)]
    except OSError as error:
        raise _unreadable(file, error) from None
    return sum(state.st_size for state in states), max((state.st_mtime_ns for state in states), default=0)


def _parts(path: Path) -> list[Path]:
    """Return the files of a log that is a folder, or the file."""
    return sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]


def _unreadable(file: str, error: OSError) -> InputError:
    return InputError.at(
        FaultCode.FILE_UNREADABLE,
        file,
        "",
        f"cannot be read: {error.strerror}",
        "correct the name of the file or its permissions",
    )


def _changed_meanwhile(file: str) -> InputError:
    return InputError.at(
        FaultCode.FILE_CHANGED,
        file,
        "",
        "the file changed while it was read",
        "wait until the log is closed, then ingest",
    )
