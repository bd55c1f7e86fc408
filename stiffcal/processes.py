"""Independent tasks shared out to several processes; the same results whatever their number."""

from __future__ import annotations

import multiprocessing
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import TypeVar

T = TypeVar("T")

# Processes at most: more would wait for memory.
MOST_PROCESSES = 4


def run_in_processes(tasks: Sequence[Callable[[], T]], processes: int | None = None) -> list[T]:
    """Run tasks that do not depend on each other, and return what they return, in their order.

    Processes are split off (fork), so that tasks may refer to whatever is loaded; what they return is pickled. A task
    that fails in a process of its own is run again in this one, and raises here what it raised there.

    Parameters
    ----------
    tasks : functions without arguments.
    processes : how many run them; None: as many as processors, where a process can be split.
    """
    count = min(usable_processes() if processes is None else processes, MOST_PROCESSES, len(tasks))
    if count < 2:
        return [task() for task in tasks]
    split = multiprocessing.get_context("fork")
    answers: dict[int, T] = {}
    helpers = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads in libraries that the tasks do not use
        for first in range(1, count):
            receiving, sending = split.Pipe(duplex=False)
            helper = split.Process(target=_run_share, args=(tasks, range(first, len(tasks), count), sending))
            helper.start()
            sending.close()
            helpers.append((helper, receiving))
    try:
        for number in range(0, len(tasks), count):
            answers[number] = tasks[number]()
        for _, receiving in helpers:
            with suppress(EOFError, OSError):
                answers.update(receiving.recv())
    finally:
        for helper, receiving in helpers:
            receiving.close()
            if sys.exc_info()[0] is not None:
                helper.terminate()
            helper.join()
    return [answers[number] if number in answers else tasks[number]() for number in range(len(tasks))]


def _run_share(tasks: Sequence[Callable[[], T]], numbers: Sequence[int], answers: Connection) -> None:
    """Run some tasks and send their answers by number, once: a pipe holds little until it is read."""
    done: dict[int, T] = {}
    # What fails here is run again where its failure can be reported.
    with suppress(BaseException):
        for number in numbers:
            done[number] = tasks[number]()
    answers.send(done)
    answers.close()


def usable_processes() -> int:
    """Return the number of processors that this process may use; 1 where a process cannot be split safely."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else 1
