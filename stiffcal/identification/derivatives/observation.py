"""The observation: the model's prediction of what was measured in each state, block by block.

The observation matrix holds the first-order columns J_k[:, a] × (law's term): the direction of a Gauss–Newton step
about the balanced shape (002, eq. 9 and 12). What was measured comes from
`stiffcal.identification.readings.observations`, and can be had from here too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import ParameterColumn
from stiffcal.identification.derivatives.finite_columns import check_finite
from stiffcal.identification.derivatives.geometry_terms import geometry_terms
from stiffcal.identification.derivatives.observation_shift import STEP, observation_shift, observation_slopes
from stiffcal.identification.derivatives.state_blocks import state_blocks
from stiffcal.identification.derivatives.tangents import Tangents, loads_at_rest
from stiffcal.identification.derivatives.weight_columns import weight_column
from stiffcal.identification.readings.observations import Observations, observe
from stiffcal.mechanics.kinematics import StackedFrame, cross
from stiffcal.model.abilities import KnownSlopes
from stiffcal.model.assembled.base_tilt import BaseTilt
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.assembled.measured_frames import FramePosition
from stiffcal.model.balance.equilibrium import (
    NoBalanceError,
    WeightOnlyRest,
    counted_from,
    displacement_between,
    displacements,
    last_node_inboard,
    nominal_robot,
    rest_under_weight,
)
from stiffcal.model.balance.held_at_rest import held_at_rest, second_order_turn
from stiffcal.model.balance.rest import Rest, adjusted_inputs, find_rest
from stiffcal.model.effect import Inputs, ParameterRole
from stiffcal.model.laws.link_moments import LinkMoments

__all__ = [
    "Evaluation",
    "ModelAtRest",
    "Observations",
    "derivatives",
    "evaluate",
    "lever_of",
    "observe",
    "predicted",
    "predicted_rows",
    "rests",
]  # fmt: skip


# 5 nrad is 15 nm at three metres: a thousandth of the best tracker's noise, and a millionth of a deflection.
FIT_TOLERANCE = 5e-9


@dataclass(frozen=True)
class Evaluation:
    """The model's prediction of a block of states."""

    states: slice
    """Which of them."""
    predicted: Floats
    """(m, n) displacement, base axes; of gauges and rods their change."""
    columns: Floats
    """(p, m, n) derivatives by the free parameters."""
    sensitivity: Floats | None
    """(m, 6, n) derivative by the wrench as read, or None."""


def evaluate(
    robot: CompliantRobot,
    data: Observations,
    columns: Sequence[ParameterColumn] = (),
    with_sensitivity: bool = False,
) -> Iterator[Evaluation]:
    """Predict the observations and their derivatives, block by block.

    Parameters
    ----------
    robot : chain and effects with values.
    data : the observations.
    columns : the free parameters.
    with_sensitivity : also the derivative by the wrench.
    """
    for states in state_blocks(robot, data):
        yield ModelAtRest.about(robot, data.subset(states)).evaluated(states, columns, with_sensitivity)


def derivatives(robot: CompliantRobot, data: Observations, columns: Sequence[ParameterColumn]) -> Floats:
    """Return (p, m, n) derivatives of the predicted observations alone; parameters as of `evaluate`."""
    return np.concatenate([block.columns for block in evaluate(robot, data, columns)], axis=2)


