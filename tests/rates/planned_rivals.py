"""Do the runs of `plan --tell` settle it?
``python -P -m tests.rates.planned_rivals FOLDER [SEEDS] [RUNS] [FORCE] [FIRST_SEED] [EFFECT…]``.

FOLDER is a copy of a campaign whose diagnosis names effects that look alike (or EFFECTs, as "backlash j4"). Each of
them in turn is the truth: with its values and noise as fitted to the campaign, the campaign's own loads and the planned
runs are played by the exact balance, and diagnosed. Printed: how often the true effect is named, alone, and every other
answer; from seed 0 on without the planned runs too.
"""

from __future__ import annotations

import sys
import time
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.plan_file import load_plan
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.plan import plan_campaign
from stiffcal.identification.fitting.identify import Settings
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.measurements.load_states import Attachment, LoadStates, MeasurementSetup, RunInfo
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.campaign.rivals import named_rival, rivals_of_diagnosis
from stiffcal.planning.information import reads_along_lines
from stiffcal.reduction.loads.motion import gauge_directions
from stiffcal.stages.experiments import robot_to_fit
from stiffcal.stages.plans.model import rival_models
from stiffcal.stages.steps import RunContext, up_to_date_states


def with_runs(states: LoadStates, joints: Floats, wrench: Floats) -> LoadStates:
    """Return the load states with those of further runs (N, L), (N, K, 6) after them, unread."""
    n_runs, n_steps = wrench.shape[:2]
    per_run = n_steps + 2
    loads = np.zeros((n_runs, per_run, 6))
    loads[:, 1:-1] = wrench
    n = n_runs * per_run
    n_before, first = len(states), len(states.runs)
    later = 100.0 + float(np.nanmax(states.time)) if np.isfinite(states.time).any() else 0.0
    further = {
        "run": first + np.repeat(np.arange(n_runs), per_run),
        "time": later + 8.0 * np.arange(n),
        "joints": np.repeat(joints, per_run, axis=0),
        "wrench": loads.reshape(n, 6),
        "position": np.zeros((n, *states.position.shape[1:])),
        "reference": np.arange(n) % per_run == 0,
        "n_readings": np.ones(n, dtype=np.int64),
    }
    arrays: dict[str, Any] = {}
    for entry in fields(states):
        own = getattr(states, entry.name)
        if isinstance(own, np.ndarray) and own.ndim and len(own) == n_before:
            nothing = np.nan if own.dtype.kind == "f" else np.zeros(1, own.dtype)[0]
            arrays[entry.name] = np.concatenate(
                [own, further.get(entry.name, np.full((n, *own.shape[1:]), nothing, dtype=own.dtype))]
            )
    runs = (*states.runs, *(RunInfo(f"planned{k + 1}") for k in range(n_runs)))
    return replace(states, runs=runs, **arrays)


def with_devices(states: LoadStates, chain: Chain) -> LoadStates:
    """Return the states with the runs that no device reads yet read by the one nearest to the line of their forces."""
    angles = chain.model_angles(states.joints)
    force = np.einsum("nab,nb->na", attached_poses(chain, angles, states.setup.wrench_axes)[1], states.wrench[:, :3])
    along = np.abs(np.einsum("nga,na->ng", gauge_directions(states, chain), force))
    reading = states.displacement.copy()
    for run in np.unique(states.run):
        members = states.run == run
        if not np.isfinite(reading[members]).any():
            reading[members, int(np.argmax(along[members].max(axis=0)))] = 0.0
    return replace(states, displacement=reading, position=np.full_like(states.position, np.nan))


