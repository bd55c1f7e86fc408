"""The observation: the model's prediction of what was measured in each state, block by block.

The observation matrix holds the first-order columns J_k[:, a] × (law's term): the direction of a Gauss–Newton step
about the balanced shape (002, eq. 9 and 12). What was measured comes from `stiffcal.identification.readings`, and can
be had from here too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.finite_columns import check_finite
from stiffcal.identification.geometry_terms import geometry_terms
from stiffcal.identification.readings import Observations, observe
from stiffcal.identification.weight_columns import weight_column
from stiffcal.mechanics.kinematics import cross
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.deformed_chain import unit_wrenches
from stiffcal.model.effect import Inputs, NodeLoads, Observed, ParameterRole, Term
from stiffcal.model.equilibrium import (
    NoBalanceError,
    Rest,
    WeightOnlyRest,
    blocks,
    counted_from,
    displacement_between,
    displacements,
    find_rest,
    first_order_displacement,
    last_node_inboard,
    law_terms,
    nominal_robot,
    rest_under_weight,
)
from stiffcal.model.held_at_rest import held_at_rest, second_order_turn

__all__ = [
    "Evaluation",
    "Observations",
    "ParameterColumn",
    "evaluate",
    "free_columns",
    "lever_of",
    "observe",
    "observed_displacement",
    "predicted",
    "predicted_rows",
    "rests",
]  # fmt: skip


# 5 nrad is 15 nm at three metres: a thousandth of the best tracker's noise, and a millionth of a deflection.
FIT_TOLERANCE = 5e-9
# Steps for derivatives by difference: a wrench step of the size of a sensor's noise, so that laws with a corner are
# averaged as the noise averages them.
FORCE_STEP, MOMENT_STEP = 1.0, 0.2


@dataclass(frozen=True)
class ParameterColumn:
    """One free parameter of a fit."""

    placed: int
    """Number of the placed effect in the robot's list."""
    symbol: str
    """The parameter's symbol."""
    role: ParameterRole
    """Amplitude, nonlinear or set-up."""


@dataclass(frozen=True)
class Evaluation:
    """The model's prediction of a block of states."""

    rows: slice
    """Which states."""
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
    rigid: bool = False,
) -> Iterator[Evaluation]:
    """Predict the observations and their derivatives, block by block.

    Parameters
    ----------
    robot : chain and effects with values.
    data : the observations.
    columns : the free parameters.
    with_sensitivity : also the derivative by the wrench.
    rigid : take columns on the undeformed chain and predict nothing: the first-order pass.
    """
    for rows in blocks(data.run, data.n_states, keep_runs=True):
        block = _evaluate_block(robot, data.subset(rows), rows, columns, with_sensitivity, rigid)
        check_finite(block.columns, robot, [(column.placed, column.symbol) for column in columns])
        yield block


def _evaluate_block(
    robot: CompliantRobot,
    data: Observations,
    block: slice,
    columns: Sequence[ParameterColumn],
    with_sensitivity: bool,
    rigid: bool,
) -> Evaluation:
    model = replace(robot, deformed=False) if rigid else robot
    loaded, unloaded = rests(model, data)
    data = held_by_bent_chain(model, data, unloaded)
    displacement = np.zeros((len(data.setup.targets), 6, data.n_states))
    prediction = np.zeros_like(data.measured)
    if not rigid:
        displacement = observed_displacement(model, data, loaded, unloaded)
        prediction = predicted_rows(data, displacement, loaded, unloaded)
    columns_out = np.zeros((len(columns), len(data.measured), data.n_states))
    rows = {
        (column.placed, column.symbol): row
        for row, column in enumerate(columns)
        if column.role is ParameterRole.AMPLITUDE
    }
    if rows:
        terms = [*loaded.terms, *geometry_terms(model.placed, model.chain, data)]
        _law_columns(model, terms, unloaded, _levers(loaded, data, terms), rows, columns_out)
    _observation_columns(model, data, displacement, columns_out, rows)
    _frame_columns(model, data, columns, loaded, columns_out)
    if not rigid:
        _difference_columns(model, data, columns, prediction, columns_out, (loaded, unloaded))
    sensitivity = _sensitivity(model, data, loaded) if with_sensitivity else None
    return Evaluation(block, prediction, columns_out, sensitivity)


def rests(model: CompliantRobot, data: Observations, for_memory: bool | None = None) -> tuple[Rest, WeightOnlyRest]:
    """Return the robot's rest under load, and what its displacements are counted from.

    Parameters
    ----------
    model : chain and effects with values.
    data : the observations.
    for_memory : whether laws with a memory act on this rest, which begins under weight alone; None: where the model
        holds some.
    """
    # state by state, so that no prediction depends on which others are evaluated with it
    inputs = Inputs(data.angles, data.wrench, data.setup, read=~data.absolute | data.wrench.any(axis=0))
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


