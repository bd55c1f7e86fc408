"""The balance of the deformed chain: where the robot comes to rest under weight and a wrench.

Every node answers the wrench that it carries with a small displacement in its own axes; the wrench is taken on the
deformed, weight-sagged shape, so that shape and wrench are found together, by fixed-point iteration. For joint springs
alone this is (K_θ − K_C) Δθ = Jᵀ F carried to all orders (Alici and Shirinzadeh 2005; Klimchik et al.; physics,
section 1). Prediction, identification, simulation and compensation all come here.

Why fixed point and not Newton: a load changes the levers by well under a percent on a robot that still works, so that
every sweep gains two digits or more and none needs a derivative of the laws.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.mechanics.kinematics import StackedFrame
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.deformed_chain import DeformedChain, deformed_chain, node_wrenches
from stiffcal.model.balance.no_balance import NoBalanceError as NoBalanceError
from stiffcal.model.balance.no_balance import no_balance
from stiffcal.model.balance.stated_spring import parallel_spring, stated_spring
from stiffcal.model.effect import Inputs, NodeLoads, StateOrder, Term, joint_node, joint_nodes, tool_node
from stiffcal.model.forms import MotorFriction
from stiffcal.model.laws.drives import drive_torque

# 1e-12 rad is 3 pm at three metres: a hundred-thousandth of the best tracker's noise.
TOLERANCE = 1e-12
MAX_SWEEPS = 200
# Below this ratio of two sweeps' changes the next sweep's change is predicted well enough to be left out.
EVEN_CONTRACTION = 0.05


@dataclass(frozen=True)
class Rest:
    """Where n states came to rest."""

    shape: DeformedChain
    """The deformed chain."""
    wrench: Floats
    """(2J + 2, 6, n) what the nodes carry, node axes."""
    displacement: Floats
    """(2J + 2, 6, n) their small displacements, node axes."""
    terms: list[tuple[PlacedEffect, Term]]
    """The laws' terms at rest, each with the placed effect that made it."""
    inputs: Inputs
    """What went in, after the effects that change it."""
    sweeps: int
    """How many fixed-point sweeps it took."""
    weight: Floats | None
    """What the nodes carry under weight alone, as it was handed in, or None."""

    @cached_property
    def targets(self) -> list[StackedFrame]:
        """The frame of each of the set-up's targets, on the deformed chain, as the tracker reports it in base axes."""
        return reported_targets(self.shape.bodies, self.inputs)


def reported_targets(bodies: Sequence[StackedFrame], inputs: Inputs) -> list[StackedFrame]:
    """Return the frame of each target, given those of the bodies, as the tracker reports it in base axes."""
    frames = [bodies[target.body].moved(target.transform) for target in inputs.setup.targets]
    if inputs.tracker_error is None:
        return frames
    turn, shift = inputs.tracker_error[:, :3, :3], inputs.tracker_error[:, :3, 3]
    shifts = shift[0][:, None] if inputs.tracker is None else shift[inputs.tracker].T
    return [
        StackedFrame(
            reported_turn(turn, inputs.tracker, frame.rotation),
            reported_turn(turn, inputs.tracker, frame.position) + shifts,
        )
        for frame in frames
    ]


def reported_turn(turn: Floats, tracker: Integers | None, vectors: Floats) -> Floats:
    """Return vectors (3, …, n) in base axes, turned as the tracker of each state is, (T, 3, 3)."""
    if tracker is None or len(turn) == 1:
        return np.asarray(turn[0] @ vectors if vectors.ndim == 2 else np.einsum("ij,jkn->ikn", turn[0], vectors))
    return np.asarray(np.einsum("nij,j...n->i...n", turn[tracker], vectors))


def law_terms(robot: CompliantRobot, loads: NodeLoads) -> list[tuple[PlacedEffect, Term]]:
    """Return the terms of all laws under these loads."""
    return [
        (placed_effect, term)
        for placed_effect in robot.acting
        for term in placed_effect.terms(robot.chain, loads)
    ]  # fmt: skip


def node_displacements(robot: CompliantRobot, terms: list[tuple[PlacedEffect, Term]], n: int) -> Floats:
    """Sum the terms, times their amplitudes, into (2J + 2, 6, n) node displacements."""
    small = np.zeros((tool_node(robot.chain) + 1, 6, n))
    for placed_effect, term in terms:
        amplitude = placed_effect.amplitude(term.symbol)
        if amplitude != 0.0:
            small[term.node, term.component] += amplitude * term.value
    return small


def add_side_torques(robot: CompliantRobot, angles: Floats, wrench: Floats) -> None:
    """Add torques that act in parallel with a drive (balancing springs) to what its joint carries."""
    stated = stated_spring(robot)
    if stated is not None:
        component = robot.chain.drive_components[stated.joint - 1]
        wrench[joint_node(stated.joint), component] += stated.torque(angles[stated.joint - 1])
    for placed_effect in robot.acting:
        spring = parallel_spring(robot.chain, placed_effect)
        if spring is not None:
            wrench[joint_node(spring.joint), robot.chain.drive_components[spring.joint - 1]] += spring.torque(
                angles[spring.joint - 1]
            )


