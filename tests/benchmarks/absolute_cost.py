"""What absolute poses cost, in-process and on one thread: ``python -P -m tests.benchmarks.absolute_cost``.

Processor seconds of `identify` with the orders of all eccentricities to be found, of 1000 and 11 000 poses; processor
seconds and memory of `diagnose`, which begins when the campaign is identified, of simulated poses with a play in one
joint and of 1000 of the measured poses of a UR10, where they are at hand (``../shared/data/ipa-ur10``). Memory is the
largest resident size of a process of its own.
"""

from __future__ import annotations

import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.benchmarks.cost import make_place_campaign, reported
from tests.identification.test_absolute_speed import campaign

IDENTIFY_S = (1.0, 8.0)
DIAGNOSE_S = 30.0
# Of each pose more: what is kept of some hundred candidates about a dozen models, six numbers each, is 60 kB.
KILOBYTES_PER_POSE = 100.0
CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
ALL_ROWS = CAMPAIGNS.parents[1] / "shared" / "data" / "ipa-ur10" / "measurements_joint_configurations.csv"


def seconds_to_identify(n: int) -> float:
    """Return the processor seconds of a fit of n poses whose eccentricities have neither values nor orders."""
    states, model = campaign(n)
    model = replace(model, placed=tuple(replace(placed, values={}) for placed in model.placed))
    taken = []
    for _ in range(2):
        began = process_time()
        identify_parameters(states, model)
        taken.append(process_time() - began)
    return min(taken)


def make_measured_campaign(folder: Path, rows: int) -> Path:
    """Copy `campaigns/ipa-ur10` with so many rows of the whole table."""
    shutil.copytree(CAMPAIGNS / "ipa-ur10", folder, ignore=shutil.ignore_patterns("store"))
    lines = ALL_ROWS.read_text("utf-8").splitlines(keepends=True)
    (folder / "raw" / "poses.csv").write_text("".join(lines[: rows + 1]), "utf-8")
    return folder


def diagnosed(folder: Path) -> tuple[float, float]:
    """Return processor seconds and MB of a process that diagnoses a campaign after it was identified."""
    command = [sys.executable, "-P", "-m", "tests.benchmarks.absolute_cost", "diagnose", str(folder)]
    root = Path(__file__).parents[2]
    seconds, megabytes = subprocess.run(command, check=True, capture_output=True, text=True, cwd=root).stdout.split()
    return float(seconds), float(megabytes)


def print_diagnosis(folder: Path) -> None:
    """Identify, diagnose, print the seconds of the second and the largest resident size, MB, of both."""
    data = up_to_date_states(folder, RunContext())
    up_to_date_fit(data, RunContext())
    began = process_time()
    diagnose_campaign(folder, RunContext())
    seconds = process_time() - began
    unit = 1024.0**2 if sys.platform == "darwin" else 1024.0
    print(seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit)


def main(few: int = 1000, many: int = 3000, measured: int = 1000, identified: Sequence[int] = (1000, 11_000)) -> bool:
    """Print all figures; return whether all limits hold.

    Parameters
    ----------
    few, many : numbers of simulated poses that are diagnosed. measured : of measured ones; 0 leaves them out.
        identified : of simulated ones that are identified, one for each of `IDENTIFY_S`.
    """
    held = [
        reported(f"identify of {n} poses", seconds_to_identify(n), limit, " s")
        for n, limit in zip(identified, IDENTIFY_S, strict=True)
    ]
    with tempfile.TemporaryDirectory(prefix="stiffcal-absolute-") as place:
        folder = Path(place)
        first, second = (diagnosed(make_place_campaign(folder / f"of-{n}", n)) for n in (few, many))
        held.append(reported(f"diagnose of {few} simulated poses", first[0], DIAGNOSE_S, " s"))
        print(f"diagnose of {many}: {second[0]:.3g} s; {first[1]:.0f} and {second[1]:.0f} MB")
        growth = 1e3 * (second[1] - first[1]) / (many - few)
        held.append(reported("  memory of each pose more", growth, KILOBYTES_PER_POSE, " kB"))
        if measured and ALL_ROWS.is_file():
            seconds, megabytes = diagnosed(make_measured_campaign(folder / "ur10", measured))
            held.append(reported(f"diagnose of {measured} measured poses", seconds, DIAGNOSE_S, " s"))
            print(f"  its memory: {megabytes:.0f} MB")
    return all(held)


def run(arguments: Sequence[str]) -> int:
    """Run all, or with ``diagnose FOLDER`` the process that is measured."""
    if len(arguments) == 2 and arguments[0] == "diagnose":
        print_diagnosis(Path(arguments[1]))
        return 0
    return 0 if main() else 1


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