def held_by_bent_chain(model: CompliantRobot, data: Observations, unloaded: WeightOnlyRest) -> Observations:
    """Return the observations with what clamped motors read taken on the chain as the model's weight bends it."""
    motors = data.layout.motors
    if motors is None:
        return data
    small = unloaded.displacement if model.deformed else None
    attachment = data.setup.targets[motors.held.target]
    held = held_at_rest(motors.held, model.adjusted_chain, data.angles, small, data.run, attachment)
    return replace(data, layout=replace(data.layout, motors=replace(motors, held=held)))


def observed_displacement(model: CompliantRobot, data: Observations, loaded: Rest, unloaded: WeightOnlyRest) -> Floats:
    """Return (B, 6, n) predicted displacement of the targets, observation effects included."""
    displacement = np.stack(displacements(model, loaded, unloaded))
    shift = np.zeros_like(displacement)
    observed = Observed(displacement, data.order, data.layout.held)
    for placed_effect in model.acting:
        finite = placed_effect.effect.observation_shift(placed_effect.place, observed, placed_effect.values)
        if finite is not None:
            shift += finite
            continue
        for symbol, column in placed_effect.effect.observation_columns(
            placed_effect.place, observed, placed_effect.shape()
        ).items():
            shift += placed_effect.amplitude(symbol) * column
    motors = data.layout.motors
    if motors is not None and model.deformed:
        target = motors.held.target
        shift[target] -= second_order_turn(
            motors.held, model.adjusted_chain, data.angles, unloaded.displacement, data.setup.targets[target],
            displacement[target],
        )  # fmt: skip
    return np.asarray(displacement + shift)


def predicted_rows(data: Observations, displacement: Floats, loaded: Rest, unloaded: WeightOnlyRest) -> Floats:
    """Return (m, n) what the rows read of the targets' displacements (B, 6, n) and of the links' own."""
    rows = data.layout.of_targets(displacement)
    if data.layout.rods:
        data.layout.add_rods(rows, loaded.displacement - unloaded.displacement)
    return rows


def predicted(model: CompliantRobot, data: Observations, loaded: Rest, unloaded: WeightOnlyRest) -> Floats:
    """Return (m, n) what the rows read of the model at rest."""
    data = held_by_bent_chain(model, data, unloaded)
    return predicted_rows(data, observed_displacement(model, data, loaded, unloaded), loaded, unloaded)


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


def _levers(
    loaded: Rest, data: Observations, terms: Sequence[tuple[PlacedEffect, Term]]
) -> dict[tuple[int, int], Floats]:
    """Return (node, component) to the lever, for all that the laws move."""
    components = {(term.node, term.component) for _, term in terms}
    return {key: lever_of(loaded, data, *key) for key in components}


def _law_columns(
    model: CompliantRobot,
    loaded: Sequence[tuple[PlacedEffect, Term]],
    unloaded: WeightOnlyRest,
    lever: dict[tuple[int, int], Floats],
    rows: dict[tuple[int, str], int],
    sensitivities: Floats,
) -> None:
    """Add levers times the laws' terms, less those under weight alone: displacements are counted from there."""
    numbers = {id(placed_effect): number for number, placed_effect in enumerate(model.acting)}
    values: dict[tuple[int, tuple[int, int]], Floats] = {}
    for sign, terms in ((1.0, loaded), (-1.0, unloaded.terms)):
        for placed_effect, term in terms:
            row, at = rows.get((numbers[id(placed_effect)], term.symbol)), (term.node, term.component)
            if row is not None and at in lever:
                values[row, at] = values[row, at] + sign * term.value if (row, at) in values else sign * term.value
    for (row, at), value in values.items():
        sensitivities[row] += lever[at] * value


def _observation_columns(
    model: CompliantRobot,
    data: Observations,
    displacement: Floats,
    sensitivities: Floats,
    rows: dict[tuple[int, str], int],
) -> None:
    observed = Observed(displacement, data.order, data.layout.held)
    for number, placed_effect in enumerate(model.placed):
        for symbol, column in placed_effect.effect.observation_columns(
            placed_effect.place, observed, placed_effect.shape()
        ).items():
            if (number, symbol) in rows:
                sensitivities[rows[number, symbol]] += data.layout.of_targets(column)


def _frame_columns(
    model: CompliantRobot,
    data: Observations,
    columns: Sequence[ParameterColumn],
    loaded: Rest,
    sensitivities: Floats,
) -> None:
    """Fill the columns of frames by a forward difference: the robot rests where it did, and is measured from elsewhere.

    As for the geometry, displacements depend on them by their square alone.
    """
    for row, column in enumerate(columns):
        placed_effect = model.placed[column.placed]
        if not placed_effect.effect.moves_frames:
            continue
        step = 1e-3 * placed_effect.effect.spec(column.symbol).size
        # From where the frame is now: the inputs hold its present values already.
        inputs = placed_effect.effect.adjusted(placed_effect.place, loaded.inputs, {column.symbol: step})
        moved = replace(loaded, inputs=inputs)
        change = [
            displacement_between(after, before) for after, before in zip(moved.targets, loaded.targets, strict=True)
        ]
        rows = data.layout.of_targets(np.where(data.absolute, np.stack(change), 0.0))
        sensitivities[row] = rows / step


