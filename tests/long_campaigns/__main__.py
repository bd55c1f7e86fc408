"""What `check`, `ingest` and `identify` cost with N runs, and after one run more.

python -m tests.long_campaigns 100 1000 10000

A log that is hashed, to learn that it has not changed, is opened too: the smallest thousand in every command.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from pathlib import Path

from tests.long_campaigns.campaign import write_head, write_runs
from tests.long_campaigns.measure import Cost, cost_of

HEAD = f"{'runs':>6}  {'command':<34}{'code':>5}{'processor s':>13}{'wall s':>9}{'peak MB':>9}{'logs':>7}{'log MB':>9}"


def line_of(runs: int, what: str, cost: Cost) -> str:
    """Return a row of the table."""
    return (
        f"{runs:>6}  {what:<34}{cost.code:>5}{cost.processor_s:>13.2f}{cost.seconds:>9.2f}{cost.peak_bytes / 1e6:>9.0f}"
        f"{cost.logs_opened:>7}{cost.log_bytes / 1e6:>9.2f}"
    )


def measure(runs: int, folder: Path) -> dict[str, Cost]:
    """Write a campaign of so many runs and return what each command on it takes, in order."""
    write_head(folder)
    write_runs(folder, 1, runs + 1)
    costs = {}

    def take(what: str, *command: str) -> None:
        costs[what] = cost_of(folder, *command)
        print(line_of(runs, what, costs[what]), flush=True)

    take("ingest", "ingest")
    take("ingest again", "ingest")
    take("check", "check")
    take("identify", "identify")
    write_runs(folder, runs + 1, runs + 2)
    take("check after one run more", "check")
    take("ingest after one run more", "ingest")
    take("check then", "check")
    take("identify after one run more", "identify")
    return costs


def main() -> None:
    """Measure campaigns of the numbers of runs that are given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", type=int, nargs="+")
    arguments = parser.parse_args()
    print(HEAD)
    for runs in arguments.runs:
        place = Path(tempfile.mkdtemp(prefix="long-"))
        try:
            measure(runs, place / "campaign")
        finally:
            shutil.rmtree(place)


if __name__ == "__main__":
    main()
