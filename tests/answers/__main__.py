"""What the commands answer, recorded for any revision, and the answers of two revisions compared.

::

    python -m tests.answers record HEAD~20 build/answers/before
    python -m tests.answers record HEAD    build/answers/after
    python -m tests.answers compare build/answers/before build/answers/after

``record`` runs the commands on all bundled campaigns (minutes to an hour; ``--only NAME`` takes some of them);
``--campaigns REVISION`` takes the campaigns of another revision, so that both are asked the same.
``compare`` prints every difference and returns 1 where there is one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.answers.compare import differences
from tests.answers.record import record


def main(arguments: Sequence[str] | None = None) -> int:
    """Record or compare; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    actions = parser.add_subparsers(dest="action", required=True)
    recording = actions.add_parser("record", help="run the commands of a revision and write down what they answer")
    recording.add_argument("revision")
    recording.add_argument("folder", type=Path)
    recording.add_argument("--campaigns", metavar="REVISION", help="where the campaigns are from; default: the same")
    recording.add_argument("--only", action="append", metavar="NAME", help="only campaigns whose name begins so")
    recording.add_argument("--workers", type=int, default=2)
    comparing = actions.add_parser("compare", help="print the differences of two recordings")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    options = parser.parse_args(arguments)
    if options.action == "record":
        record(options.revision, options.folder, options.campaigns, options.only, options.workers)
        return 0
    found = differences(options.before, options.after)
    for line in found:
        print(line)
    print(f"{len(found)} differences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
