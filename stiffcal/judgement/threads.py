"""Work on several cores, its results in the order of what it was asked of: the same as of one core."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")
U = TypeVar("U")


def in_order(function: Callable[[T], U], items: Iterable[T], jobs: int) -> Iterator[U]:
    """Give what a function returns of each item, so many at once: array operations of one leave the others running.

    Parameters
    ----------
    function : changes nothing that another call reads. items : all of them are read at once. jobs : 1: one by one.
    """
    if jobs == 1:
        yield from map(function, items)
        return
    pool = ThreadPoolExecutor(jobs)
    try:
        yield from pool.map(function, items)
    finally:
        pool.shutdown(cancel_futures=True)
