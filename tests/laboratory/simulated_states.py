"""Campaigns played by the exact balance, for tests of what a fit makes of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, RunInfo, Sigma
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place, StateOrder
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes, six_axis_joints

UP_AND_DOWN = np.array([0.5, 1.0, 0.5, 0.0])
"""One cycle in parts of the largest load."""

LOAD_POINT = np.array([0.15, 0.05, 0.12])
"""Where the force acts, in the sensor's frame, m: off the last axis, else nothing turns joint 6."""


def joint_springs(chain: Chain, stiffness: Floats | None = None, deformed: bool = True) -> CompliantRobot:
    """Return the robot with a spring in every joint, valued where a stiffness (J,), N·m/rad, is given."""
    effect = find_effects()["joint-compliance"]
    return CompliantRobot(
        chain,
        tuple(
            PlacedEffect(effect, Place("joints", (k + 1,)), {} if stiffness is None else {"c": 1.0 / stiffness[k]})
            for k in range(chain.n_joints)
        ),
        deformed,
    )


def cycles_of(directions: Floats, cycles: int = 2, force: float = 400.0) -> Floats:
    """Return one run's wrenches (n, 6): an unloaded state, then each (3,) direction up and down, as often as asked."""
    levels = np.tile(UP_AND_DOWN, cycles) * force
    loads = np.concatenate([np.zeros((1, 3)), *(levels[:, None] * direction for direction in directions)])
    return np.concatenate([loads, np.cross(LOAD_POINT, loads)], axis=1)


def played(
    robot: CompliantRobot,
    runs: int = 6,
    seed: int = 1,
    wrench: Sequence[Floats] | None = None,
    noise: Sigma | None = None,
    full_pose: bool = True,
    load_scatter: float = 0.0,
) -> LoadStates:
    """Let the exact balance play a campaign.

    Parameters
    ----------
    robot : with every parameter with a value.
    wrench : per run (n, 6) true wrenches; three random directions with two cycles each where None.
    noise : added to readings; none where None. Stated in the set-up.
    load_scatter : share by which each load misses its mark.
    """
    rng = np.random.default_rng(seed)
    chain = robot.chain
    if wrench is None:
        wrench = [cycles_of(np.linalg.qr(rng.normal(size=(3, 3)))[0]) for _ in range(runs)]
    run = np.repeat(np.arange(runs), [len(one) for one in wrench])
    true = np.concatenate(wrench) * (1.0 + load_scatter * rng.normal(size=(len(run), 1)))
    joints = six_axis_joints(rng, runs)[run]
    sigma = noise or Sigma()
    setup = force_sensor_setup(chain)
    n = len(run)
    time = 8.0 * np.arange(n, dtype=np.float64)
    first = np.searchsorted(run, run)
    still, unknown = np.zeros((chain.n_joints, n)), np.full(n, np.nan)
    order = StateOrder(run, time, unknown, still, unknown, time - time[first], np.arange(1, n + 1))
    rest = solve_balance(robot, chain.model_angles(joints), true, setup, order)
    turn = rotation_from_vector((sigma.rotation or 0.0) * rng.normal(size=(n, 1, 3)))
    spread = np.repeat([sigma.force or 0.0, sigma.moment or 0.0], 3)
    return LoadStates(
        runs=tuple(RunInfo(f"pose{k + 1}") for k in range(runs)),
        run=run,
        time=time,
        hold=np.full(n, np.nan),
        joints=joints,
        wrench=true + spread * rng.normal(size=(n, 6)),
        position=rest.target_position + (sigma.translation or 0.0) * rng.normal(size=(n, 1, 3)),
        rotation=turn @ rest.target_rotation if full_pose else np.full((n, 1, 3, 3), np.nan),
        deflection=np.full((n, 1, 6), np.nan),
        reference=np.concatenate([[True], np.diff(run) != 0]),
        temperature=np.zeros((n, 0)),
        row=np.arange(1, n + 1),
        n_readings=np.ones(n, dtype=np.int64),
        wrench_scatter=np.full((n, 6), np.nan),
        position_scatter=np.full((n, 1, 3), np.nan),
        set_aside=np.full(n, "", dtype="<U40"),
        setup=setup,
    )


def medium_robot() -> CompliantRobot:
    """Return the medium six-axis robot with the published joint stiffness."""
    return joint_springs(six_axes(), SIX_STIFFNESS)
