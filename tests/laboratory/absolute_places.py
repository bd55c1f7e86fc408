"""Absolute places of a robot whose chain is known: made from matrix products and pinocchio's frames, not by our fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, LoadStates, MeasurementSetup, RunInfo, Sigma, TrackerPlace
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.effect import Effect, Place
from tests.laboratory.effect_bench import bare_states
from tests.laboratory.robots import force_sensor_setup, shifted, six_axis_joints

SIGMA = 2e-5
TARGET = "target1"


def place_setup(chain: Chain, estimated: tuple[str, ...] = ("tracker", TARGET)) -> MeasurementSetup:
    """Return one target on the flange, measured to 20 µm per axis, no load."""
    flange = Attachment(chain.n_joints + 1, shifted(0.08, 0.0, 0.12))
    return replace(
        force_sensor_setup(chain),
        targets=(flange,),
        target_names=(TARGET,),
        wrench_axes=Attachment(0, np.eye(4)),
        moments_measured=False,
        sigma=Sigma(translation=SIGMA),
        trackers=(TrackerPlace("tracker", np.eye(4)),),
        estimated=estimated,
    )


def absolute_states(
    chain: Chain, n: int, seed: int, places: Floats | None = None, wrench: Floats | None = None
) -> LoadStates:
    """Return n rows with random joint angles; ``places`` (n, 1, 3) m, base axes, zero where not given."""
    joints = six_axis_joints(np.random.default_rng(seed), n)
    states = bare_states(
        list(range(n)), joints, place_setup(chain),
        position=np.zeros((n, 1, 3)) if places is None else places,
        wrench=np.zeros((n, 6)) if wrench is None else wrench,
        time=20.0 * np.arange(n),
    )  # fmt: skip
    runs = tuple(RunInfo(f"poses row {k + 1}", "absolute", of="poses", measures=StateMeasure.PLACE) for k in range(n))
    return replace(states, runs=runs)


def measured_by(
    robot: CompliantRobot, states: LoadStates, seed: int, sigma: float = SIGMA, wrench: Floats | None = None
) -> LoadStates:
    """Return the states with the places at which the robot comes to rest, and noise."""
    load = states.wrench if wrench is None else wrench
    rest = solve_balance(robot, robot.chain.model_angles(states.joints), load, states.setup)
    noise = np.random.default_rng(seed).normal(0.0, sigma, rest.target_position.shape)
    return replace(states, position=rest.target_position + noise, wrench=load)


def on_all_joints(effect: Effect, n_joints: int, values: list[dict[str, float]] | None = None) -> list[PlacedEffect]:
    """Return the effect on every joint, with values by joint."""
    own = values or [{} for _ in range(n_joints)]
    return [PlacedEffect(effect, Place("joints", (k + 1,)), own[k]) for k in range(n_joints)]
