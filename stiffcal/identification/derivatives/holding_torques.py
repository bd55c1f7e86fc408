"""What the motors' torques at rest show of the links' moments.

A motor at rest holds what turns its axis, weight and payload, less what a balancing spring carries. Per logged axis

    τ = (1 + g) (h(q) + H(q) m) + o + e,

τ the torque as logged, h what holds the robot file's masses and the payload, H m what the links' moments add (on the
undeformed chain: that it sags changes torques by a per mille), g the motor's error of gain with the stated uncertainty,
o an offset, e scatter, friction of the standing gear among it: taken from what is left. About the present moments gain
and offset of each axis are eliminated; what remains are rows for the moments alone (Gautier and Khalil 1990; Swevers,
Verdonck and De Schutter 2007). A log may count the motor's torque or the weight's: the sign that fits is taken, one for
all axes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.triangular import triangular
from stiffcal.estimation.unknowns import ParameterColumn
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.model.assembled.base_tilt import BaseTilt
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.deformed_chain import deformed_chain, node_wrenches
from stiffcal.model.balance.rest import add_side_torques
from stiffcal.model.effect import Inputs, joint_nodes
from stiffcal.model.laws.link_moments import LinkMoments

# Below this share of the largest weight's torque a motor holds nothing, and its log is friction.
LEAST_HELD = 0.01


def moment_rows(robot: CompliantRobot, columns: Sequence[ParameterColumn], data: Observations) -> Floats:
    """Return (r, p + 1) whitened rows of the problem ``rows[:, :p] step = rows[:, p]`` about the present values.

    Parameters
    ----------
    robot : chain and effects with values.
    columns : the p free parameters; where links' moments are among them, these and the direction of gravity take part.
    data : with the motors' torques (`Observations.joint_torque`).
    """
    p = len(columns)
    effects = [robot.placed[column.placed].effect for column in columns]
    moments = [k for k, effect in enumerate(effects) if isinstance(effect, LinkMoments)]
    weighing = moments + [k for k, effect in enumerate(effects) if isinstance(effect, BaseTilt)]
    if not moments or not len(data.joint_torque) or data.setup.torque_gain_sigma <= 0.0:
        return np.zeros((0, p + 1))
    held = holding_torques(robot, data)
    slopes = np.stack([_slope(robot, columns[k], data, held) for k in weighing])
    logged = data.joint_torque * _sign(data.joint_torque, held)
    largest = float(np.sqrt(np.max(np.mean(held**2, axis=1))))
    pieces = [
        _rows_of_axis(logged[axis], held[axis], slopes[:, axis], data.setup.torque_gain_sigma)
        for axis in range(len(held))
        if np.sqrt(np.mean(held[axis] ** 2)) > LEAST_HELD * largest
    ]
    found = np.concatenate([*pieces, np.zeros((0, len(weighing) + 1))])
    rows = np.zeros((len(found), p + 1))
    rows[:, weighing], rows[:, p] = found[:, :-1], found[:, -1]
    return rows


def holding_torques(robot: CompliantRobot, data: Observations) -> Floats:
    """Return (L, n) what the motors make to hold the undeformed chain, N·m, in the sense of the logged angles."""
    chain, inputs = robot.adjusted_chain, Inputs(data.angles, data.wrench, data.setup)
    for placed in robot.placed:
        if isinstance(placed.effect, BaseTilt):
            inputs = placed.adjusted(inputs)
    carried = node_wrenches(chain, deformed_chain(chain, data.angles, None), inputs)
    add_side_torques(robot, data.angles, carried)
    sense = np.sign(np.diag(chain.drives_of_logged))
    return np.asarray(-sense[:, None] * (chain.drive_axes.T @ carried[joint_nodes(chain), chain.drive_components]))


def _slope(robot: CompliantRobot, column: ParameterColumn, data: Observations, held: Floats) -> Floats:
    """Return (L, n) what a unit of one link's moment, or of a turn of gravity, adds to the holding torques."""
    placed = robot.placed[column.placed]
    step = placed.effect.spec(column.symbol).typical
    value = placed.values.get(column.symbol, 0.0) + step
    changed = robot.with_values({placed.parameter_name(column.symbol): value})
    return np.asarray((holding_torques(changed, data) - held) / step)


def _sign(logged: Floats, held: Floats) -> float:
    known = np.isfinite(logged)
    return 1.0 if float(np.sum(np.where(known, logged * held, 0.0))) >= 0.0 else -1.0


def _rows_of_axis(logged: Floats, held: Floats, slopes: Floats, gain_sigma: float) -> Floats:
    """Return rows (r, q + 1) of one axis for q moments, gain and offset eliminated; none of too few readings.

    Parameters
    ----------
    logged, held : (n,) N·m. slopes : (q, n) N·m per kg·m. gain_sigma : relative.
    """
    known: Booleans = np.isfinite(logged)
    count, q = int(np.count_nonzero(known)), len(slopes)
    own = slopes[:, known]
    turning = np.linalg.norm(own, axis=1) > 0.0
    stack = np.concatenate([held[known][None], np.ones((1, count)), own, (logged - held)[known][None]])
    design = np.concatenate([stack[:2], own[turning]]).T
    solution, *_ = np.linalg.lstsq(design, stack[-1], rcond=1e-10)
    dof = count - int(np.linalg.matrix_rank(design))
    if dof < 1:
        return np.zeros((0, q + 1))
    scatter = float(np.sqrt(np.sum((stack[-1] - design @ solution) ** 2) / dof))
    scatter = max(scatter, 1e-9 * float(np.abs(logged[known]).max()))
    prior = np.zeros(q + 3)
    prior[0] = 1.0 / gain_sigma
    return triangular(np.vstack([stack.T / scatter, prior]))[2:-1, 2:]
