"""What every mistake is, wherever it is tried."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import ClassVar, Generic, TypeVar

ReadT = TypeVar("ReadT", contravariant=True)
WayT = TypeVar("WayT", covariant=True)


class Mistake(ABC, Generic[ReadT, WayT]):
    """One mistake that people and programs make; a class in a file of `catalogue/` is found and tried.

    It derives from the base class of the place where it is tried, which says what is read there (`ReadT`), and what a
    way of taking a mistake back is (`WayT`): `inputs/`, `runs/`, `rods/`, `clocks/`, `states/`, `places/`.
    """

    name: ClassVar[str]
    """Its own."""
    rank: ClassVar[int] = 100
    """Of mistakes that explain the data alike the one with the smaller number is named: it is made more often."""

    @abstractmethod
    def ways(self, read: ReadT) -> Iterator[WayT]:
        """Yield the data with the mistake taken back, in each way in which it may have been made."""