@dataclass(frozen=True)
class ModelAtRest:
    """A model at rest in all states."""

    robot: CompliantRobot
    """Chain and effects with values."""
    data: Observations
    """The observations, what clamped motors read taken on the bent chain."""
    loaded: Rest
    """The rests under load."""
    unloaded: WeightOnlyRest
    """The rests under weight alone."""
    displacement: Floats
    """(B, 6, n) displacements of the targets, before effects of the measurement."""
    predicted: Floats
    """(m, n) what the rows read."""
    tangents: Tangents
    """How the rows move with displacements of nodes."""

    @classmethod
    def about(cls, robot: CompliantRobot, data: Observations, for_memory: bool | None = None) -> Self:
        """Find the rests of a robot in all states; ``for_memory`` as in `rests`."""
        loaded, unloaded = rests(robot, data, for_memory)
        data = held_by_bent_chain(robot, data, unloaded)
        displacement = np.stack(displacements(robot, loaded, unloaded))
        rows = predicted_rows(robot, data, displacement, loaded, unloaded)
        return cls(robot, data, loaded, unloaded, displacement, rows, Tangents(robot, data, loaded, unloaded))

    def evaluated(self, states: slice, columns: Sequence[ParameterColumn], with_sensitivity: bool) -> Evaluation:
        """Return what is read of these states, which are ``states`` of all, with its derivatives; see `evaluate`."""
        sensitivity = self.tangents.reading_rows() if with_sensitivity else None
        return Evaluation(states, self.predicted, self.columns(columns), sensitivity)

    def columns(self, columns: Sequence[ParameterColumn]) -> Floats:
        """Return (p, m, n) derivatives of what the rows read by p free parameters."""
        result = np.zeros((len(columns), *self.predicted.shape))
        rows = {
            (column.placed, column.symbol): row
            for row, column in enumerate(columns)
            if column.role is ParameterRole.AMPLITUDE
        }
        if rows:
            _law_columns(self.robot, self.data, self.loaded, self.tangents, rows, result)
        _observation_columns(self.robot, self.data, self.displacement, result, rows)
        _frame_columns(self.robot, self.data, columns, self.loaded, self.unloaded, result)
        _difference_columns(self.robot, self.data, columns, result, self.loaded, self.tangents)
        check_finite(result, self.robot, [(column.placed, column.symbol) for column in columns])
        return result


def rests(model: CompliantRobot, data: Observations, for_memory: bool | None = None) -> tuple[Rest, WeightOnlyRest]:
    """Return the robot's rest under load, and what its displacements are counted from.

    Parameters
    ----------
    model : chain and effects with values.
    data : the observations.
    for_memory : whether laws with a memory act on this rest, which begins under weight alone; None: where the model
        holds some.
    """
    inputs = inputs_of(data)
    for_memory = model.has_memory if for_memory is None else for_memory
    try:
        if data.absolute.all() and not (for_memory or data.order.motor_torque.any()):
            # counted from the robot file's robot, and nothing asks for the rest under weight alone
            loaded = find_rest(model, inputs, data.order, tolerance=FIT_TOLERANCE)
            return loaded, replace(nominal_robot(model.chain, inputs), absolute=data.absolute)
        unloaded = rest_under_weight(model, inputs, FIT_TOLERANCE, data.order)
        loaded = find_rest(model, inputs, data.order, unloaded.wrench, unloaded.displacement, FIT_TOLERANCE)
    except NoBalanceError as error:
        raise error.at_state(error.state, f"{data.place_of(error.state)}, {error.where}") from None
    if data.absolute.any():
        unloaded = counted_from(unloaded, nominal_robot(model.chain, inputs), data.absolute)
    return loaded, unloaded


def inputs_of(data: Observations) -> Inputs:
    """Return what goes into the balance: state by state, so that no prediction depends on which others are there."""
    read = ~data.absolute | data.wrench.any(axis=0)
    return Inputs(data.angles, data.wrench, data.setup, read=read, tracker=data.tracker)


def held_by_bent_chain(model: CompliantRobot, data: Observations, unloaded: WeightOnlyRest) -> Observations:
    """Return the observations with what clamped motors read taken on the chain as the model's weight bends it."""
    motors = data.layout.motors
    if motors is None:
        return data
    small = unloaded.displacement if model.deformed else None
    attachment = data.setup.targets[motors.held.target]
    held = held_at_rest(motors.held, model.adjusted_chain, data.angles, small, data.run, attachment)
    return replace(data, layout=replace(data.layout, motors=replace(motors, held=held)))


def predicted_rows(
    model: CompliantRobot, data: Observations, displacement: Floats, loaded: Rest, unloaded: WeightOnlyRest
) -> Floats:
    """Return (m, n) what the rows read of the targets' displacements (B, 6, n) and of the links' own.

    Parameters
    ----------
    displacement : where the model rests, before effects of the measurement.
    """
    read = displacement + observation_shift(model, data, displacement)
    motors = data.layout.motors
    if motors is not None and model.deformed:
        target = motors.held.target
        read[target] -= second_order_turn(
            motors.held, model.adjusted_chain, data.angles, unloaded.displacement, data.setup.targets[target],
            displacement[target],
        )  # fmt: skip
    rows = data.layout.of_targets(read)
    if data.layout.rods:
        data.layout.add_rods(rows, loaded.displacement - unloaded.displacement)
    return rows