def _take_off_friction(robot: CompliantRobot, wrench: Floats, order: StateOrder | None, weight: Floats | None) -> None:
    """Leave on joints whose motor's torque was measured what reaches their springs through the drive's friction."""
    if order is None or not order.motor_torque.any():
        return
    for placed_effect in robot.acting:
        effect, values = placed_effect.effect, placed_effect.values
        if not isinstance(effect, MotorFriction):
            continue
        joint = placed_effect.place.joints[0]
        torque = drive_torque(robot.chain, wrench, joint)
        start = None if weight is None else drive_torque(robot.chain, weight, joint)
        remaining = effect.spring_torque(placed_effect.place, torque, order.run, start, values)
        if remaining is None:
            continue
        loss = np.where(order.motor_torque, remaining - torque, 0.0)
        # τ_drive = Mᵀ τ_model: a change of one drive's torque is one of all model joints that it turns
        share = np.linalg.inv(robot.chain.drive_axes)[joint - 1]
        wrench[joint_nodes(robot.chain), robot.chain.drive_components] += share[:, None] * loss


def adjusted_inputs(robot: CompliantRobot, inputs: Inputs) -> Inputs:
    """Return the inputs as the robot's effects change them."""
    for placed_effect in robot.acting:
        inputs = placed_effect.adjusted(inputs)
    return inputs


# What overflows on the way to no balance is found by its result, and needs no warnings of numpy.
@np.errstate(over="ignore", invalid="ignore")
def find_rest(
    robot: CompliantRobot,
    inputs: Inputs,
    order: StateOrder | None = None,
    weight: Floats | None = None,
    start: Floats | None = None,
    tolerance: float = TOLERANCE,
    kelvin: Floats | None = None,
) -> Rest:
    """Find where the loaded chain comes to rest.

    Parameters
    ----------
    robot : chain and effects with values.
    inputs : angles (J, n), wrench (6, n) as read, set-up.
    order : order and time of the states, for laws with a memory.
    weight : (2J + 2, 6, n) node wrenches under weight alone, for laws with a memory.
    start : (2J + 2, 6, n) displacements to start from.
    tolerance : rad and m, largest change of a displacement in the last sweep.
    kelvin : (n,) K, the temperature of states without an order; None: not known.

    Raises
    ------
    NoBalanceError : the iteration does not settle.
    """
    inputs = adjusted_inputs(robot, inputs)
    chain = robot.adjusted_chain
    n = inputs.angles.shape[1]
    # The papers' linear form takes every wrench on the rigid chain: a start would sag it under its weight.
    small = start if robot.deformed else None
    turns = np.cos(inputs.angles), np.sin(inputs.angles)
    previous = np.inf
    for sweep in range(1, MAX_SWEEPS + 1):
        shape = deformed_chain(chain, inputs.angles, small, turns)
        wrench = node_wrenches(chain, shape, inputs)
        joint_turn = (
            inputs.angles if small is None else inputs.angles + small[joint_nodes(chain), chain.drive_components]
        )
        add_side_torques(robot, joint_turn, wrench)
        _take_off_friction(robot, wrench, order, weight)
        terms = law_terms(robot, NodeLoads(wrench, inputs.angles, order, weight, kelvin))
        updated = node_displacements(robot, terms, n)
        before, small = small, updated
        change = _largest_change(before, updated, terms if sweep > 1 else None)
        if not robot.deformed:
            return Rest(shape, wrench, small, terms, inputs, sweep, weight)
        # Sweeps contract evenly: what the next one would still change is this change times the last ratio.
        ratio = change / previous if 0.0 < previous < np.inf else 1.0
        if change <= tolerance or (ratio < EVEN_CONTRACTION and ratio * change <= tolerance):
            shape = deformed_chain(chain, inputs.angles, small, turns)
            return Rest(shape, wrench, small, terms, inputs, sweep, weight)
        if not np.isfinite(change) or (sweep > 20 and change > 2.0 * previous):
            break
        previous = change
    step = updated if before is None else updated - before
    raise no_balance(robot, inputs, updated, np.abs(step).max(axis=(0, 1)))


def _largest_change(before: Floats | None, after: Floats, terms: list[tuple[PlacedEffect, Term]] | None) -> float:
    """Return the largest change of displacements (2J + 2, 6, n); with ``terms``, which made both, of what they move."""
    if before is None or terms is None:
        return float(np.max(np.abs(after if before is None else after - before), initial=0.0))
    moved = {(term.node, term.component) for _, term in terms}
    # NumPy's largest number is NaN where one is
    return float(np.max([np.max(np.abs(after[at] - before[at]), initial=0.0) for at in moved], initial=0.0))
