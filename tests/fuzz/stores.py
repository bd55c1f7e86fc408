"""A store that came with a campaign folder: any document, table, index or link of it spoilt, with right hashes or not.

Then it is read in every way, and a command runs on it: it ends as commands end, touches nothing outside the folder, and
what the store's author has written is never shown as the user's own.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import random
import shutil
from collections.abc import Callable
from contextlib import redirect_stderr, suppress
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from stiffcal.batch.task import run_task
from stiffcal.results.batch_results import FAULT, HELD, BatchTask
from stiffcal.stages.stored import stored_document
from stiffcal.store import Store
from stiffcal.trust.record import open_record
from tests.fuzz.fence import FENCE
from tests.fuzz.mutations import NASTY_TEXTS, spoilt_bytes, spoilt_document
from tests.fuzz.running import fresh_folder, fresh_state, run_fenced
from tests.fuzz.wrong_numbers import command_ends

PREDICTION = ("--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0")
SHOWING = (
    "identify {c} --json", "identify {c}", "validate {c} --json", "validate {c}", "history {c} --json", "history {c}",
    "history {c} --restore 1 --yes", "history {c} --restore 1", "plot {c} -o {f}/p.svg", "export {c} -o {f}/s.csv",
    "export {c} -o {f}/m.json", "predict {c} --poses {f}/poses.csv", "check {c}", "trust {c}",
    "diagnose {c} --no-update", "identify {c} --no-update --json", "batch {c}", "batch {c}",
)  # fmt: skip
WITH_LOGS = ("identify {c} --json", "validate {c} --json", "ingest {c}", "batch {c}")
TEXTS = (
    *NASTY_TEXTS, "../outside", "../../outside/secret", "generations", "..", "/", "a/../../b", "store/current",
    "history",
    "recordings/../identify", "\x1b[2J", "=1+1", "<script>", "con", "a" * 300, "\u202e", "stiffcal/identify/99",
)  # fmt: skip
TYPES = (pa.string(), pa.float64(), pa.int64(), pa.bool_(), pa.float32(), pa.binary(), pa.null(), pa.list_(pa.int8()))
POSES = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz\n0,-70,20,0,30,0,10,20,-100\n"


def base(place: Path) -> Path:
    """Return a campaign that a stranger has validated and diagnosed, made where it is not there yet."""
    from stiffcal.commands.diagnose import diagnose_campaign
    from stiffcal.commands.validate import validate_campaign
    from stiffcal.documents import document_of
    from tests.laboratory.small_campaign import write_small_campaign

    folder = place / "base"
    if not (place / "true.json").exists():
        shutil.rmtree(folder, ignore_errors=True)
        with fresh_state(place / "stranger"):
            write_small_campaign(folder, poses=2)
            diagnose_campaign(folder)
            command_ends(["predict", str(folder), *PREDICTION])
            true = document_of(validate_campaign(folder).rms)
            (place / "true.json").write_text(json.dumps(true), encoding="utf-8")
    return folder


def feed_store(chance: random.Random, place: Path) -> None:
    """Spoil a store, read it, and look at what is made of it."""
    source, folder = base(place), fresh_folder(place)
    campaign = Path(shutil.copytree(source, folder / "c", symlinks=True))
    (folder / "poses.csv").write_text(POSES, encoding="utf-8")
    digest = hashlib.sha256((_generation(campaign) / "generation.json").read_bytes()).hexdigest()
    whose = chance.choice(("stranger", "stranger", "trusted", "own"))
    for _ in range(chance.choice((1, 1, 2, 3))):
        spoil(chance, campaign, sealed=whose != "own" and chance.random() < 0.8)
    with fresh_state(folder / "state"):
        if whose == "trusted":
            open_record().allow_place(str(campaign / "store"))
        if whose == "own":
            from stiffcal.store.origin import remember

            remember(digest, "")
        if chance.random() < 0.75:
            with FENCE.around((folder,), place / "outside"), redirect_stderr(io.StringIO()):
                read_all(campaign)
            return
        logs = chance.random() < 0.05
        if not logs:
            shutil.rmtree(campaign / "raw")
        words = chance.choice(WITH_LOGS if logs else SHOWING).format(c=campaign, f=folder).split()
        if words[0] == "batch":
            with FENCE.around((folder,), place / "outside"), redirect_stderr(io.StringIO()):
                outcome = run_task(BatchTask(folder=str(campaign), campaign="c", report=False))
            if outcome.state == FAULT or (outcome.state == HELD and whose == "stranger" and not logs):
                raise AssertionError(f"{outcome.state}: {outcome.error}")
            return
        code, document = run_fenced(words, folder)
    if document is not None and whose == "stranger":
        _judge(words[0], document, code, json.loads((place / "true.json").read_text(encoding="utf-8")))


def _judge(command: str, document: dict[str, Any], code: int, true: dict[str, float]) -> None:
    """Look at whether a stranger's results are shown as the user's own."""
    if command == "history":
        if any(fit["origin"] == "own" for fit in document["fits"]):
            raise AssertionError("a stranger's fit is shown as own")
    elif command in ("identify", "validate"):
        own = document["origin"] == "own"
        if command == "validate" and not own and (document["passed"] or (code == 0 and document["checks"])):
            raise AssertionError("a stranger's result is held")
        same = all(math.isclose(document["rms"][key], value, rel_tol=1e-6) for key, value in true.items())
        if command == "validate" and own and not same:
            raise AssertionError("a stranger's result is shown as own")


def read_all(campaign: Path) -> None:
    """Read all that there is in a store, as commands do."""
    store = Store(campaign / "store", "store")
    # A store that is a link is refused with the campaign; here it would be a place that the user has named.
    if (campaign / "store").is_symlink() or not store.exists:
        return
    for name in store.documents:
        stored_document(store, name)
    with store.snapshot() as snapshot:
        snapshot.damaged()
        snapshot.origin_of(*snapshot.documents)
        for name in snapshot.tables:
            for _ in snapshot.read_batches(name):
                pass
            snapshot.read_table(name)


def _generation(campaign: Path) -> Path:
    return next(path for path in (campaign / "store" / "generations").iterdir())


def spoil(chance: random.Random, campaign: Path, sealed: bool) -> None:
    """Spoil something of a store; `sealed`: size and hash in its index are made right again."""
    # what an earlier one has removed or spoilt
    with suppress(OSError, StopIteration, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        generation = _generation(campaign)
        files = sorted(path for path in generation.rglob("*") if path.is_file() and path.name != "generation.json")
        (act,) = chance.choices((_spoil_document, _spoil_table, _spoil_index, _spoil_links), (6, 3, 4, 3))
        act(chance, campaign, generation, files)
        if sealed and act is not _spoil_index:
            seal(generation)


def seal(generation: Path) -> None:
    """Write size and SHA-256 of every file into the index, as somebody might who knows the format."""
    path = generation / "generation.json"
    if not path.is_file():
        return
    index = json.loads(path.read_bytes())
    for kind, ending in (("tables", ".parquet"), ("documents", ".json")):
        for name, entry in index[kind].items():
            file = generation / f"{name}{ending}"
            if file.is_file():
                content = file.read_bytes()
                entry |= {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    path.write_text(json.dumps(index), encoding="utf-8")


def _spoil_document(chance: random.Random, campaign: Path, generation: Path, files: list[Path]) -> None:
    path = chance.choice([file for file in files if file.suffix == ".json"])
    content = path.read_bytes()
    draw = chance.random()
    if draw < 0.7:
        content = json.dumps(_spoilt(chance, json.loads(content))).encode("utf-8", "surrogatepass")
    elif draw < 0.85:
        content = spoilt_bytes(chance, content)
    else:
        deep = chance.choice((50, 5000, 200_000))
        numbers = (b"9" * 400, b"1e999", b"NaN", b"-Infinity", b"9" * 5000, b"[" * deep + b"]" * deep)
        odd = (*numbers, b'{"a":' * deep, b"null", b"[]", b'""', b"{}", b"", b"\xff\xfe", b'{"schema": 5}')
        content = chance.choice((b"%s", b'{"schema": %s}', b'{"fits": [%s]}', b'{"fits": [{"id": %s}]}')).replace(
            b"%s", chance.choice(odd)
        )
    path.write_bytes(content)


def _spoilt(chance: random.Random, document: dict[str, Any]) -> dict[str, Any]:
    changed = spoilt_document(chance, document)
    if chance.random() < 0.3:
        changed[chance.choice(list(changed) or ["schema"])] = chance.choice(TEXTS)
    return changed


def _spoil_table(chance: random.Random, campaign: Path, generation: Path, files: list[Path]) -> None:
    path = chance.choice([file for file in files if file.suffix == ".parquet"])
    if chance.random() < 0.4:
        path.write_bytes(spoilt_bytes(chance, path.read_bytes()))
        return
    table = parquet.read_table(path)
    column = chance.randrange(table.num_columns)
    name, values = table.column_names[column], table.column(column)
    new: pa.Array
    match chance.randrange(8):
        case 0:
            table = table.remove_column(column)
        case 1:
            names = list(table.column_names)
            names[column] = chance.choice((*TEXTS[:40], names[0]))
            table = table.rename_columns([text.encode("utf-8", "replace").decode() for text in names])
        case 2:
            table = table.slice(0, chance.choice((0, 1, 2)))
        case 3:
            table = pa.concat_tables([table] * chance.choice((2, 30)))
        case 4:
            new = pa.nulls(table.num_rows, chance.choice(TYPES))
            table = table.set_column(column, name, new)
        case 5 if pa.types.is_floating(values.type):
            odd = chance.choice((math.nan, math.inf, -1e308, 1e-320, 0.0))
            new = pa.array([odd] * table.num_rows, values.type)
            table = table.set_column(column, name, new)
        case 6:
            new = pa.array([chance.choice(TEXTS).encode("utf-8", "replace").decode() for _ in range(table.num_rows)])
            table = table.set_column(column, name, new)
        case _:
            with suppress(pa.ArrowInvalid, pa.ArrowNotImplementedError):
                table = table.set_column(column, name, values.cast(chance.choice(TYPES), safe=False))
    parquet.write_table(table, path)


def _spoil_index(chance: random.Random, campaign: Path, generation: Path, files: list[Path]) -> None:
    path = generation / "generation.json"
    if not path.is_file():
        return
    index = json.loads(path.read_bytes())
    kind = chance.choice(("tables", "documents"))
    listed = index[kind]
    name = chance.choice(sorted(listed))
    match chance.randrange(6):
        case 0:
            listed[chance.choice(TEXTS)] = listed.pop(name)
        case 1:
            listed[chance.choice(TEXTS)] = dict(listed[name])
        case 2:
            listed[name] |= {
                chance.choice(("file", "bytes", "rows", "sha256", "origin")): chance.choice((*TEXTS, 0, -1, 10**30))
            }
        case 3:
            other = chance.choice(("tables", "documents"))
            index[other][name] = listed.pop(name)
        case 4:
            path.write_bytes(spoilt_bytes(chance, path.read_bytes()))
            return
        case _:
            index = _spoilt(chance, index)
    path.write_bytes(json.dumps(index).encode("utf-8", "surrogatepass"))


def _spoil_links(chance: random.Random, campaign: Path, generation: Path, files: list[Path]) -> None:
    store, outside = campaign / "store", campaign.parents[1] / "outside"
    places = (store / "current", store / "current.id", store / "generations", store / "lock", generation, *files)
    places = (*places, generation / "generation.json", store, store / "set-aside", generation / "new")
    path = chance.choice(places)
    text = chance.choice(
        (f"../{outside.name}", generation.name, "..", "x" * 200, "\xff", "", f"{generation.name}/../x")
    )
    acts: list[Callable[[], object]] = [
        lambda: path.symlink_to(outside),
        lambda: path.symlink_to(outside / "secret.json"),
        lambda: path.symlink_to(path.name),
        lambda: path.symlink_to("/dev/zero"),
        lambda: path.symlink_to(Path("generations", generation.name)),
        lambda: path.mkdir(),
        lambda: path.write_text(text, encoding="latin-1"),
        lambda: path.write_text(text, encoding="latin-1"),
        lambda: None,
    ]
    if hasattr(os, "mkfifo"):
        acts.append(lambda: os.mkfifo(path))
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path) if chance.random() < 0.5 else path.rename(path.with_name("moved"))
    else:
        path.unlink(missing_ok=True)
    chance.choice(acts)()
