"""Faults in every command that writes: ``make faults``, or

    python -m tests.faults [--tries 400] [--seed 1] [--only ingest,batch] [--kind "disk full"]

Prints a table of what was tried, and every promise that was not kept; ends with 1 where there is one.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from tests.faults.commands import COMMANDS, Command, make_bases
from tests.faults.forking import forker
from tests.faults.trials import KINDS, KINDS_OF_BATCH, Bench, FoundError, Outcome


def kinds_of(command: Command) -> tuple[str, ...]:
    """Return the faults that a command is tried with."""
    return KINDS_OF_BATCH if command.name == "batch" else KINDS


@contextmanager
def bench(commands: Sequence[Command]) -> Iterator[Bench]:
    """Make a bench, in memory where the system has a folder for that: flushing to a busy disk takes its time."""
    memory = Path("/dev/shm")
    parent = memory if memory.is_dir() else None
    with tempfile.TemporaryDirectory(dir=parent, prefix="stiffcal-faults-") as place:
        (Path(place) / "bases").mkdir()
        (Path(place) / "tries").mkdir()
        make_bases(Path(place) / "bases", {command.base for command in commands})
        with forker() as running:
            yield Bench(Path(place) / "bases", Path(place) / "tries", running)


def table_of(outcomes: Sequence[Outcome], found: Sequence[str]) -> str:
    """Return the tries as a table: a row per command, a column per kind of fault; then how they ended."""
    kinds = list(dict.fromkeys((*KINDS, *KINDS_OF_BATCH)))
    tries = Counter((one.command, one.kind) for one in outcomes)
    commands = list(dict.fromkeys(one.command for one in outcomes))
    lines = ["tries".ljust(18) + "".join(kind.rjust(18) for kind in kinds)]
    for command in commands:
        lines.append(command.ljust(18) + "".join(str(tries[command, kind] or "–").rjust(18) for kind in kinds))
    left = Counter(one.left for one in outcomes)
    codes = Counter(one.code for one in outcomes)
    ends = f"{left['before']} left all as it was, {left['after']} all done, {left['between']} between two steps"
    codes_reported = ", ".join(f"{count} × {code}" for code, count in sorted(codes.items()))
    lines.append(f"{len(outcomes)} tries: {ends}; exit codes {codes_reported}; {len(found)} promises not kept")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tries", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="commands, separated by commas")
    parser.add_argument("--kind", help="one kind of fault")
    parser.add_argument("--light", action="store_true", help="leave the slow commands out")
    options = parser.parse_args(arguments)
    chance = random.Random(options.seed)
    names = options.only.split(",") if options.only else [command.name for command in COMMANDS]
    commands = [one for one in COMMANDS if one.name in names and not (options.light and one.heavy)]
    outcomes: list[Outcome] = []
    found: list[str] = []
    began = time.monotonic()
    with bench(commands) as on:
        pairs = [(command, kind) for command in commands for kind in kinds_of(command)]
        pairs = [(command, kind) for command, kind in pairs if options.kind in (None, kind)]
        with suppress(KeyboardInterrupt):  # the table of what was tried so far is worth having
            for number in range(options.tries):
                if number % len(pairs) == 0:
                    chance.shuffle(pairs)
                command, kind = pairs[number % len(pairs)]
                try:
                    outcomes.append(on.try_once(command, kind, chance))
                except FoundError as error:
                    found.append(str(error))
                    outcomes.append(Outcome(command.name, kind, -1, "found"))
                    print(f"NOT KEPT: {error}", flush=True)
    print(table_of(outcomes, found))
    print(f"{time.monotonic() - began:.0f} s")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
