"""Spoilt inputs for every log format, every TOML file, addresses, stores and plugins: ``make fuzz``, or

    python -m tests.fuzz [--count 10000] [--seed 1] [--only csv,robot.toml] [--seconds 600] [--first 0] [--input 1234]

Prints a table of what became of them and one line for every kind of fault; ends with 1 where there is one. ``--first``
goes on from there; ``--input`` feeds one input again, with its traceback.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path

from tests.fuzz.feeding import Outcome, feed
from tests.fuzz.targets import formats_not_fed, targets
from tests.laboratory.database import running_server

KINDS = ("refused", "accepted", "traceback", "hang", "memory", "crash", "unclear")


def table_of(outcomes: Sequence[Outcome]) -> str:
    """Return a row for each target."""
    lines = ["".join(head.rjust(14) for head in ("", "inputs", *KINDS, "grown [MB]", "seconds"))]
    for one in outcomes:
        cells = [one.tries, *(one.counts[kind] for kind in KINDS), one.grown >> 20, round(one.seconds)]
        lines.append(one.name.rjust(14) + "".join(str(cell).rjust(14) for cell in cells))
    lines += [f"{one.name}: {line}" for one in outcomes for line in one.found.values()]
    tried = sum(one.tries for one in outcomes)
    lines.append(f"{tried} inputs, {sum(one.faults for one in outcomes)} faults")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Feed the targets."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="the longest time for each target")
    parser.add_argument("--first", type=int, default=0, help="number of the first input; --count is that of the end")
    parser.add_argument("--input", type=int, default=None)
    given = parser.parse_args(arguments)
    chosen = [name for name in targets() if not given.only or name in given.only.split(",")]
    with running_server() if "postgres" in chosen else nullcontext():
        return _feed(chosen, given)


def _show_progress(outcome: Outcome) -> None:
    print(
        f"{outcome.name}: {outcome.tries} inputs, {outcome.faults} faults, {outcome.seconds:.0f} s",
        file=sys.stderr,
        flush=True,
    )


def _feed(chosen: Sequence[str], given: argparse.Namespace) -> int:
    if given.input is not None:
        with tempfile.TemporaryDirectory() as place:
            targets()[chosen[0]](random.Random(f"{chosen[0]} {given.seed} {given.input}"), Path(place))
        return 0
    outcomes = []
    for name in chosen:
        # whole commands take a hundred times as long as one file
        count = max(given.count // 10, 1) if name == "commands" else given.count
        outcomes.append(feed(name, count, given.seed, given.seconds, _show_progress, given.first))
        print(table_of(outcomes[-1:]), flush=True)
    print(table_of(outcomes))
    if formats_not_fed():
        print("not fed: " + ", ".join(formats_not_fed()))
    return 1 if any(one.faults for one in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