def _difference_columns(
    model: CompliantRobot,
    data: Observations,
    columns: Sequence[ParameterColumn],
    prediction: Floats,
    sensitivities: Floats,
    at_rest: tuple[Rest, WeightOnlyRest],
) -> None:
    """Fill the columns of shape and set-up parameters: by the law's own derivatives, else by a forward difference."""
    slopes: dict[int, dict[str, Floats]] = {}
    for row, column in enumerate(columns):
        placed_effect = model.placed[column.placed]
        if column.role is ParameterRole.AMPLITUDE or placed_effect.effect.moves_frames:
            continue
        if placed_effect.effect.moves_masses or placed_effect.effect.turns_gravity:
            sensitivities[row] = weight_column(model, data, at_rest, placed_effect, column.symbol)
            continue
        if column.placed not in slopes:
            slopes[column.placed] = _shape_slopes(model, placed_effect, data, *at_rest)
        if column.symbol in slopes[column.placed]:
            sensitivities[row] = slopes[column.placed][column.symbol]
            continue
        spec = placed_effect.effect.spec(column.symbol)
        neutral = spec.typical if column.role is ParameterRole.NONLINEAR else spec.neutral
        value = placed_effect.values.get(column.symbol, neutral)
        step = 1e-4 * max(abs(value), spec.size)
        shifted = model.with_values({placed_effect.parameter_name(column.symbol): value + step})
        loaded, unloaded = rests(shifted, data)
        sensitivities[row] = (predicted(shifted, data, loaded, unloaded) - prediction) / step


def _shape_slopes(
    model: CompliantRobot, placed: PlacedEffect, data: Observations, loaded: Rest, unloaded: WeightOnlyRest
) -> dict[str, Floats]:
    """Return symbol to (m, n): what the law gives as its derivatives by shape parameters, moved to the rows."""
    columns: dict[str, Floats] = {}
    angles = loaded.inputs.angles
    amplitudes = {spec.symbol: placed.amplitude(spec.symbol) for spec in placed.specs(ParameterRole.AMPLITUDE)}
    rests = (
        (1.0, NodeLoads(loaded.wrench, angles, data.order, loaded.weight)),
        (-1.0, NodeLoads(unloaded.wrench, angles, reference_kelvin=data.order.reference_kelvin)),
    )
    for sign, loads in rests:
        for term in placed.effect.shape_slopes(placed.place, model.chain, loads, {**amplitudes, **placed.shape()}):
            column = sign * lever_of(loaded, data, term.node, term.component) * term.value
            columns[term.symbol] = columns.get(term.symbol, 0.0) + column
    return columns


def _sensitivity(model: CompliantRobot, data: Observations, loaded: Rest) -> Floats:
    """Return (m, 6, n): how the prediction moves with the wrench as read, on the shape as it stands."""
    base = [term for _, term in loaded.terms]
    direct, levered = unit_wrenches(model.chain, loaded.shape, loaded.inputs)
    result = np.zeros((len(data.measured), 6, data.n_states))
    wrench, displacement = loaded.wrench.copy(), np.empty_like(loaded.displacement)
    force, moment = loaded.wrench[:, :3], loaded.wrench[:, 3:]
    for axis in range(6 if data.setup.moments_measured else 3):
        step = FORCE_STEP if axis < 3 else MOMENT_STEP
        wrench[:, :3] = force + step * direct[:, :, axis] if axis < 3 else force
        wrench[:, 3:] = moment + step * (levered if axis < 3 else direct)[:, :, axis % 3]
        loads = NodeLoads(wrench, loaded.inputs.angles, data.order, loaded.weight)
        displacement[:] = 0.0
        for before, (placed_effect, term) in zip(base, law_terms(model, loads), strict=True):
            amplitude = placed_effect.amplitude(term.symbol)
            if amplitude:
                displacement[term.node, term.component] += (amplitude / step) * (term.value - before.value)
        full = np.stack(first_order_displacement(loaded, displacement))
        rows = data.layout.of_targets(full)
        data.layout.add_rods(rows, displacement)
        result[:, axis] = rows
    return result


def free_columns(robot: CompliantRobot, fixed: frozenset[str] = frozenset()) -> list[ParameterColumn]:
    """Return the robot's free parameters in order; ``fixed`` holds full names that keep their values."""
    return [
        ParameterColumn(number, spec.symbol, spec.role)
        for number, placed_effect in enumerate(robot.placed)
        for spec in placed_effect.effect.parameters
        if placed_effect.parameter_name(spec.symbol) not in fixed and not spec.discrete
    ]
