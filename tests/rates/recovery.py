"""How often a simulated campaign's parameters come back: `python -m tests.rates.recovery sda5f/left 1 2 3 …`.

For every seed: each identifiable parameter's deviation from the truth in standard uncertainties, and their χ² together,
with the chance of a larger one. Values on their bound are left out of χ².
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.special import chdtrc

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.model.assembled.assembly import compliant_robot
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


def recovered(folder: Path, seed: int) -> tuple[list[str], float, float, float]:
    """Return words on each parameter, χ² of those within their bounds, how many these are, and the reduced χ²."""
    settings = load_settings(folder).model_copy(update={"seed": seed})
    with tempfile.TemporaryDirectory() as space:
        out = Path(space) / "campaign"
        truth = simulate_campaign(load_campaign(folder, check_files=False), settings, out)["truth"]["parameters"]
        campaign = load_campaign(out)
        states = reduce_campaign(campaign, no_progress).states
    fit = identify_parameters(states, compliant_robot(campaign.chain, campaign.model, find_effects()))
    words, away, index = [], [], []
    for one in fit.parameters:
        if one.value is None or not one.std:
            words.append(f"{one.name} not determined")
            continue
        deviation = one.value - truth[one.name]
        noise = " (not significant)" if one.above_noise is False else ""
        words.append(f"{one.name} {deviation / one.std:+.1f}{noise}")
        if not one.at_bound:
            away.append(deviation)
            index.append(fit.free_names.index(one.name))
    part = np.array(away)
    chi2 = float(part @ np.linalg.solve(fit.covariance[np.ix_(index, index)], part))
    return words, chi2, float(len(index)), fit.reduced_chi2 or np.nan


def main(words: list[str]) -> None:
    """Print one line for every seed, and χ² of all together."""
    folder = CAMPAIGNS / words[0]
    total, count = 0.0, 0.0
    for seed in map(int, words[1:]):
        reported, chi2, n, reduced = recovered(folder, seed)
        total, count = total + chi2, count + n
        print(f"seed {seed}: χ² {chi2:.1f} of {n:.0f}, p {chdtrc(n, chi2):.3f}; fit's reduced χ² {reduced:.3f}")
        print("   " + ", ".join(reported), flush=True)
    print(f"together: χ² {total:.1f} of {count:.0f}, p {chdtrc(count, total):.3g}")


if __name__ == "__main__":
    main(sys.argv[1:])