def predicted(model: CompliantRobot, data: Observations, loaded: Rest, unloaded: WeightOnlyRest) -> Floats:
    """Return (m, n) what the rows read of the model at rest."""
    data = held_by_bent_chain(model, data, unloaded)
    return predicted_rows(model, data, np.stack(displacements(model, loaded, unloaded)), loaded, unloaded)


def lever_of(loaded: Rest, data: Observations, node: int, component: int) -> Floats:
    """Return (m, n) how the observations move with one component of a node's small displacement."""
    n_joints = len(loaded.shape.bodies) - 2
    frame = loaded.shape.nodes[node]
    axis = frame.rotation[:, component % 3]
    targets = loaded.inputs.setup.targets
    full = np.zeros((len(targets), 6, axis.shape[1]))
    for b, target in enumerate(targets):
        if node > last_node_inboard(target.body, n_joints):
            continue
        if component < 3:
            full[b, :3] = axis
        else:
            full[b, :3] = cross(axis, loaded.targets[b].position - loaded.shape.origins[node])
            full[b, 3:] = axis
    rows = data.layout.of_targets(full)
    data.layout.add_rod_levers(rows, node, component)
    return rows


def _law_columns(
    model: CompliantRobot,
    data: Observations,
    loaded: Rest,
    tangents: Tangents,
    rows: dict[tuple[int, str], int],
    sensitivities: Floats,
) -> None:
    """Add tangents times the laws' terms, less those under weight alone: displacements are counted from there."""
    numbers = {id(placed_effect): number for number, placed_effect in enumerate(model.acting)}
    acting = (loaded.terms, [] if tangents.poses is None else tangents.poses.terms)
    under_load, under_weight = (
        [(rows.get((numbers[id(placed_effect)], term.symbol)), term) for placed_effect, term in terms]
        for terms in acting
    )
    for row, column in tangents.law_columns(under_load, under_weight).items():
        if row is not None:
            sensitivities[row] += column
    by_geometry: dict[tuple[int, int], Floats] = {}
    chosen = [model.placed[number] for number in dict.fromkeys(number for number, _ in rows)]
    for placed_effect, term in geometry_terms(model, chosen, data, loaded.inputs.angles):
        row, at = rows.get((numbers[id(placed_effect)], term.symbol)), (term.node, term.component)
        if row is not None:
            by_geometry[at] = by_geometry[at] if at in by_geometry else tangents.geometry_rows(*at)
            sensitivities[row] += by_geometry[at] * term.value


def _observation_columns(
    model: CompliantRobot,
    data: Observations,
    displacement: Floats,
    sensitivities: Floats,
    rows: dict[tuple[int, str], int],
) -> None:
    for number, placed_effect in enumerate(model.placed):
        for symbol, column in observation_slopes(placed_effect, data, displacement).items():
            if (number, symbol) in rows:
                sensitivities[rows[number, symbol]] += data.layout.of_targets(column)


def _frame_columns(
    model: CompliantRobot,
    data: Observations,
    columns: Sequence[ParameterColumn],
    loaded: Rest,
    unloaded: WeightOnlyRest,
    sensitivities: Floats,
) -> None:
    """Fill the columns of frames by difference: the robot rests where it did, and is measured from elsewhere."""
    if not any(isinstance(model.placed[column.placed].effect, FramePosition) for column in columns):
        return
    inputs_before = [inputs_of(data)]
    """As each of the acting effects finds them, and as the last leaves them."""
    for acting in model.acting:
        inputs_before.append(acting.adjusted(inputs_before[-1]))
    for row, column in enumerate(columns):
        placed_effect = model.placed[column.placed]
        if not isinstance(placed_effect.effect, FramePosition):
            continue
        spec = placed_effect.effect.spec(column.symbol)
        step = STEP * spec.size
        value = placed_effect.values.get(column.symbol, spec.neutral)

        def measured(end: float, number: int = column.placed, symbol: str = column.symbol) -> Floats:
            values = {**model.placed[number].values, symbol: end}
            inputs = model.placed[number].adjusted(inputs_before[number], values)
            for later in model.acting[number + 1 :]:
                inputs = later.adjusted(inputs)
            after = _targets(loaded, inputs)
            change = [displacement_between(moved, start) for moved, start in zip(after, loaded.targets, strict=True)]
            if unloaded.poses is None or unloaded.pose is None:
                return np.stack(change)
            before = [frame.states(unloaded.pose) for frame in _targets(unloaded.poses, inputs)]
            displaced = [displacement_between(moved, start) for moved, start in zip(after, before, strict=True)]
            return np.where(data.absolute, np.stack(change), np.stack(displaced))

        sensitivities[row] = data.layout.of_targets(measured(value + step) - measured(value - step)) / (2.0 * step)


