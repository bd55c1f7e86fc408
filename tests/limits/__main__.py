"""`python -m tests.limits`: how answers of the bundled logs move when each number that decides is varied by a fifth.

The logs are reduced with every named number of the reduction, of clocks and holds and of the search for mistakes 20 %
smaller and 20 % larger (a count by one at least), one after the other. Where anything of the reduction changes, the
campaign is identified anew. The table of `docs/reference/limits.md` is written by it.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Sequence
from functools import partial

from tests.limits.numbers import numbers
from tests.limits.page import PAGE, written
from tests.limits.varying import TRIED, of_campaign


def main(arguments: Sequence[str] | None = None) -> int:
    """Vary all numbers, or those whose place holds a word, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.limits", description=__doc__)
    parser.add_argument("--only", default="", help="numbers whose place holds this; nothing is written then")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args(arguments)
    chosen = [number for number in numbers() if options.only in number.place]
    with multiprocessing.get_context("spawn").Pool(options.workers) as pool:
        found = dict(zip(TRIED, pool.imap(partial(of_campaign, only=options.only), TRIED, chunksize=1), strict=True))
    text = written(chosen, found)
    if options.only:
        print(text)
    else:
        PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
