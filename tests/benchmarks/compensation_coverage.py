"""Does the residual that `compensate` prints cover what is left on the true robot? Simulated campaigns, counted.

Run ``python -m tests.benchmarks.compensation_coverage``. Each campaign measures a robot of its own (MuJoCo plays its
drives, see `campaigns`), by position or by full pose, with or without bearings that give too. What is identified then
corrects a path through the workspace under drawn forces, and the robot as it really is says what is left of the
deflection. Printed is how often that stays within the stated 95 %, over all poses of all paths and at the worst pose of
each path, and the mean of χ² of what is left under the stated covariance (three components: 3).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.targets import CorrectionOptions, correct_joints, errors_of
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.mujoco_states import Plan, SimulatedCampaign, simulate_campaign
from tests.laboratory.robots import six_axis_joints

WANTED = 0.95
# The poses of a path err together: the paths' own scatter tells the doubt; two of it are allowed below what is asked.
DOUBTS = 2.0
TILT = 4e-7
PLANS = {
    "drives, position measured": (Plan(full_pose=False), ()),
    "drives, full pose": (Plan(full_pose=True), ()),
    "drives and bearings 1 to 3, position": (Plan(full_pose=False), (1, 2, 3)),
}


@dataclass(frozen=True)
class Outcome:
    """One path: ``inside`` (n,) left within the stated 95 %, ``gone`` the share of the deflection, ``chi2`` (n,)."""

    inside: Floats
    gone: float
    chi2: Floats


def robots(campaign: SimulatedCampaign, tilted: Sequence[int]) -> tuple[CompliantRobot, CompliantRobot]:
    """Return the robot as it really is, and the model to identify."""
    effects, true = find_effects(), []
    for k, c in enumerate(campaign.joint_compliance, start=1):
        true.append(PlacedEffect(effects["joint-compliance"], Place("joints", (k,)), {"c": float(c)}))
    for k in tilted:
        true.append(PlacedEffect(effects["bearing-tilt"], Place("joints", (k,)), {"x": TILT, "y": TILT}))
    free = tuple(replace(one, values={}) for one in true)
    return CompliantRobot(campaign.chain, tuple(true)), CompliantRobot(campaign.chain, free)


def judge(plan: Plan, tilted: Sequence[int], seed: int, poses: int) -> Outcome:
    """Measure one robot, identify it, and correct one path."""
    rng = np.random.default_rng(seed)
    campaign = simulate_campaign(rng, plan)
    true, free = robots(campaign, tilted)
    states, chain = campaign.states, campaign.chain
    if tilted:
        # MuJoCo plays the drives: what the bearings add to every place comes from the exact balance.
        drives = replace(true, placed=true.placed[:6])
        angles = chain.model_angles(states.joints)
        with_them, without = (solve_balance(one, angles, states.wrench, states.setup) for one in (true, drives))
        more = with_them.target_position - without.target_position
        states = replace(states, position=states.position + more)
    fit = identify_parameters(states, free)
    ends = six_axis_joints(rng, 2)
    joints = ends[0] + np.linspace(0.0, 1.0, poses)[:, None] * (ends[1] - ends[0])
    wrench = rng.normal(size=6) * np.repeat([plan.force, plan.moment], 3) / np.sqrt(3.0)
    wrenches = wrench * (1.0 + 0.5 * np.sin(np.linspace(0.0, 6.0, poses)))[:, None]
    names = fit.free_names
    covariance = {
        a: dict(zip(names, map(float, row), strict=True)) for a, row in zip(names, fit.covariance, strict=True)
    }
    found = correct_joints(fit.robot, joints, wrenches, states.setup, covariance=covariance)
    left = errors_of(true, joints, found.joints, wrenches, states.setup, CorrectionOptions())[:, :3]
    deflection = errors_of(true, joints, joints, wrenches, states.setup, CorrectionOptions())[:, :3]
    stated = found.covariance[:, :3, :3]
    return Outcome(
        inside=(np.linalg.norm(left, axis=1) < found.residual_95).astype(np.float64),
        gone=1.0 - float(np.sqrt(np.sum(left**2) / np.sum(deflection**2))),
        chi2=np.einsum("ni,ni->n", left, np.linalg.solve(stated, left[:, :, None])[:, :, 0]),
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and print its table; return 1 where less is covered than is stated."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--campaigns", type=int, default=60, help="of each kind, one path each")
    parser.add_argument("--poses", type=int, default=25, help="of each path")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    print(f"{'':<38}{'paths':>6}{'poses within 95 %':>22}{'paths wholly':>14}{'mean χ² of 3':>14}{'gone, least':>13}")
    held = True
    for number, (name, (plan, tilted)) in enumerate(PLANS.items()):
        seeds = range(
            1000 * options.seed + 100_000 * number, 1000 * options.seed + 100_000 * number + options.campaigns
        )
        found = [judge(plan, tilted, seed, options.poses) for seed in seeds]
        shares = np.array([one.inside.mean() for one in found])
        doubt = float(shares.std() / np.sqrt(len(shares)))
        print(
            f"{name:<38}{len(found):>6}{100 * shares.mean():>15.1f} ± {100 * doubt:.1f} %"
            f"{100 * np.mean(shares == 1.0):>12.0f} %{np.mean([one.chi2.mean() for one in found]):>14.2f}"
            f"{100 * min(one.gone for one in found):>11.1f} %",
            flush=True,
        )
        held &= bool(shares.mean() + DOUBTS * doubt >= WANTED)
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
