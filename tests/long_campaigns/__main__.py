"""What `check`, `ingest` and `identify` cost: with N runs and one more, N states of one run or of many, N GB of logs.

python -m tests.long_campaigns runs 100 1000 10000
python -m tests.long_campaigns killed 10000
python -m tests.long_campaigns moved 300
python -m tests.long_campaigns states 12000 200000
python -m tests.long_campaigns rows 20000
python -m tests.long_campaigns gigabytes 0.5 2 8

A log that is hashed, to learn that it has not changed, is opened too: the smallest thousand in every command.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from stiffcal.ingest.reading.run_readings import open_readings
from stiffcal.store import Store
from tests.laboratory.small_campaign import STIFFNESS
from tests.long_campaigns.campaign import MOVED, write_head, write_runs
from tests.long_campaigns.large import CYCLE, write_logs, write_table
from tests.long_campaigns.measure import Cost, cost_of

HEAD = f"{'size':>8}  {'command':<34}{'code':>5}{'processor s':>13}{'wall s':>9}{'peak MB':>9}{'logs':>7}{'log MB':>9}"
Measure = Callable[[str, Path], dict[str, Cost]]


def line_of(size: str, what: str, cost: Cost) -> str:
    """Return a row of the table."""
    return (
        f"{size:>8}  {what:<34}{cost.code:>5}{cost.processor_s:>13.2f}{cost.seconds:>9.2f}{cost.peak_bytes / 1e6:>9.0f}"
        f"{cost.logs_opened:>7}{cost.log_bytes / 1e6:>9.2f}"
    )


def measure_runs(size: str, folder: Path) -> dict[str, Cost]:
    """Write a campaign of so many runs and return what each command on it takes, in order."""
    write_head(folder)
    write_runs(folder, 1, int(size) + 1)
    steps = {"ingest": "ingest", "ingest again": "ingest", "check": "check", "identify": "identify"}
    return _taken(size, folder, steps) | _with_one_more(size, folder)


def _with_one_more(size: str, folder: Path) -> dict[str, Cost]:
    write_runs(folder, int(size) + 1, int(size) + 2)
    more = {"check after one run more": "check", "ingest after one run more": "ingest", "check then": "check"}
    return _taken(size, folder, more | {"identify after one run more": "identify"})


def measure_killed(size: str, folder: Path) -> dict[str, Cost]:
    """Write a campaign of so many runs, kill its ingest once some are kept, and return what each command then takes."""
    write_head(folder)
    write_runs(folder, 1, int(size) + 1)
    with subprocess.Popen(
        [sys.executable, "-m", "stiffcal", "ingest", str(folder), "--json"], stdout=subprocess.DEVNULL
    ) as ingest:
        while ingest.poll() is None and not (folder / "store" / "current").exists():
            time.sleep(0.1)
        ingest.kill()
    print(f"{size:>8}  killed with {_runs_kept(folder)} runs kept", flush=True)
    return _taken(size, folder, {"ingest": "ingest", "check": "check"}) | _with_one_more(size, folder)


def _runs_kept(folder: Path) -> int:
    with open_readings(Store(folder / "store", display_name="store")) as readings:
        return len(readings.runs)


def measure_moved(size: str, folder: Path) -> dict[str, Cost]:
    """Write so many runs of three weeks with a tracker that is moved twice, and return what each command takes.

    How far the stiffnesses are off is printed: where the tracker stood is found from the poses.
    """
    write_head(folder, MOVED)
    write_runs(folder, 1, int(size) + 1, moved=True)
    costs = _taken(size, folder, {"ingest": "ingest", "check": "check", "identify": "identify"})
    command = [sys.executable, "-m", "stiffcal", "identify", str(folder), "--json"]
    found = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)["parameters"]
    off = max(abs(one["stiffness"] / true - 1.0) for one, true in zip(found, STIFFNESS, strict=True))
    print(f"{size:>8}  the worst stiffness is {100.0 * off:.2f} % off", flush=True)
    return costs


def measure_states(size: str, folder: Path) -> dict[str, Cost]:
    """Write a campaign of one run with so many states in a table, and return what each command on it takes."""
    write_table(folder, int(size))
    return _taken(size, folder, {"ingest": "ingest", "check": "check", "identify": "identify"})


def measure_rows(size: str, folder: Path) -> dict[str, Cost]:
    """Write a campaign of a table with so many states, twelve in a run, and return what each command on it takes."""
    write_table(folder, int(size), CYCLE)
    return _taken(size, folder, {"ingest": "ingest", "check": "check", "identify": "identify"})


def measure_gigabytes(size: str, folder: Path) -> dict[str, Cost]:
    """Write a campaign of three runs whose logs have so many GB together, and return what each command on it takes."""
    write_logs(folder, 1e9 * float(size))
    return _taken(size, folder, {"ingest": "ingest", "check": "check", "identify": "identify"})


def _taken(size: str, folder: Path, steps: dict[str, str]) -> dict[str, Cost]:
    costs = {}
    for what, command in steps.items():
        costs[what] = cost_of(folder, command)
        print(line_of(size, what, costs[what]), flush=True)
    return costs


KINDS: dict[str, Measure] = {
    "runs": measure_runs,
    "killed": measure_killed,
    "moved": measure_moved,
    "states": measure_states,
    "rows": measure_rows,
    "gigabytes": measure_gigabytes,
}


def main() -> None:
    """Measure campaigns of the sizes that are given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=list(KINDS))
    parser.add_argument("sizes", nargs="+")
    arguments = parser.parse_args()
    print(HEAD)
    for size in arguments.sizes:
        place = Path(tempfile.mkdtemp(prefix="long-"))
        try:
            KINDS[arguments.kind](size, place / "campaign")
        finally:
            shutil.rmtree(place)


if __name__ == "__main__":
    main()
