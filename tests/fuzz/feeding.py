"""Feeding inputs by number in a process of its own, so that a crash, a hang or a flood of memory is one input's."""

from __future__ import annotations

import multiprocessing
import os
import random
import resource
import signal
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from types import FrameType

from stiffcal import processes
from stiffcal.errors import InputError
from stiffcal.files import refusal
from tests.fuzz.fence import BrokenFenceError
from tests.fuzz.targets import check_fault, targets

MOST_SECONDS = 10.0  # of a processor for one input: more is a hang
WAITS = 6.0  # so many times as long by the clock: on a busy machine an input that is read at once takes that long
PATIENCE_S = {"commands": 60.0, "stores": 60.0, "plugins": 60.0}
"""Whole commands, the first of which make the campaigns."""
MOST_BYTES = 3 << 30  # of address space above what the process begins with
MOST_GROWN = 600 << 20  # of memory in use, by one input
LIMIT_S = "1"
"""STIFFCAL_MAX_SECONDS: a parser is ended long before its input counts as a hang, even where it shares a processor."""
EVERY = 250  # inputs between two lines of progress
HOPELESS_S = 30.0  # beyond the alarm: code outside Python that never comes back


@dataclass
class Outcome:
    """What became of a target's inputs.

    Attributes
    ----------
    counts : "refused", "accepted", "traceback", "hang", "memory", "crash", "unclear" to how often.
    found : one line for every kind of fault, with the number of the first input that shows it.
    grown : bytes that the process grew by at its largest. seconds : how long all took.
    """

    name: str
    counts: Counter[str] = field(default_factory=Counter)
    found: dict[str, str] = field(default_factory=dict)
    grown: int = 0
    seconds: float = 0.0

    @property
    def tries(self) -> int:
        """How many inputs were fed."""
        return sum(self.counts.values())

    @property
    def faults(self) -> int:
        """How many inputs met anything but acceptance or a clear refusal."""
        return self.tries - self.counts["refused"] - self.counts["accepted"]


class HangError(BaseException):
    """An input takes too long; no `except Exception` may swallow it."""


def feed_one(name: str, seed: int, number: int, folder: Path) -> tuple[str, str]:
    """Feed input ``number`` of a target; return what became of it, and the fault's words where there is one."""
    chance = random.Random(f"{name} {seed} {number}")
    most = PATIENCE_S.get(name, MOST_SECONDS)
    before = {one: signal.signal(one, _too_long) for one in (signal.SIGPROF, signal.SIGALRM)}
    signal.setitimer(signal.ITIMER_PROF, most)
    signal.setitimer(signal.ITIMER_REAL, WAITS * most)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            targets()[name](chance, folder)
    except (InputError, OSError) as error:
        # as `main` does with what a system refuses
        refused = error if isinstance(error, InputError) else refusal(error)
        if refused is None:
            return _traceback(error)
        unclear = check_fault(refused)
        return ("unclear", unclear) if unclear else ("refused", "")
    except HangError:
        return "hang", f"longer than {most:g} s of a processor, or {WAITS * most:g} s by the clock"
    except MemoryError:
        return "memory", "out of memory"
    except (Exception, BrokenFenceError) as error:  # the very thing that is looked for
        return _traceback(error)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for one, handler in before.items():
            signal.signal(one, handler)
    return "accepted", ""


def _traceback(error: BaseException) -> tuple[str, str]:
    last = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in last if "stiffcal" in frame.filename and "tests" not in frame.filename]
    where = own[-1] if own else last[-1]
    return "traceback", f"{type(error).__name__} in {Path(where.filename).name}:{where.lineno}: {str(error)[:160]}"


def _too_long(signum: int, frame: FrameType | None) -> None:
    raise HangError


def _serve(pipe: Connection, other_end: Connection, name: str, seed: int, first: int, count: int) -> None:
    """Feed inputs and send a line before and after each; ends where nobody receives them any more."""
    other_end.close()
    # This copy of the tests' process lacks the thread that starts processes there.
    processes._starter = ThreadPoolExecutor(max_workers=1)
    parent = Path("/dev/shm") if Path("/dev/shm").is_dir() else None
    with tempfile.TemporaryDirectory(prefix="stiffcal-fuzz-", dir=parent) as place:
        os.environ["STIFFCAL_MAX_SECONDS"] = LIMIT_S
        own = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (own + MOST_BYTES, own + MOST_BYTES))
        used = _used()
        for number in range(first, first + count):
            pipe.send(("begins", number, "", 0))
            what, words = feed_one(name, seed, number, Path(place))
            before, used = used, _used()
            if used - before > MOST_GROWN and what in ("refused", "accepted"):
                what, words = "memory", f"grew by {used - before >> 20} MB, then {what}"
            pipe.send((what, number, " ".join(words.split()), used))
    pipe.close()


def _used() -> int:
    """Return the most memory that the process has had in use, in bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << 10


def feed(
    name: str,
    count: int,
    seed: int,
    seconds: float = float("inf"),
    notice: Callable[[Outcome], None] = lambda outcome: None,
    first: int = 0,
) -> Outcome:
    """Feed a target with its inputs ``first`` … ``count`` - 1, or as many as ``seconds`` allow.

    Parameters
    ----------
    name : the target. count, seed : which inputs.
    seconds : after which no further input is fed.
    notice : receives what there is after every `EVERY` inputs.
    first : number of the first input, to go on where another call has ended.
    """
    outcome, began, at = Outcome(name), time.monotonic(), first
    smallest = 0
    context = multiprocessing.get_context("fork")
    while at < count and time.monotonic() - began < seconds:
        here, there = context.Pipe(duplex=False)
        child = context.Process(target=_serve, args=(there, here, name, seed, at, count - at), daemon=True)
        child.start()
        there.close()
        fate = "crash"
        while time.monotonic() - began < seconds:
            try:
                if not here.poll(WAITS * PATIENCE_S.get(name, MOST_SECONDS) + HOPELESS_S):
                    fate = "hang"
                    break
                what, number, words, size = here.recv()
            except EOFError:
                break
            if what == "begins":
                at = number
                continue
            smallest = smallest or size
            outcome.grown = max(outcome.grown, size - smallest)
            outcome.counts[what] += 1
            at = number + 1
            outcome.seconds = time.monotonic() - began
            if outcome.tries % EVERY == 0:
                notice(outcome)
            if words:
                outcome.found.setdefault(
                    words.split(": ")[0] if what == "traceback" else what, f"input {number}: {words}"
                )
        if child.is_alive() and at < count:
            child.kill()
        child.join()
        if at < count and time.monotonic() - began < seconds:  # it died, or never came back, over input `at`
            outcome.counts[fate] += 1
            outcome.found.setdefault(fate, f"input {at}: exit code {child.exitcode}")
            at += 1
    outcome.seconds = time.monotonic() - began
    return outcome
