"""What the commands answer, recorded for any revision, and the answers of two revisions compared.

::

    python -m tests.answers record HEAD~20 build/answers/before
    python -m tests.answers record HEAD    build/answers/after
    python -m tests.answers compare build/answers/before build/answers/after

    python -m tests.answers shifts  build/answers/before build/answers/after

``record`` runs the commands on all bundled campaigns and on those of `variants` (minutes to an hour; ``--subset`` takes
one of each kind, ``--only NAME`` some of them); ``--campaigns REVISION`` takes the campaigns of another revision, so
that both are asked the same. ``compare`` prints every difference and returns 1 where there is one. ``shifts`` prints
how far values moved in standard uncertainties, and which verdicts changed; it returns 1 above 0.01 and where one did.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.answers.compare import differences
from tests.answers.record import record
from tests.answers.shifts import compare_campaign, recorded


def main(arguments: Sequence[str] | None = None) -> int:
    """Record or compare; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    actions = parser.add_subparsers(dest="action", required=True)
    recording = actions.add_parser("record", help="run the commands of a revision and write down what they answer")
    recording.add_argument("revision")
    recording.add_argument("folder", type=Path)
    recording.add_argument("--campaigns", metavar="REVISION", help="where the campaigns are from; default: the same")
    recording.add_argument("--only", action="append", metavar="NAME", help="only campaigns whose name begins so")
    recording.add_argument("--subset", action="store_true", help="one campaign of each kind")
    recording.add_argument("--workers", type=int, default=2)
    for action, does in (
        ("compare", "print the differences of two recordings"),
        ("shifts", "print shifts of parameters in standard uncertainties, and changed verdicts"),
    ):
        comparing = actions.add_parser(action, help=does)
        comparing.add_argument("before", type=Path)
        comparing.add_argument("after", type=Path)
    options = parser.parse_args(arguments)
    if options.action == "record":
        record(options.revision, options.folder, options.campaigns, options.only, options.workers, options.subset)
        return 0
    if options.action == "shifts":
        compared = [compare_campaign(name, *pair) for name, pair in recorded(options.before, options.after).items()]
        for campaign in compared:
            print("\n".join(campaign.lines()))
        failed = [campaign.name for campaign in compared if not campaign.holds]
        print(f"{len(compared)} campaigns, {len(failed)} differ" + (f": {', '.join(failed)}" if failed else ""))
        return 1 if failed else 0
    found = differences(options.before, options.after)
    for line in found:
        print(line)
    print(f"{len(found)} differences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
