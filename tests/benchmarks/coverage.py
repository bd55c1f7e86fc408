"""Is the stated uncertainty true? Simulated campaigns, counted: do the 95 % intervals hold the truth?

Run ``python -m tests.benchmarks.coverage``; it prints the table and ends with 1 where the pooled coverage leaves
93–97 %. The robot is MuJoCo, six joints (see `campaigns`); half of the campaigns measure position only, half full
poses; half have the instruments' noise stated, half leave it to repeats. ``balance = "first-order"`` is shown next to
it, and χ² of (estimate − truth) under the stated covariance: its mean should be 6, and hardly one campaign in a
thousand should lie beyond p = 0.001.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.mujoco_states import Plan, simulate_campaign

WANTED = (0.93, 0.97)
BEYOND_P_0001 = 22.458
"""χ² of 6 degrees of freedom that is exceeded with p = 0.001 (any table of the distribution)."""

PLANS = {
    "position, noise stated": Plan(full_pose=False, sigma_stated=True),
    "position, noise from repeats": Plan(full_pose=False, sigma_stated=False),
    "full pose, noise stated": Plan(full_pose=True, sigma_stated=True),
    "full pose, noise from repeats": Plan(full_pose=True, sigma_stated=False),
}


@dataclass(frozen=True)
class Outcome:
    """What one fit gave, six numbers each.

    Attributes
    ----------
    inside : the 95 % interval of the compliance holds the truth.
    normalised : (estimate − truth) / standard uncertainty.
    relative : (estimate − truth) / truth.
    chi2 : of (estimate − truth) under the stated covariance.
    """

    inside: Floats
    normalised: Floats
    relative: Floats
    chi2: float


def compliant_joints(chain: Chain, deformed: bool) -> CompliantRobot:
    """Return the model to identify: one free compliance per joint."""
    effect = find_effects()["joint-compliance"]
    placed = tuple(PlacedEffect(effect, Place("joints", (k,))) for k in range(1, chain.n_joints + 1))
    return CompliantRobot(chain, placed, deformed)


def judge(plan: Plan, seed: int) -> tuple[Outcome, Outcome]:
    """Simulate one campaign and identify it, balanced and first order."""
    campaign = simulate_campaign(np.random.default_rng(seed), plan)
    found = []
    for deformed in (True, False):
        fit = identify_parameters(campaign.states, compliant_joints(campaign.chain, deformed))
        parameters = [fit.parameter(f"joint-compliance.j{k}.c") for k in range(1, 7)]
        value, std, interval = [], [], []
        for parameter in parameters:
            if parameter.value is None or parameter.std is None or parameter.interval is None:
                raise AssertionError(f"campaign {seed}: {parameter.name} was not identified")
            value.append(parameter.value)
            std.append(parameter.std)
            interval.append(parameter.interval)
        truth, bounds = campaign.joint_compliance, np.array(interval)
        away = np.array(value) - truth
        found.append(
            Outcome(
                inside=((bounds[:, 0] <= truth) & (truth <= bounds[:, 1])).astype(np.float64),
                normalised=away / np.array(std),
                relative=away / truth,
                chi2=float(away @ np.linalg.solve(fit.covariance, away)),
            )
        )
    return found[0], found[1]


def line(name: str, outcomes: Sequence[Outcome]) -> str:
    """Return one row of the table."""
    inside = np.array([one.inside for one in outcomes])
    chi2 = np.array([one.chi2 for one in outcomes])
    share = inside.mean()
    # the six parameters of a campaign err together: campaigns, not parameters, are what is independent
    doubt = inside.mean(axis=1).std() / np.sqrt(len(outcomes))
    bias = 100.0 * np.abs(np.array([one.relative for one in outcomes]).mean(axis=0)).max()
    spread = np.sqrt(np.mean(np.array([one.normalised for one in outcomes]) ** 2))
    return (
        f"{name:<32}{len(outcomes):>6}{100 * share:>9.1f} ± {100 * doubt:.1f}{spread:>12.3f}"
        f"{chi2.mean():>10.2f}{int(np.sum(chi2 > BEYOND_P_0001)):>8}{bias:>12.3f}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and print its table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--campaigns", type=int, default=400, help="at least 170; 400 know the coverage to 0.6 %%")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--poses", type=int, default=Plan().poses, help="runs per campaign")
    options = parser.parse_args(arguments)
    started = time.perf_counter()
    names = list(PLANS)
    results: dict[str, list[tuple[Outcome, Outcome]]] = {name: [] for name in names}
    for number in range(options.campaigns):
        name = names[number % len(names)]
        plan = replace(PLANS[name], poses=options.poses)
        results[name].append(judge(plan, 1000 * options.seed + number))
        if sys.stderr.isatty():
            print(f"\r{number + 1} of {options.campaigns}", end="", file=sys.stderr)
    header = f"{'':<32}{'runs':>6}{'inside, %':>15}{'rms(d/std)':>12}{'mean chi2':>10}{'p<.001':>8}{'bias, %':>12}"
    pooled = [pair for name in names for pair in results[name]]
    for column, title in enumerate(("balanced on the deformed robot", 'balance = "first-order"')):
        print(f"\n{title}\n{header}")
        for name in names:
            if results[name]:
                print(line(name, [pair[column] for pair in results[name]]))
        print(line("all", [pair[column] for pair in pooled]))
    share = float(np.mean([pair[0].inside for pair in pooled]))
    held = WANTED[0] <= share <= WANTED[1]
    print(
        f"\n{options.campaigns} campaigns, {6 * options.campaigns} parameters, {time.perf_counter() - started:.0f} s: "
        f"95 % intervals hold the truth in {100 * share:.1f} % ({'within' if held else 'OUTSIDE'} 93–97 %)"
    )
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
