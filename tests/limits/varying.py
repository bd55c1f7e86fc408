"""One campaign's logs, reduced with every number smaller and larger."""

from __future__ import annotations

import hashlib
import pickle
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.steps import RunContext
from stiffcal.store.provenance import IngestSettings
from tests.limits.kept import Kept, digest
from tests.limits.logs import LOGS
from tests.limits.numbers import ROOMS, Number, numbers
from tests.limits.page import Moved

FACTORS = (0.8, 1.2)


def asked_in(name: str, kept: Kept) -> frozenset[str]:
    """Return the places of the numbers that one campaign's logs ask for, when they are reduced and identified."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "campaign"
        log = prepared(name, folder)
        if kept.asked(log) is None:
            begun = time.process_time()
            reduced(folder), identified(folder)  # modules that are imported on the way
            in_reduction = _asked_by(lambda: reduced(folder))
            kept.keep_asked(
                log, in_reduction, _asked_by(lambda: identified(folder)) - in_reduction, time.process_time() - begun
            )
        return frozenset().union(*(kept.asked(log) or ()))


def of_campaign(name: str, places: frozenset[str], kept: Kept) -> dict[str, tuple[Moved, Moved]]:
    """Return by place how answers of one campaign move, smaller and larger, of the numbers at these places."""
    if not places:
        return {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "campaign"
        log = prepared(name, folder)
        result = {place: moved for place, moved in kept.moved(log).items() if place in places}
        left = places - result.keys()
        _, only_identified = kept.asked(log) or (frozenset(), frozenset())
        if not left:
            return result
        before, first = reduced(folder), identified(folder)
        for number in numbers():
            if number.place not in left:
                continue
            begun, moved = time.process_time(), list[Moved]()
            for factor in FACTORS:
                with varied(number, factor):
                    after = reduced(folder)
                    same = after == before and number.place not in only_identified
                    moved.append(Moved() if same else compared(first, identified(folder)))
            result[number.place] = (moved[0], moved[1])
            kept.keep_moved(log, number.place, result[number.place], time.process_time() - begun)
            print(name, number.place, *moved, file=sys.stderr, flush=True)
        return result


def prepared(name: str, folder: Path) -> str:
    """Write one campaign's logs into a new folder; return its name and what stands in its files."""
    LOGS[name](folder)
    return f"{name} {digest(file for file in sorted(folder.rglob('*')) if file.is_file())}"


def reduced(folder: Path) -> str:
    """Return a digest of all that the reduction makes of a campaign's logs."""
    try:
        made = reduce_campaign(load_campaign(folder), no_progress)
    except InputError as error:
        return str(error)
    tables = made.non_load.tables(IngestSettings(manifest={}, robot={}, revision=0))
    kept = made.states, made.result, {key: table.to_pydict() for key, table in sorted(tables.items())}
    return hashlib.sha256(pickle.dumps(kept, protocol=5)).hexdigest()


def identified(folder: Path) -> IdentifyResult | str:
    """Return the answer of ``identify`` with a new store; what is refused, where it is."""
    store = folder.parent / "store"
    shutil.rmtree(store, ignore_errors=True)
    try:
        return identify_campaign(folder, RunContext(store=str(store)))
    except InputError as error:
        return str(error)


def compared(before: IdentifyResult | str, after: IdentifyResult | str) -> Moved:
    """Return how an answer differs from the one before."""
    if isinstance(before, str):
        return Moved(named=before != after)
    if isinstance(after, str):
        return Moved(refused=True)
    old = {one.name: one for one in before.parameters}
    shifts = []
    for one in after.parameters:
        was = old.get(one.name)
        if was is not None and was.std and was.value is not None and one.value is not None:
            shifts.append(abs(one.value - was.value) / was.std)
    same_names = [one.name for one in before.parameters] == [one.name for one in after.parameters]
    return Moved(
        states=after.n_states - before.n_states,
        sigma=max(shifts, default=0.0),
        other=not same_names or set_aside(before) != set_aside(after),
    )


def set_aside(answer: IdentifyResult) -> list[tuple[str, int]]:
    """Return runs and rows of the states that were not used."""
    return [(one.run, one.row) for one in answer.rejected]


@contextmanager
def varied(number: Number, factor: float) -> Iterator[None]:
    """Change a number wherever it was imported to."""
    value = number.times(factor)
    places = [module for module in _package() if getattr(module, number.name, None) is number.value]
    for module in places:
        setattr(module, number.name, value)
    _forget()
    try:
        yield
    finally:
        for module in places:
            setattr(module, number.name, number.value)
        _forget()


def _asked_by(work: Callable[[], Any]) -> frozenset[str]:
    """Return the places of the numbers that the functions of a piece of work ask for."""
    asked = names_asked_by(work)
    return frozenset(
        number.place
        for number in numbers()
        if number.name in asked.get(number.module, ()) or _asked_elsewhere(number, asked)
    )


def names_asked_by(work: Callable[[], Any]) -> Mapping[str, set[str]]:
    """Return by module the names that the functions of a piece of work ask for."""
    codes: set[tuple[str, CodeType]] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        name = frame.f_globals.get("__name__", "")
        if event == "call" and name.startswith("stiffcal."):
            codes.add((name, frame.f_code))

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    asked: dict[str, set[str]] = {}
    for name, code in codes:
        asked.setdefault(name, set()).update(code.co_names)
    return asked


def _asked_elsewhere(number: Number, asked: Mapping[str, set[str]]) -> bool:
    """Return whether a module that imported a number has a function that asks for it."""
    return any(
        number.name in asked.get(module.__name__, ()) and getattr(module, number.name, None) is number.value
        for module in _package()
    )


def _package() -> list[ModuleType]:
    return [module for name, module in list(sys.modules.items()) if name.startswith("stiffcal.") and module is not None]


def _forget() -> None:
    """Forget what functions of these rooms keep of earlier calls."""
    rooms = tuple(f"stiffcal.{room.removesuffix('.py').replace('/', '.')}" for room in ROOMS)
    for module in _package():
        for value in list(vars(module).values()) if module.__name__.startswith(rooms) else []:
            clear = getattr(value, "cache_clear", None)
            if clear is not None:
                clear()
