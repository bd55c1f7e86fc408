"""What `plan` costs: ``python -P -m tests.benchmarks.plan_cost``.

campaigns/irb4400 with 36 parameters (joint compliances, tilts and translations of the bearings), 24 runs, from about
100 and 5000 pairs of pose and load; processor time and largest resident size of the whole command.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from tests.benchmarks.cost import reported, spent_by

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "irb4400"
DIRECTIONS = 6
FEW, MANY = 100, 5000
FEW_S, MANY_S = 2.0, 20.0
# Of the further memory of all pairs over that of half of them: 2 is linear, 4 would be the square.
MEMORY_RATIO = 2.5
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


def main() -> bool:
    """Print seconds and memory; return whether the limits hold."""
    with tempfile.TemporaryDirectory(prefix="stiffcal-plan-") as place:
        folder = Path(place)
        for name in ("campaign.toml", "robot.toml"):
            shutil.copy(CAMPAIGN / name, folder / name)
        (folder / "model.toml").write_text(MODEL, encoding="utf-8")
        spent = {}
        for pairs in (FEW, MANY // 2, MANY):
            text = (
                f'schema = "stiffcal/plan-input/1"\ncandidates = {-(-pairs // DIRECTIONS)}\n[load]\nforce_N = 450.0\n'
            )
            (folder / "plan.toml").write_text(text, encoding="utf-8")
            spent[pairs] = spent_by("plan", folder, "--runs", "24", "--criterion", "determinant")
    held = [
        reported(f"plan from {FEW} pairs, 36 parameters", spent[FEW].seconds, FEW_S, " s"),
        reported(f"plan from {MANY} pairs, 36 parameters", spent[MANY].seconds, MANY_S, " s"),
    ]
    base = spent[FEW].megabytes
    ratio = (spent[MANY].megabytes - base) / max(1.0, spent[MANY // 2].megabytes - base)
    sizes = ", ".join(f"{pairs} pairs {entry.megabytes:.0f} MB" for pairs, entry in spent.items())
    print(f"memory: {sizes}")
    held.append(reported("further memory of all pairs over that of half of them", ratio, MEMORY_RATIO, " x"))
    return all(held)


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
