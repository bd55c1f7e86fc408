"""Do planned campaigns keep what the plan promised?
``python -P -m tests.rates.planned_campaigns [N] [ROBOT] [FIRST_SEED]``.

The plan of campaigns/irb4400 (kr240, sda5f/right) is measured N times with the truth drawn: every stiffness times or
over up to two, lengths off by 0.5 mm and angles by 0.02 degrees (stated in robot.toml), poses set to 0.3 degrees (and
logged), loads to 3 % (and read with the sensor's noise), and a tenth of the runs lost. Printed: coverage of the 95 %
intervals, pooled and of each parameter, and the promised half width over the obtained one: of the plan, and of what the
plan would promise of each campaign if it knew the drawn stiffnesses and the runs that are lost.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.commands.plan import plan_campaign
from stiffcal.identification.fitting.geometry import geometry_columns, with_geometry
from stiffcal.identification.fitting.geometry_prior import GeometryPrior
from stiffcal.identification.fitting.geometry_source import GeometrySource
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain, GeometryTolerance
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.planning.campaign.model import with_rotation
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.expected import expected_fit
from stiffcal.planning.information import information_of_runs
from stiffcal.stages.plans.model import planned_model
from stiffcal.stages.steps import RunContext
from stiffcal.uncertainty import NORMAL_95
from tests.laboratory.states_of_runs import states_of_runs

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
# runs of the plan, and its load
ROBOTS: dict[str, tuple[int, dict[str, float | str]]] = {
    "irb4400": (14, {"force_N": 450.0}),
    "kr240": (30, {"force_N": 4000.0, "point": "hook"}),
    "sda5f/right": (16, {"force_N": 100.0}),
}
LENGTH, ANGLE = 5e-4, np.radians(0.02)


def perturbed(chain: Chain, rng: np.random.Generator) -> Chain:
    """Return the chain as built: every transform between joint frames off by the tolerance of lengths and angles."""
    fixed = chain.fixed.copy()
    for k in range(chain.n_joints):
        fixed[k, :3, 3] += LENGTH * rng.normal(size=3)
        fixed[k, :3, :3] = rotation_from_vector(ANGLE * rng.normal(size=3)) @ fixed[k, :3, :3]
    return replace(chain, fixed=fixed)


def promise(
    robot: CompliantRobot, joints: Floats, loads: Floats, setup: MeasurementSetup, noise: Noise, turns: bool
) -> dict[str, float]:
    """Return by name the half width, relative to the robot's own values, that a plan of these runs promises."""
    runs = information_of_runs(
        robot, joints, loads, setup, noise, turns, further=partial(geometry_columns, robot)
    )  # fmt: skip
    prior = GeometryPrior(LENGTH, ANGLE, GeometrySource.ROBOT_FILE)
    expected = expected_fit(runs.factors, runs.further, prior.sizes(robot.chain.n_joints), None)
    return dict(zip(runs.names, (NORMAL_95 * expected.course[-1]).tolist(), strict=True))


def main(n_campaigns: int, name: str, first_seed: int = 0) -> None:
    """Print coverage and widths."""
    n_runs, load = ROBOTS[name]
    campaign = load_campaign(CAMPAIGNS / name, check_files=False)
    context = RunContext()
    with tempfile.TemporaryDirectory() as scratch:
        # the folder's own plan.toml, if any, is not what is planned here
        folder = Path(scratch) / "campaign"
        shutil.copytree(CAMPAIGNS / name, folder, ignore=shutil.ignore_patterns("raw", "store", "plan.toml"))
        written = "".join(f"{key} = {json.dumps(value)}\n" for key, value in load.items())
        (folder / "plan.toml").write_text(f'schema = "stiffcal/plan-input/1"\n[load]\n{written}', encoding="utf-8")
        plan = plan_campaign(folder, request=PlanRequest(runs=n_runs))
    model = planned_model(campaign, PlanFile.model_validate({"load": load}), context)
    turns = with_rotation(campaign)
    chain, noise = model.robot.chain, model.noise
    robot = replace(model.robot, chain=replace(chain, tolerance=GeometryTolerance(LENGTH, ANGLE)))
    setup = replace(model.setup, rods=(), beams=(), gauges=(), markers=())
    nominal = robot.values()
    # what the law multiplies with: a stiffness is known by its compliance, whose width does not follow its value
    promised = np.array([parameter.relative or np.nan for parameter in plan.parameters])
    names = [parameter.name for parameter in plan.parameters]
    covered, widths, informed = [], [], []
    for seed in range(first_seed, first_seed + n_campaigns):
        rng = np.random.default_rng(seed)
        truth = {name: value * 2.0 ** rng.uniform(-1.0, 1.0) for name, value in nominal.items()}
        built = CompliantRobot(perturbed(robot.chain, rng), robot.placed, robot.deformed).with_values(truth)
        kept = rng.permutation(n_runs)[: n_runs - max(1, round(n_runs / 10))]
        joints = np.stack([plan.runs[k].joints for k in kept])
        joints = joints + np.radians(0.3) * rng.normal(size=joints.shape)
        loads: Floats = np.stack([plan.runs[k].wrench for k in kept])
        loads = loads * (1.0 + 0.03 * rng.normal(size=(*loads.shape[:2], 1)))
        states = states_of_runs(built, joints, loads, setup, noise, rng, turns)
        fit = with_geometry(identify_parameters(states, robot, Settings(noise=noise)), states)
        estimated = {parameter.name: parameter for parameter in fit.parameters}
        at_truth = promise(robot.with_values(truth), joints, loads, setup, noise, turns)
        within, half, own = [], [], []
        for parameter_name in names:
            found = estimated[parameter_name]
            low, high = found.interval or (np.nan, np.nan)
            within.append(low <= truth[parameter_name] <= high)
            usual = nominal[parameter_name]
            width = usual / low - usual / high if found.spec.inverse else (high - low) / usual
            half.append(0.5 * width)
            change = truth[parameter_name] / usual
            own.append(at_truth[parameter_name] * (1.0 / change if found.spec.inverse else change))
        covered.append(within)
        widths.append(promised / np.array(half))
        informed.append(np.array(own) / np.array(half))
    promises = np.isfinite(promised)
    share, ratio = np.array(covered)[:, promises], np.array(widths)[:, promises]
    left_out = [name for name, known in zip(names, promises, strict=True) if not known]
    names = [name for name, known in zip(names, promises, strict=True) if known]
    print(f"not promised: {', '.join(left_out) or 'none'}")
    print(f"{n_campaigns} campaigns: covered {100 * share.mean():.1f} % pooled")
    for k, parameter_name in enumerate(names):
        spread = np.percentile(ratio[:, k], [2.5, 50, 97.5])
        ends = f"{spread[0]:.2f} to {spread[2]:.2f}"
        print(f"{parameter_name}: {100 * share[:, k].mean():.1f} %, promised over obtained {spread[1]:.2f} ({ends})")
    for title, ratios in (("of the plan", ratio), ("knowing truth and losses", np.array(informed)[:, promises])):
        near = 100.0 * np.mean((ratios >= 0.8) & (ratios <= 1.25))
        ends = "{:.2f} to {:.2f}".format(*np.percentile(ratios, [2.5, 97.5]))
        middle = np.median(ratios)
        print(f"promised over obtained, {title}: median {middle:.3f}, {ends}; {near:.1f} % within 0.8 to 1.25")


if __name__ == "__main__":
    given = sys.argv[1:]
    campaigns, robot, first = (*given, *("200", "irb4400", "0")[len(given) :])
    main(int(campaigns), robot, int(first))
