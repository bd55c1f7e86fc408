"""All mistakes of the catalogue, and the engine that takes them back one after another."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from functools import lru_cache
from typing import ClassVar, Protocol, TypeVar

from stiffcal.fault_changes import InputChange
from stiffcal.mistakes.mistake import AsRead, Mistake, TakenBack, TriedOn

CATALOGUE = "stiffcal.mistakes.catalogue"


class _Member(Protocol):
    name: ClassVar[str]
    rank: ClassVar[int]


MemberT = TypeVar("MemberT", bound=_Member)


def mistakes_of(base: type[MemberT]) -> tuple[MemberT, ...]:
    """Return the mistakes of one base class in all files of the catalogue, the likelier ones first.

    Examples
    --------
    >>> {"direction", "joint-unit", "row-order"} <= {mistake.name for mistake in mistakes_of(Mistake)}
    True
    """
    every = _found_in(tuple(importlib.import_module(CATALOGUE).__path__))
    found = [member for member in every if isinstance(member, base)]
    return tuple(sorted(found, key=lambda mistake: (mistake.rank, mistake.name)))


@lru_cache(maxsize=8)
def _found_in(folders: tuple[str, ...]) -> tuple[object, ...]:
    """Return one of each class that the files of the catalogue define and name."""
    found: list[object] = []
    for module_info in pkgutil.walk_packages(folders, f"{CATALOGUE}."):
        module = importlib.import_module(module_info.name)
        found += [
            member()
            for _, member in inspect.getmembers(module, inspect.isclass)
            if member.__module__ == module.__name__ and isinstance(getattr(member, "name", None), str)
        ]
    return tuple(found)


def mistakes_on(tried_on: TriedOn) -> tuple[Mistake, ...]:
    """Return the mistakes that may be there, the likelier ones first."""
    return tuple(mistake for mistake in mistakes_of(Mistake) if tried_on in mistake.tried_on)


def taken_back(read: AsRead) -> Iterator[TakenBack]:
    """Yield data with each mistake taken back that may be in them, in all its ways, the likelier mistakes first."""
    for mistake in mistakes_on(read.tried_on):
        for way in mistake.ways(read):
            change = InputChange(mistake.name, way.names, way.sizes, way.value)
            yield TakenBack(mistake, change, way.states, way.chain or read.chain, way.numbers)
