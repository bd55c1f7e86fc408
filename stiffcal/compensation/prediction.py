"""What a fitted robot does under given loads: deflection, its uncertainty, and the Cartesian stiffness at the target.

Everything comes from the balance on the deformed chain (`model.equilibrium`); derivatives are central differences of
it, so that whatever effects the model holds are in them.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import Balance, solve_balance
from stiffcal.model.effect import StateOrder

# Steps of the differences: small compared with working loads, far above the solver's rounding.
FORCE_STEP_N, MOMENT_STEP_NM = 10.0, 2.0
# A compliance matrix worse conditioned than this (in units scaled by 1 m) has a direction that does not give at all.
LARGEST_CONDITION = 1e10


@dataclass(frozen=True)
class Prediction:
    """The model's prediction of n states; base axes."""

    deflection: Floats
    """(n, 6) of the first target, from the unloaded, weight-sagged robot: m, then rotation vector, rad."""
    covariance: Floats
    """(n, 6, 6) that the parameters' uncertainty leaves; zero where the values were given."""
    cartesian_compliance: Floats
    """(n, 6, 6) deflection of the target per wrench at the target, in the loaded state."""
    cartesian_stiffness: tuple[Floats | None, ...]
    """n matrices (6, 6), its inverse; None where a direction does not give."""
    linear_compliance: Floats
    """(n, 6, 6) the same without complementary stiffness: C = J K_θ⁻¹ Jᵀ on the undeformed chain, every law by its
    slope under this load (002, eq. 2; 003, eq. 29 with K_C = 0).
    """
    linear_stiffness: tuple[Floats | None, ...]
    """Its inverses."""


def predict_states(
    robot: CompliantRobot,
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    covariance: Mapping[str, Mapping[str, float]] | None = None,
    in_order: bool = False,
) -> Prediction:
    """Predict deflection and stiffness of a robot with values.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    joints : (n, L) logged joint angles, rad.
    wrench : (n, 6) N and N·m, base axes, on the robot, about the set-up's wrench point.
    setup : where load and target are.
    covariance : of the amplitudes, by full parameter names; None: the values are taken as exact.
    in_order : the states follow each other in one run (laws with a memory); otherwise each stands alone.

    Raises
    ------
    NoBalanceError : a load is more than the springs hold.
    """
    loads = at_load_point(setup)
    angles = robot.chain.model_angles(joints)
    order = one_run(robot, len(joints)) if in_order else None
    balance = solve_balance(robot, angles, wrench, loads, order)
    compliance = cartesian_compliance(robot, angles, wrench, loads, balance)
    linear = cartesian_compliance(replace(robot, deformed=False), angles, wrench, loads, balance)
    return Prediction(
        deflection=balance.displacement[:, 0],
        covariance=parameter_covariance(robot, angles, wrench, loads, order, covariance or {}),
        cartesian_compliance=compliance,
        cartesian_stiffness=tuple(_inverse(matrix) for matrix in compliance),
        linear_compliance=linear,
        linear_stiffness=tuple(_inverse(matrix) for matrix in linear),
    )


def at_load_point(setup: MeasurementSetup) -> MeasurementSetup:
    """Return the set-up with wrenches in base axes about its wrench point, moments known."""
    return replace(setup, wrench_axes=Attachment(0, np.eye(4)), moments_measured=True)


def load_path(corners: Sequence[Sequence[float]] | Floats, points: int) -> tuple[Floats, tuple[int, ...]]:
    """Return the wrenches along straight legs between corners, and where the corners are.

    Parameters
    ----------
    corners : forces (3) or wrenches (6), N and N·m.
    points : steps on each leg.

    Examples
    --------
    >>> path, at = load_path([[0.0, 0.0, 0.0], [0.0, 0.0, -100.0]], 2)
    >>> path[:, 2].tolist(), at
    ([0.0, -50.0, -100.0], (0, 2))
    """
    corner_wrenches = np.zeros((len(corners), 6))
    corner_loads = np.asarray(corners, dtype=np.float64)
    corner_wrenches[:, : corner_loads.shape[1]] = corner_loads
    legs = [corner_wrenches[:1]]
    for start, end in itertools.pairwise(corner_wrenches):
        share = np.arange(1, points + 1)[:, None] / points
        legs.append(start + share * (end - start))
    return np.concatenate(legs), tuple(range(0, points * (len(corner_wrenches) - 1) + 1, points))


def one_run(robot: CompliantRobot, n: int, time: Floats | None = None) -> StateOrder:
    """Return the order of n states that follow each other in one run, at times (n,), s, where these are known."""
    unknown, none = np.full(n, np.nan), np.zeros(n)
    motor = np.zeros((robot.chain.n_joints, n))
    if time is None:
        return StateOrder(np.zeros(n, dtype=np.int64), unknown, unknown, motor, unknown, none)
    return StateOrder(np.zeros(n, dtype=np.int64), time, none, motor, unknown, time - time[0])


