"""All mistakes of the catalogue, and the engine that takes them back one after another."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from functools import lru_cache

from stiffcal.fault_changes import InputChange
from stiffcal.mistakes.mistake import AsRead, Mistake, TakenBack, TriedOn

CATALOGUE = "stiffcal.mistakes.catalogue"


def all_mistakes() -> tuple[Mistake, ...]:
    """Return the mistakes of all files of the catalogue, the likelier ones first.

    Examples
    --------
    >>> {"direction", "joint-unit", "row-order"} <= {mistake.name for mistake in all_mistakes()}
    True
    """
    return _found_in(tuple(importlib.import_module(CATALOGUE).__path__))


@lru_cache(maxsize=8)
def _found_in(folders: tuple[str, ...]) -> tuple[Mistake, ...]:
    found: list[Mistake] = []
    for module_info in pkgutil.walk_packages(folders, f"{CATALOGUE}."):
        module = importlib.import_module(module_info.name)
        found += [
            member()
            for _, member in inspect.getmembers(module, inspect.isclass)
            if issubclass(member, Mistake) and member.__module__ == module.__name__
        ]
    return tuple(sorted(found, key=lambda mistake: (mistake.rank, mistake.name)))


def mistakes_on(tried_on: TriedOn) -> tuple[Mistake, ...]:
    """Return the mistakes that may be there, the likelier ones first."""
    return tuple(mistake for mistake in all_mistakes() if tried_on in mistake.tried_on)


def taken_back(read: AsRead) -> Iterator[TakenBack]:
    """Yield data with each mistake taken back that may be in them, in all its ways, the likelier mistakes first."""
    for mistake in mistakes_on(read.tried_on):
        for way in mistake.ways(read):
            change = InputChange(mistake.name, way.names, way.sizes, way.value)
            yield TakenBack(mistake, change, way.states, way.chain or read.chain, way.numbers)
