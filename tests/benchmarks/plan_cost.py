"""What `plan` costs: ``python -P -m tests.benchmarks.plan_cost``.

campaigns/irb4400 with 36 parameters (joint compliances, tilts and translations of the bearings), 24 runs, from about
100 and 5000 pairs of pose and load; processor time and largest resident size of the whole command. Growth with the
number of pairs is that of the memory that is in use at most: what a process holds at 5000 pairs is mostly libraries,
and what is kept for reuse after arrays of some 10 MB and given back after larger ones grows in steps.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import tracemalloc
from pathlib import Path
from unittest.mock import patch

from stiffcal.commands.plan import plan_campaign
from stiffcal.planning import candidates
from stiffcal.planning.campaign.request import PlanRequest
from tests.benchmarks.cost import reported, spent_by

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "irb4400"
DIRECTIONS = 6
FEW_S, MANY_S = 2.0, 20.0
# Of the most memory in use with as many pairs over that with half of them: 2 is linear, 4 would be the square.
MEMORY_RATIO = 2.05
MODEL = """schema = "stiffcal/model/1"
[[effects]]
type = "joint-compliance"
joints = "all"
[[effects]]
type = "bearing-tilt"
joints = "all"
[[effects]]
type = "joint-translation"
joints = "all"
"""


def prepared(folder: Path, pairs: int) -> Path:
    """Write the campaign with about so many pairs to choose from."""
    for name in ("campaign.toml", "robot.toml"):
        shutil.copy(CAMPAIGN / name, folder / name)
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    text = f'schema = "stiffcal/plan-input/1"\ncandidates = {-(-pairs // DIRECTIONS)}\n[load]\nforce_N = 450.0\n'
    (folder / "plan.toml").write_text(text, encoding="utf-8")
    return folder


def megabytes_in_use(folder: Path, pairs: int) -> float:
    """Return the most memory that was in use while a plan was made, with poses drawn in two goes as thousands are."""
    tracemalloc.start()
    with patch.object(candidates, "DRAWN_AT_ONCE", pairs // DIRECTIONS // 2 + 1):
        plan = plan_campaign(folder, request=PlanRequest(runs=24, criterion="determinant"))
    assert plan.candidates >= pairs, f"{plan.candidates} of {pairs} pairs were drawn"
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most / 1e6


def main(few: int = 100, many: int = 5000, growth: int = 20_000) -> bool:
    """Print seconds and memory; return whether the limits hold.

    Parameters
    ----------
    few, many : pairs of the timed plans. growth : pairs of the plan whose memory is compared with that of half of them;
        0: of none.
    """
    with tempfile.TemporaryDirectory(prefix="stiffcal-plan-") as place:
        folder = Path(place)
        spent = {
            pairs: spent_by("plan", prepared(folder, pairs), "--runs", "24", "--criterion", "determinant")
            for pairs in (few, many)
        }
        in_use = {pairs: megabytes_in_use(prepared(folder, pairs), pairs) for pairs in (growth // 2, growth) if growth}
    held = [
        reported(f"plan from {few} pairs, 36 parameters", spent[few].seconds, FEW_S, " s"),
        reported(f"plan from {many} pairs, 36 parameters", spent[many].seconds, MANY_S, " s"),
    ]
    sizes = ", ".join(f"{pairs} pairs {entry.megabytes:.0f} MB" for pairs, entry in spent.items())
    print(f"largest resident size: {sizes}")
    if growth:
        print(f"most in use: {', '.join(f'{pairs} pairs {size:.0f} MB' for pairs, size in in_use.items())}")
        ratio = in_use[growth] / in_use[growth // 2]
        held.append(reported("memory of all pairs over that of half of them", ratio, MEMORY_RATIO, " x"))
    return all(held)


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
