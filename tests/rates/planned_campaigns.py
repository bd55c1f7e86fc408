"""Do planned campaigns keep what the plan promised? ``nice -n 10 python -P -m tests.rates.planned_campaigns [N]``.

The plan of campaigns/irb4400 is measured N times with the truth drawn: every stiffness times or over up to two, lengths
off by 0.5 mm and angles by 0.02 degrees (the default tolerance of robot.toml), poses set to 0.3 degrees (and logged),
loads to 3 % (and read with the sensor's noise), and a tenth of the runs lost. Printed: coverage of the 95 % intervals,
pooled and of each parameter, and the promised half width over the obtained one.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.identification.identify import Settings, identify_parameters
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.composite import CompliantRobot
from stiffcal.uncertainty import NORMAL_95
from stiffcal.workflow.plan import PlanRequest, _model, plan_campaign
from stiffcal.workflow.steps import RunContext
from tests.laboratory.states_of_runs import states_of_runs

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "irb4400"
RUNS, FORCE = 14, 450.0
LENGTH, ANGLE = 5e-4, np.radians(0.02)


def perturbed(chain: Chain, rng: np.random.Generator) -> Chain:
    """Return the chain as built: every transform off by the tolerance of lengths and angles."""
    fixed = chain.fixed.copy()
    for k in range(1, len(fixed)):
        fixed[k, :3, 3] += LENGTH * rng.normal(size=3)
        fixed[k, :3, :3] = rotation_from_vector(ANGLE * rng.normal(size=3)) @ fixed[k, :3, :3]
    return replace(chain, fixed=fixed)


def main(n_campaigns: int) -> None:
    """Print coverage and widths."""
    plan = plan_campaign(CAMPAIGN, request=PlanRequest(runs=RUNS, force=FORCE))
    campaign = load_campaign(CAMPAIGN, check_files=False)
    model = _model(campaign, PlanFile.model_validate({}), RunContext())
    robot, setup, noise = model.robot, model.setup, model.noise
    nominal = robot.values()
    promised = np.array([parameter.half_width or np.nan for parameter in plan.parameters])
    names = [parameter.name for parameter in plan.parameters]
    covered, widths = [], []
    for seed in range(n_campaigns):
        rng = np.random.default_rng(seed)
        truth = {name: value * 2.0 ** rng.uniform(-1.0, 1.0) for name, value in nominal.items()}
        built = CompliantRobot(perturbed(robot.chain, rng), robot.placed, robot.deformed).with_values(truth)
        kept = rng.permutation(RUNS)[: RUNS - max(1, round(RUNS / 10))]
        joints = np.stack([plan.runs[k].joints for k in kept])
        joints = joints + np.radians(0.3) * rng.normal(size=joints.shape)
        loads: Floats = np.stack([plan.runs[k].wrench for k in kept])
        loads = loads * (1.0 + 0.03 * rng.normal(size=(*loads.shape[:2], 1)))
        states = states_of_runs(built, joints, loads, setup, noise, rng)
        fit = identify_parameters(states, robot, Settings(noise=noise))
        estimated = {parameter.name: parameter for parameter in fit.parameters}
        half = np.array([NORMAL_95 * (estimated[name].std or np.nan) for name in names])
        error = np.array([(estimated[name].value or np.nan) - truth[name] for name in names])
        covered.append(np.abs(error) <= half)
        widths.append(promised / half)
    share, ratio = np.array(covered), np.array(widths)
    print(f"{n_campaigns} campaigns: covered {100 * share.mean():.1f} % pooled")
    for k, name in enumerate(names):
        spread = np.percentile(ratio[:, k], [2.5, 50, 97.5])
        ends = f"{spread[0]:.2f} to {spread[2]:.2f}"
        print(f"{name}: {100 * share[:, k].mean():.1f} %, promised over obtained {spread[1]:.2f} ({ends})")
    within = 100.0 * np.mean((ratio >= 0.8) & (ratio <= 1.25))
    print(f"promised over obtained, median of all: {np.median(ratio):.3f}; within 0.8 to 1.25: {within:.1f} %")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
