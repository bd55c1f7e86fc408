"""All mistakes of the catalogue, found by walking."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, TypeVar

from stiffcal.mistakes.mistake import Mistake

CATALOGUE = "stiffcal.mistakes.catalogue"


ReadT = TypeVar("ReadT")
WayT = TypeVar("WayT")
MistakeT = TypeVar("MistakeT", bound=Mistake[Any, Any])


def mistakes_of(base: type[MistakeT]) -> tuple[MistakeT, ...]:
    """Return the mistakes of one base class in all files of the catalogue, the likelier ones first.

    Examples
    --------
    >>> from stiffcal.mistakes.clocks.mistake import ClockMistake
    >>> [mistake.name for mistake in mistakes_of(ClockMistake)]
    ['shifted', 'drifting', 'jumping']
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


def ways_of(base: type[Mistake[ReadT, WayT]], read: ReadT) -> Iterator[tuple[Mistake[ReadT, WayT], WayT]]:
    """Yield each mistake of one base class with each way of taking it back from what was read, the likelier first."""
    for mistake in mistakes_of(base):
        yield from ((mistake, way) for way in mistake.ways(read))