def read(robot: CompliantRobot, states: LoadStates, noise: Noise, rng: np.random.Generator) -> LoadStates:
    """Return the states as the true robot and its instruments would give them."""
    rest = solve_balance(robot, robot.chain.model_angles(states.joints), states.wrench, states.setup)
    sigma = np.repeat([noise.force, noise.moment], 3)
    place = rest.target_position + noise.translation * rng.normal(size=rest.target_position.shape)
    reading = states.displacement
    if reads_along_lines(noise, states.setup):
        lines = gauge_directions(states, robot.chain)
        moved = np.stack([rest.displacement[:, gauge.target, :3] for gauge in states.setup.gauges], axis=1)
        read_now = np.sum(lines * moved, axis=2) + noise.gauge * rng.normal(size=reading.shape)
        place, reading = states.position, np.where(np.isfinite(reading), read_now, np.nan)
        sigma = np.where(states.wrench == 0.0, 0.0, noise.force)
    return replace(
        states, position=place, displacement=reading,
        wrench=states.wrench + sigma * rng.normal(size=states.wrench.shape),
        set_aside=np.full(len(states), "", dtype=np.str_), set_aside_code=np.full(len(states), "", dtype=np.str_),
    )  # fmt: skip


def as_read(chain: Chain, setup: MeasurementSetup, point: Attachment, joints: Floats, wrench: Floats) -> Floats:
    """Return wrenches (N, K, 6) in the sensor's axes about its point, of forces in base axes at a load point."""
    angles = chain.model_angles(joints)
    _, axes = attached_poses(chain, angles, setup.wrench_axes)
    lever = attached_poses(chain, angles, point)[0] - attached_poses(chain, angles, setup.wrench_point)[0]
    forces = wrench[:, :, :3]
    moments = np.cross(lever[:, None], forces)
    return np.concatenate([forces @ axes, moments @ axes], axis=2)


def main(folder: Path, n_seeds: int, n_runs: int, force: float, first_seed: int, effects: list[str]) -> None:
    """Print how often each look-alike is named where it is the truth."""
    context = RunContext()
    data = up_to_date_states(folder, context)
    campaign, plan_file = data.campaign, load_plan(folder)
    rivals = [named_rival(text) for text in effects]
    rivals = rivals or rivals_of_diagnosis(diagnose_campaign(folder, context), campaign)
    models = rival_models(rivals, campaign, plan_file, context)
    present, catalogue = robot_to_fit(data), find_effects()
    for planned in (False, True) if first_seed == 0 else (True,):
        states = data.states
        if planned:
            request = PlanRequest(rivals=tuple(rival.label for rival in rivals), runs=n_runs, force=force)
            plan = plan_campaign(folder, context, request)
            for entry in plan.separations or ():
                print(
                    f"promised: {entry.truth} true, {entry.rival} fitted: {entry.chi_square:.1f} of {entry.needed:.1f}"
                )
            joints = np.stack([run.joints for run in plan.runs])
            wrench = np.stack([run.wrench for run in plan.runs])
            states = with_runs(
                states, joints, as_read(campaign.chain, states.setup, models[0].setup.wrench_point, joints, wrench)
            )
            if reads_along_lines(models[0].noise, states.setup):
                states = with_devices(states, campaign.chain)
        for rival, model in zip(rivals, models, strict=True):
            started, named, alone = time.process_time(), 0, 0
            for seed in range(first_seed, first_seed + n_seeds):
                truth = CompliantRobot(present.chain, model.robot.placed, model.robot.deformed)
                played = read(truth, states, model.noise, np.random.default_rng(seed))
                search = diagnose_states(played, present, catalogue, Settings())
                first = search.found[0] if search.found else None
                right = first is not None and first.candidate.effect.name == named_rival(rival.label).effect
                named += right
                alone += right and first is not None and not first.alternatives
                if not right or (first is not None and first.alternatives):
                    label = (
                        "nothing" if first is None else f"{first.candidate.effect.name} {first.candidate.place.label}"
                    )
                    others = [one.name for one, _ in first.alternatives] if first is not None else []
                    print(f"  seed {seed}: {label}, alternatives {others}", flush=True)
            spent = (time.process_time() - started) / n_seeds
            kind = f"with {n_runs} planned runs" if planned else "without planned runs"
            counts = f"named {named}, alone {alone} of {n_seeds} from seed {first_seed}"
            print(f"{kind}, {rival.label} true: {counts} ({spent:.1f} s each)", flush=True)


if __name__ == "__main__":
    given = sys.argv[1:]
    seeds, runs, largest, first = (*given[1:5], *("10", "8", "350", "0")[len(given) - 1 :])
    main(Path(given[0]), int(seeds), int(runs), float(largest), int(first), given[5:])
