"""Joint parameters of campaigns/mixed against the truth, over seeds: ``python -m tests.benchmarks.mixed_coverage``.

Each seed draws the noise of every instrument and what the loads scatter; the true model is fitted to load, clamped and
friction runs together. χ² of the differences, by the stated covariance, is compared with its distribution.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign

SOURCE = Path(__file__).parents[2] / "campaigns" / "mixed"


def identified(folder: Path, seed: int) -> tuple[IdentifyResult, dict[str, float]]:
    """Simulate the campaign with a seed, and fit the true model to it; return the fit and the true values."""
    settings = load_settings(SOURCE)
    shown = settings.model_copy(update={"robot": settings.robot.model_copy(update={"hidden": []})})
    truth = simulate_campaign(load_campaign(SOURCE, check_files=False), shown, folder, seed=seed)["truth"]
    return identify_campaign(folder), truth["parameters"]


def deviation(result: IdentifyResult, truth: dict[str, float]) -> tuple[float, int]:
    """Return χ² of the estimates against the truth, and its degrees of freedom.

    Raises
    ------
    AssertionError : a parameter of the truth is not identified.
    """
    names = result.free_parameters
    difference = np.array([result.parameter(name).value or np.nan for name in names]) - [truth[name] for name in names]
    assert np.isfinite(difference).all()
    covariance = np.array(result.covariance, dtype=float)
    scale = np.sqrt(np.diag(covariance))
    away = difference / scale
    return float(away @ np.linalg.solve(covariance / np.outer(scale, scale), away)), len(names)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print χ² of each seed and of all of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    wanted = parser.parse_args(arguments)
    total, dof, disagree = 0.0, 0, 0
    for seed in range(wanted.first, wanted.first + wanted.seeds):
        with tempfile.TemporaryDirectory() as folder:
            result, truth = identified(Path(folder) / "out", seed)
            shutil.rmtree(folder, ignore_errors=True)
        statistic, count = deviation(result, truth)
        total, dof = total + statistic, dof + count
        disagree += sum(not agreement.agree for agreement in result.agreement or [])
        print(f"seed {seed}: χ² {statistic:.2f} of {count}, p {chi2.sf(statistic, count):.3f}", flush=True)
    print(f"all: χ² {total:.1f} of {dof}, p {chi2.sf(total, dof):.3f}; instruments disagree in {disagree}")


if __name__ == "__main__":
    main()