def parameter_covariance(
    robot: CompliantRobot,
    angles: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    order: StateOrder | None,
    covariance: Mapping[str, Mapping[str, float]],
    weight: bool = False,
) -> Floats:
    """Return (n, 6, 6): how well the first target's deflection is known where the parameters are known so well.

    Parameters
    ----------
    angles : (n, J) model angles, rad.
    wrench : (n, 6) acting as the set-up states.
    order : the states' order, for laws with a memory; None where each stands alone.
    covariance : of the parameters, by full names.
    weight : True: of the target's place, sag under weight included; else of its displacement from the weight-only
        state.
    """
    names = list(covariance)
    columns = np.zeros((len(names), len(angles), 6))
    amplitudes = {
        placed_effect.parameter_name(spec.symbol): (placed_effect.amplitude(spec.symbol), spec)
        for placed_effect in robot.placed
        for spec in placed_effect.effect.parameters
    }
    rigid = attached_poses(robot.chain, angles, setup.targets[0]) if weight else None
    for place, name in enumerate(names):
        amplitude, spec = amplitudes[name]
        std = float(np.sqrt(covariance[name][name]))
        if std == 0.0:
            continue
        # A tenth of a standard uncertainty, and never across zero, where a compliance would turn into a push.
        step = min(0.1 * std, 0.5 * abs(amplitude)) if amplitude else 0.1 * std
        ends = []
        for shifted in (amplitude + step, amplitude - step):
            shifted_robot = robot.with_values({name: spec.value_of(shifted)})
            ends.append(_target_displacement(solve_balance(shifted_robot, angles, wrench, setup, order), rigid))
        columns[place] = (ends[0] - ends[1]) / (2.0 * step)
    matrix = np.array([[covariance[a][b] for b in names] for a in names]).reshape(len(names), len(names))
    return np.asarray(np.einsum("pni,pq,qnj->nij", columns, matrix, columns))


def _target_displacement(balance: Balance, rigid: tuple[Floats, Floats] | None) -> Floats:
    """Return (n, 6) how far the load moved the first target; from its ``rigid`` place, sag included, where given."""
    if rigid is None:
        return balance.displacement[:, 0]
    turn = balance.target_rotation[:, 0] @ np.swapaxes(rigid[1], 1, 2)
    return np.concatenate([balance.target_position[:, 0] - rigid[0], vector_from_rotation(turn)], axis=1)


def cartesian_compliance(
    robot: CompliantRobot, angles: Floats, wrench: Floats, setup: MeasurementSetup, balance: Balance
) -> Floats:
    """Return (n, 6, 6): a small wrench at the target added to the load.

    A wrench at the target is one at the load's point with the lever's moment, as long as both ride on one body; where
    they do not, the stiffness is that of the unloaded robot.
    """
    target = setup.targets[0]
    together = target.body == setup.wrench_point.body
    if together:
        lever = _lever(robot, angles, setup, balance)
        load = wrench
    else:
        setup = replace(setup, wrench_point=target)
        lever, load = np.zeros((len(angles), 3)), np.zeros_like(wrench)
    columns = []
    for axis in range(6):
        step = FORCE_STEP_N if axis < 3 else MOMENT_STEP_NM
        small = np.zeros((len(angles), 6))
        small[:, axis] = step
        small[:, 3:] += np.cross(lever, small[:, :3])
        ends = [
            solve_balance(robot, angles, load + sign * small, setup).displacement[:, 0] / (2.0 * step)
            for sign in (1.0, -1.0)
        ]
        columns.append(ends[0] - ends[1])
    return np.stack(columns, axis=2)


def _lever(robot: CompliantRobot, angles: Floats, setup: MeasurementSetup, balance: Balance) -> Floats:
    """Return (n, 3) from the load's point to the target in the loaded state, base axes, m."""
    target, point = setup.targets[0], setup.wrench_point
    inside = target.transform[:3, :3].T @ (target.transform[:3, 3] - point.transform[:3, 3])
    if not robot.deformed:
        _, rotation = attached_poses(robot.chain, angles, target)
    else:
        rotation = balance.target_rotation[:, 0]
    return np.asarray(rotation @ inside)


def _inverse(compliance: Floats) -> Floats | None:
    # Rotations count as the displacement they make at 1 m, so that the condition number means something.
    if not np.isfinite(compliance).all() or np.linalg.cond(compliance) > LARGEST_CONDITION:
        return None
    return np.asarray(np.linalg.inv(compliance))
