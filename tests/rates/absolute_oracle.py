"""`python -m tests.rates.absolute_oracle --seed N`: one hidden effect of three times the noise in each campaign.

Reduced χ² of a refit of the true effect, the refit's rigid robot against the true one without gauge (rms at 1000 poses
over what the covariance predicts, with its probability), and the rms in regions left out: of the model that the search
ends with over that of the refit, same regions. ``--chi2-only`` leaves the search out; ``--practice`` does the same with
the campaigns in ``campaigns/absolute``, but for 07, whose law the catalogue does not have, and for the rigid robot
(``tests/validation/test_practice_absolute.py``).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.diagnosis.refits.heldout_error import fitted_rms
from stiffcal.errors import no_progress
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.laboratory.gauge_free import GaugeFree, compare_rigid, rigid_places
from tests.rates.absolute_robots import draw_absolute, oracle_of
from tests.rates.hiding import with_effects
from tests.rates.practice import ABSOLUTE, hidden_place, truth
from tests.rates.workers import one_thread_each

PRACTICE = ("01", "02", "03", "04", "05", "06")


N_POSES = 1000


def study(job: tuple[int, int, bool]) -> tuple[float, float, GaugeFree, str]:
    """Return the refit's reduced χ², the search's error over the refit's, the rigid robots compared, what is hidden.

    The search's error is NaN without a search.
    """
    seed, number, search_too = job
    campaign = draw_absolute("absolute 3x", np.random.default_rng([seed, number]), number)
    oracle = oracle_of(campaign)
    words = f"{campaign.hidden[0].effect.name} {campaign.hidden[0].place.label} ({campaign.settings})"
    ratio = np.nan
    if search_too:
        final = diagnose_states(campaign.states, campaign.model, built_in_effects()).last.fit
        best, own = fitted_rms(campaign.states, oracle).translation, fitted_rms(campaign.states, final).translation
        ratio = own / best if own and best else np.nan
    limits = campaign.model.chain.limits
    joints = np.random.default_rng(3).uniform(limits[:, 0], limits[:, 1], (N_POSES, len(limits)))
    angles = campaign.model.chain.model_angles(joints).T
    true = rigid_places(oracle, campaign.truth, angles)
    rigid = compare_rigid(oracle, true, lambda robot: rigid_places(oracle, robot, angles))
    return oracle.reduced_chi2 or np.nan, ratio, rigid, words


def practised(name: str) -> tuple[float, float, str]:
    """Return the same of a practice campaign, nothing hidden included."""
    campaign = load_campaign(ABSOLUTE / name)
    states, model = reduce_campaign(campaign, no_progress).states, placed_robot(campaign)
    hidden = truth(ABSOLUTE)[name]["hidden"]
    added = [PlacedEffect(built_in_effects()[one["effect"]], hidden_place(one)) for one in hidden]
    oracle = identify_parameters(states, with_effects(model, *added))
    final = diagnose_states(states, model, built_in_effects()).last.fit
    best, own = fitted_rms(states, oracle).translation, fitted_rms(states, final).translation
    words = ", ".join(f"{one['effect']} {hidden_place(one).label}" for one in hidden) or "nothing"
    return oracle.reduced_chi2 or np.nan, own / best if own and best else np.nan, words


def main(arguments: Sequence[str]) -> int:
    """Draw, fit, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.rates.absolute_oracle", description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--practice", action="store_true")
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--chi2-only", action="store_true")
    chosen = parser.parse_args(arguments)
    if chosen.practice:
        for name in PRACTICE:
            chi2, ratio, words = practised(name)
            print(f"{name}: reduced chi-square {chi2:.3f}, error over the refit's {ratio:.3f}, {words}", flush=True)
        return 0
    jobs = [(chosen.seed, number, not chosen.chi2_only) for number in range(chosen.count)]
    reduced, ratios, rigid = [], [], []
    with one_thread_each(chosen.workers) as pool:
        for (_, number, _), (chi2, ratio, against, words) in zip(jobs, pool.map(study, jobs), strict=True):
            reduced.append(chi2)
            ratios.append(ratio)
            rigid.append(against)
            print(
                f"{number}: reduced chi-square {chi2:.3f}, error over the refit's {ratio:.3f}, rigid robot over "
                f"predicted {against.ratio:.3f} (probability {against.probability:.3f}), {words}",
                flush=True,
            )
    scatter = np.std(reduced, ddof=1) / np.sqrt(len(reduced))
    print(f"mean reduced chi-square {np.mean(reduced):.4f} ± {scatter:.4f} (one standard error)")
    squares = np.array([against.ratio**2 for against in rigid])
    error = squares.std(ddof=1) / np.sqrt(len(squares))
    print(
        f"rigid robot over predicted: mean square {squares.mean():.3f} ± {error:.3f}, "
        f"above 1.5 in {np.sum(squares > 1.5**2)} of {len(squares)}, probability below 0.05 in "
        f"{sum(against.probability < 0.05 for against in rigid)}"
    )
    if not chosen.chi2_only:
        close = np.abs(np.array(ratios) - 1.0) <= 0.03
        print(
            f"error over the refit's: rms {np.sqrt(np.mean(np.square(ratios))):.4f}, "
            f"within 3 %: {close.sum()} of {len(close)}"
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
