"""`python -m tests.limits`: how answers of the bundled logs move when each number that decides is varied by a fifth.

The logs are reduced with every named number of the reduction, of clocks and holds and of the search for mistakes 20 %
smaller and 20 % larger (a count by one at least), one after the other. Where anything of the reduction changes, the
campaign is identified anew. What no sound log asks for is varied with further logs, some of which have a mistake.
The table of `docs/reference/limits.md` is written by it.

What was found is kept in a file line by line: a call that was ended goes on where it was, as long as no code changed.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from tests.limits.kept import Kept
from tests.limits.logs import LOGS, SOUND
from tests.limits.numbers import numbers
from tests.limits.page import PAGE, written
from tests.limits.varying import asked_in, of_campaign

KEPT = Path(__file__).parents[2] / "build" / "limits.jsonl"


def main(arguments: Sequence[str] | None = None) -> int:
    """Vary all numbers, or those whose place holds a word, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.limits", description=__doc__)
    parser.add_argument("--only", default="", help="numbers whose place holds this; nothing is written then")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kept", type=Path, default=KEPT, help="file of what was found before")
    options = parser.parse_args(arguments)
    chosen = [number for number in numbers() if options.only in number.place]
    places = frozenset(number.place for number in chosen)
    kept = Kept.of_this_code(options.kept)
    with multiprocessing.get_context("spawn").Pool(options.workers) as pool:
        asked = dict(zip(LOGS, pool.imap(partial(asked_in, kept=kept), LOGS, chunksize=1), strict=True))
        varied = varied_in(asked, places)
        found = dict(zip(varied, pool.starmap(partial(of_campaign, kept=kept), varied.items(), 1), strict=True))
    text = written(chosen, found)
    if options.only:
        print(text)
    else:
        PAGE.write_text(text, encoding="utf-8")
    print(f"{kept.seconds():.0f} s of a processor, those of earlier calls included", file=sys.stderr)
    return 0


def varied_in(asked: Mapping[str, frozenset[str]], places: frozenset[str]) -> dict[str, frozenset[str]]:
    """Return the numbers that are varied with each log: with a further one those that none before it asks for."""
    result: dict[str, frozenset[str]] = {}
    before: frozenset[str] = frozenset()
    for name, own in asked.items():
        result[name] = (own if name in SOUND else own - before) & places
        before |= own
    return result


if __name__ == "__main__":
    raise SystemExit(main())