def _targets(rest: Rest, adjusted: Inputs) -> list[StackedFrame]:
    """Return the targets of a rest as they are reported with set-up and trackers of other inputs."""
    inputs = replace(rest.inputs, setup=adjusted.setup, tracker_error=adjusted.tracker_error)
    return replace(rest, inputs=inputs).targets


def _difference_columns(
    model: CompliantRobot,
    data: Observations,
    columns: Sequence[ParameterColumn],
    sensitivities: Floats,
    loaded: Rest,
    tangents: Tangents,
) -> None:
    """Fill the columns of shape and set-up parameters: by the law's own derivatives, else by a central difference."""
    slopes: dict[int, dict[str, Floats]] = {}
    for row, column in enumerate(columns):
        placed_effect = model.placed[column.placed]
        if column.role is ParameterRole.AMPLITUDE or isinstance(placed_effect.effect, FramePosition):
            continue
        if isinstance(placed_effect.effect, LinkMoments | BaseTilt):
            sensitivities[row] = weight_column(tangents, placed_effect, column.symbol)
            continue
        if column.placed not in slopes:
            slopes[column.placed] = _shape_slopes(model, placed_effect, data, loaded, tangents)
        if column.symbol in slopes[column.placed]:
            sensitivities[row] = slopes[column.placed][column.symbol]
            continue
        spec = placed_effect.effect.spec(column.symbol)
        neutral = spec.typical if column.role is ParameterRole.NONLINEAR else spec.neutral
        value = placed_effect.values.get(column.symbol, neutral)
        step = 1e-4 * max(abs(value), spec.size)
        name = placed_effect.parameter_name(column.symbol)
        low, high = (model.with_values({name: value + sign * step}) for sign in (-1.0, 1.0))
        by_wrench = None if data.layout.motors is not None else _change_of_wrench(low, high, inputs_of(data))
        if by_wrench is not None:
            sensitivities[row] = np.einsum("man,an->mn", tangents.reading_rows(), by_wrench / (2.0 * step))
        else:
            sensitivities[row] = (_predicted_anew(high, data) - _predicted_anew(low, data)) / (2.0 * step)


def _change_of_wrench(low: CompliantRobot, high: CompliantRobot, inputs: Inputs) -> Floats | None:
    """Return (6, n) by how much two robots' set-ups make another wrench of the reading; None where more differs."""
    one, other = adjusted_inputs(low, inputs), adjusted_inputs(high, inputs)
    changed = other.wrench - one.wrench
    measured_alike = one.setup is other.setup and one.tracker_error is other.tracker_error
    alike = measured_alike and np.array_equal(one.angles, other.angles)
    return changed if alike and changed.any() else None


def _predicted_anew(model: CompliantRobot, data: Observations) -> Floats:
    return predicted(model, data, *rests(model, data))


def _shape_slopes(
    model: CompliantRobot,
    placed: PlacedEffect,
    data: Observations,
    loaded: Rest,
    tangents: Tangents,
) -> dict[str, Floats]:
    """Return symbol to (m, n): what the law gives as its derivatives by shape parameters, moved to the rows."""
    if not isinstance(placed.effect, KnownSlopes):
        return {}
    amplitudes = {spec.symbol: placed.amplitude(spec.symbol) for spec in placed.specs(ParameterRole.AMPLITUDE)}
    values = {**amplitudes, **placed.shape()}
    under_load, under_weight = (
        [] if carried is None else placed.effect.shape_slopes(placed.place, model.chain, carried, values)
        for carried in (loads_at_rest(loaded, data), tangents.loads_of_poses)
    )
    return tangents.law_columns(*([(term.symbol, term) for term in terms] for terms in (under_load, under_weight)))
