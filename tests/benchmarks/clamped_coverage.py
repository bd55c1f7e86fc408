"""campaigns/kr125 over many seeds: how often Table 2 lies within the 95 % that `identify` states.

    python -m tests.benchmarks.clamped_coverage [--seeds 22] [--first 1000]

The robot is played once, on finer steps than the campaign's own; each seed draws new instruments and clocks.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.documents import document_of
from stiffcal.kinds.clamped.simulated.simulation import simulate_clamped
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from tests.laboratory.kr125 import DEGREE, TABLE_2, source_folder
from tests.whole_campaigns.test_kr125 import joint_of, values

POINTS = 480
NAMES = ("p1", "p2", "p3")


def judged(document: dict[str, Any], joint: int) -> tuple[list[float], float, float, bool]:
    """Return errors of p1, p2, p3 over their std, that of b in degrees, the play's in degrees, and whether left out."""
    play, p3, p2, p1 = TABLE_2[joint]
    truth = np.array([1e3 * p1 / DEGREE, 1e3 * p2 / DEGREE**2, 1e3 * p3 / DEGREE**3])
    reported = joint_of(document, joint)
    found = np.array([reported["curve"][name] for name in NAMES])
    std = np.sqrt(np.diag(np.array(reported["curve"]["covariance"])))
    width = values(document)[f"backlash.j{joint}.width"]["value"]
    poor = [one["run"] for one in reported["left_out"]] == ([f"c-joint{joint}"] if joint in (2, 3) else [])
    return list((found - truth) / std), width / DEGREE - play, reported["low_slope"] / DEGREE - play, poor


def main(arguments: Sequence[str] | None = None) -> None:
    """Play, identify and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=22)
    parser.add_argument("--first", type=int, default=1000)
    wanted = parser.parse_args(arguments)
    runs = tuple(f"{pose}-joint{joint}" for pose in "abc" for joint in TABLE_2)
    played: dict[str, Any] = {}

    def once(robot: Any, act: Any, *rest: Any) -> Any:
        if act.name not in played:
            played[act.name] = simulate_clamped(robot, act, *rest)
        return played[act.name]

    errors, widths, plays, poor = [], [], [], []
    with (
        tempfile.TemporaryDirectory() as folder,
        mock.patch("stiffcal.kinds.clamped.simulated.simulation.simulate_clamped", once),
    ):
        source = source_folder(
            Path(folder) / "source",
            runs,
            settings=lambda text: text.replace("rest_s = 1.5", f"rest_s = 1.5\npoints = {POINTS}"),
        )
        for seed in range(wanted.first, wanted.first + wanted.seeds):
            out = Path(folder) / str(seed)
            simulate_campaign(load_campaign(source, check_files=False), load_settings(source), out, seed=seed)
            document = document_of(identify_campaign(out))
            shutil.rmtree(out)
            each = [judged(document, joint) for joint in TABLE_2]
            errors.append([one[0] for one in each])
            widths.append([one[1] for one in each])
            plays.append([one[2] for one in each])
            poor.append(all(one[3] for one in each))
    inside = np.abs(np.array(errors)) < 1.96
    print(f"{inside.size} coefficients of {wanted.seeds} campaigns: {100.0 * inside.mean():.1f} % within ± 95 %")
    for joint, share in zip(TABLE_2, inside.mean(axis=0), strict=True):
        print(f"  joint {joint}: " + ", ".join(f"{n} {100.0 * s:.0f} %" for n, s in zip(NAMES, share, strict=True)))
    print(f"b within {np.abs(widths).max():.4f}°, the play by its definition within {np.abs(plays).max():.4f}°")
    print(f"the poor poses of joints 2 and 3, and no others, named in {sum(poor)} of {wanted.seeds}")


if __name__ == "__main__":
    main()
