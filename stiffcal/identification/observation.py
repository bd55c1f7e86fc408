"""The observation: what was measured in each state, and what the model says of it, block by block.

Displacements are taken relative to one reading per run; as that reading is as noisy as the others, each run carries a
free constant offset instead of trusting it (physics, section 3). The observation matrix holds the first-order columns
J_k[:, a] × (law's term): the direction of a Gauss–Newton step about the balanced shape (002, eq. 9 and 12).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.measurements.load_states import LoadStates, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import cross, turn_between
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import Inputs, NodeLoads, Observed, Sort, StateOrder
from stiffcal.model.equilibrium import (
    Rest,
    Unloaded,
    blocks,
    displacements,
    find_rest,
    last_node_inboard,
    law_terms,
    rest_under_weight,
)
from stiffcal.model.shape import unit_wrenches
from stiffcal.reduction.load_cycles import run_members
from stiffcal.reduction.screening import load_is_good

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.int64]

# 5 nrad is 15 nm at three metres: a thousandth of the best tracker's noise, and a millionth of a deflection.
FIT_TOLERANCE = 5e-9
# Steps for derivatives by difference: a wrench step of the size of a sensor's noise, so that laws with a corner are
# averaged as the noise averages them.
FORCE_STEP, MOMENT_STEP = 1.0, 0.2


@dataclass(frozen=True)
class Observations:
    """What was measured, ready for a fit: n states, m components each, state axis last.

    Attributes
    ----------
    angles : (J, n) model joint angles, rad, constant within a run.
    wrench : (6, n) as read, N and N·m.
    order : order and time of the states.
    measured : (m, n) displacement since the run's reference reading, base axes, m and rad; 0 where not measured.
    seen : (m, n) True where measured.
    rotational : (m,) True for rotation components.
    body : (m,) which target the component belongs to.
    component : (m,) 0 … 5 of the target's displacement.
    free_offset : True where each run carries a free offset.
    run : (n,) run number.
    setup : where the instruments sit.
    index : (n,) index of the state in the campaign's load states.
    """

    angles: Floats
    wrench: Floats
    order: StateOrder
    measured: Floats
    seen: Booleans
    rotational: Booleans
    body: Integers
    component: Integers
    free_offset: bool
    run: Integers
    setup: MeasurementSetup
    index: Integers

    @property
    def n_states(self) -> int:
        """How many states there are, n."""
        return int(self.run.shape[0])

    @property
    def n_seen(self) -> int:
        """How many of the n states have a reading."""
        return int(np.count_nonzero(self.seen.any(axis=0)))

    def part(self, pick: slice | Booleans | Integers) -> Observations:
        """Return some of the states."""
        return replace(
            self,
            angles=self.angles[:, pick],
            wrench=self.wrench[:, pick],
            order=self.order.block(pick),
            measured=self.measured[:, pick],
            seen=self.seen[:, pick],
            run=self.run[pick],
            index=self.index[pick],
        )


def _reference_of_runs(states: LoadStates) -> Integers:
    """Return (n,) the index of each state's reference reading.

    The marked one; where that is not usable, the usable state with the least load: rotation vectors taken from a
    loaded state differ in second order from those that the model counts from the unloaded one.
    """
    reference = np.zeros(len(states), dtype=np.int64)
    load, used = np.sqrt(np.sum(states.wrench**2, axis=1)), states.used
    for members in run_members(states.run):
        usable = members[used[members]]
        marked = usable[states.reference[usable]]
        candidates = usable if len(usable) else members
        reference[members] = marked[0] if len(marked) else candidates[np.argmin(load[candidates])]
    return reference


def observe(states: LoadStates, chain: Chain) -> Observations:
    """Turn load states into observations for a fit; readings set aside are not seen."""
    reference = _reference_of_runs(states)
    given = states.deflection_given
    pieces, rotational, body, component = [], [], [], []
    for b in range(states.position.shape[1] if not given else states.deflection.shape[1]):
        if given:
            displacement = states.deflection[:, b]
        else:
            moved = states.position[:, b] - states.position[reference, b]
            rotation = np.ascontiguousarray(np.moveaxis(states.rotation[:, b], 0, -1))
            turned = turn_between(rotation, rotation[:, :, reference]).T
            displacement = np.concatenate([moved, turned], axis=1)
        for axis in range(6):
            if np.isfinite(displacement[:, axis]).any():
                pieces.append(displacement[:, axis])
                rotational.append(axis >= 3)
                body.append(b)
                component.append(axis)
    measured = np.stack(pieces) if pieces else np.zeros((0, len(states)))
    # A bumped reading is no observation, but the robot went through its load, and laws with a memory must too.
    keep = np.flatnonzero(load_is_good(states) & np.isfinite(states.wrench[:, :3]).all(axis=1))
    measured = measured[:, keep]
    seen = np.isfinite(measured) & states.used[keep]
    return Observations(
        angles=_run_angles(states, chain)[:, keep],
        wrench=np.ascontiguousarray(np.nan_to_num(states.wrench[keep]).T),
        order=_order(states, chain, reference, keep),
        measured=np.where(seen, measured, 0.0),
        seen=seen,
        rotational=np.array(rotational, dtype=np.bool_),
        body=np.array(body, dtype=np.int64),
        component=np.array(component, dtype=np.int64),
        free_offset=not given,
        run=states.run[keep],
        setup=states.setup,
        index=keep,
    )


def _run_angles(states: LoadStates, chain: Chain) -> Floats:
    """Return (J, n) model angles, each run's mean: the pose stands still, and a mean takes the encoders' noise out."""
    angles = np.ascontiguousarray(chain.model_angles(states.joints).T)
    _, number = np.unique(states.run, return_inverse=True)
    count = np.bincount(number)
    return np.stack([(np.bincount(number, weights=row) / count)[number] for row in angles])


def _order(states: LoadStates, chain: Chain, reference: Integers, keep: Integers) -> StateOrder:
    angles = chain.model_angles(states.joints)
    motor = (angles - angles[reference]).T
    warm = (
        states.temperature[:, 0] - states.temperature[reference, 0]
        if states.temperature.shape[1]
        else np.full(len(states), np.nan)
    )
    return StateOrder(
        run=states.run[keep],
        time=states.time[keep],
        hold=states.hold[keep],
        motor=np.ascontiguousarray(np.nan_to_num(motor[:, keep])),
        temperature=warm[keep],
        since_reference=(states.time - states.time[reference])[keep],
        number=keep + 1,
    )


@dataclass(frozen=True)
class Column:
    """One free parameter of a fit.

    Attributes
    ----------
    placed : number of the placed effect in the robot's list.
    symbol : the parameter's symbol.
    sort : amplitude, shape or set-up.
    """

    placed: int
    symbol: str
    sort: Sort


@dataclass(frozen=True)
class Evaluation:
    """What the model says of a block of states.

    Attributes
    ----------
    part : which states.
    predicted : (m, n) displacement, base axes.
    columns : (p, m, n) derivatives by the free parameters.
    sensitivity : (m, 6, n) derivative by the wrench as read, or None.
    """

    part: slice
    predicted: Floats
    columns: Floats
    sensitivity: Floats | None


def evaluate(
    robot: CompliantRobot,
    data: Observations,
    columns: Sequence[Column] = (),
    with_sensitivity: bool = False,
    rigid: bool = False,
) -> Iterator[Evaluation]:
    """Predict the observations and their derivatives, block by block.

    Parameters
    ----------
    robot : chain and valued effects.
    data : the observations.
    columns : the free parameters.
    with_sensitivity : also the derivative by the wrench.
    rigid : take columns on the undeformed chain and predict nothing: the first-order pass.
    """
    for part in blocks(data.run, data.n_states, keep_runs=True):
        yield _evaluate_block(robot, data.part(part), part, columns, with_sensitivity, rigid)


def _evaluate_block(
    robot: CompliantRobot,
    data: Observations,
    part: slice,
    columns: Sequence[Column],
    with_sensitivity: bool,
    rigid: bool,
) -> Evaluation:
    model = replace(robot, deformed=False) if rigid else robot
    loaded, unloaded = rests(model, data)
    predicted = np.zeros_like(data.measured) if rigid else predicted_displacement(model, data, loaded, unloaded)
    lever = _levers(loaded, data)
    found = np.zeros((len(columns), len(data.measured), data.n_states))
    rows = {(column.placed, column.symbol): row for row, column in enumerate(columns) if column.sort is Sort.AMPLITUDE}
    if rows:
        _law_columns(model, loaded, unloaded, lever, rows, found)
    _observation_columns(model, data, predicted, found, rows)
    if not rigid:
        _difference_columns(model, data, columns, predicted, found)
    sensitivity = _sensitivity(model, data, loaded, lever) if with_sensitivity else None
    return Evaluation(part, predicted, found, sensitivity)


def rests(model: CompliantRobot, data: Observations) -> tuple[Rest, Unloaded]:
    """Return where the robot rests under load and under weight alone."""
    inputs = Inputs(data.angles, data.wrench, data.setup)
    unloaded = rest_under_weight(model, inputs, FIT_TOLERANCE)
    loaded = find_rest(model, inputs, data.order, unloaded.wrench, unloaded.displacement, FIT_TOLERANCE)
    return loaded, unloaded


def predicted_displacement(model: CompliantRobot, data: Observations, loaded: Rest, unloaded: Unloaded) -> Floats:
    """Return (m, n) predicted displacement, observation effects included."""
    displacement = np.stack(displacements(model, loaded, unloaded))
    shift = np.zeros_like(displacement)
    observed = Observed(displacement, data.order)
    for one in model.placed:
        finite = one.effect.observation_shift(one.place, observed, one.values)
        if finite is not None:
            shift += finite
            continue
        for symbol, column in one.effect.observation_columns(one.place, observed, one.shape()).items():
            shift += one.amplitude(symbol) * column
    return np.asarray((displacement + shift)[data.body, data.component])


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
            full[b, :3] = cross(axis, loaded.target(target).position - loaded.shape.origins[node])
            full[b, 3:] = axis
    return np.asarray(full[data.body, data.component])


def _levers(loaded: Rest, data: Observations) -> dict[tuple[int, int], Floats]:
    """Return (node, component) to the lever, for all that the laws move."""
    wanted = {(term.node, term.component) for _, term in loaded.terms}
    return {key: lever_of(loaded, data, *key) for key in wanted}


def _law_columns(
    model: CompliantRobot,
    loaded: Rest,
    unloaded: Unloaded,
    lever: dict[tuple[int, int], Floats],
    rows: dict[tuple[int, str], int],
    found: Floats,
) -> None:
    """Add levers times the laws' terms, less those under weight alone: displacements are counted from there."""
    numbers = {id(one): number for number, one in enumerate(model.placed)}
    values: dict[tuple[int, tuple[int, int]], Floats] = {}
    for sign, terms in ((1.0, loaded.terms), (-1.0, unloaded.terms)):
        for one, term in terms:
            row, at = rows.get((numbers[id(one)], term.symbol)), (term.node, term.component)
            if row is not None and at in lever:
                values[row, at] = values[row, at] + sign * term.value if (row, at) in values else sign * term.value
    for (row, at), value in values.items():
        found[row] += lever[at] * value


def _observation_columns(
    model: CompliantRobot, data: Observations, predicted: Floats, found: Floats, rows: dict[tuple[int, str], int]
) -> None:
    full = np.zeros((len(data.setup.targets), 6, data.n_states))
    full[data.body, data.component] = predicted
    observed = Observed(full, data.order)
    for number, one in enumerate(model.placed):
        for symbol, column in one.effect.observation_columns(one.place, observed, one.shape()).items():
            if (number, symbol) in rows:
                found[rows[number, symbol]] += column[data.body, data.component]


def _difference_columns(
    model: CompliantRobot, data: Observations, columns: Sequence[Column], predicted: Floats, found: Floats
) -> None:
    """Fill the columns of shape and set-up parameters by a forward difference of the whole balance."""
    for row, column in enumerate(columns):
        if column.sort is Sort.AMPLITUDE:
            continue
        one = model.placed[column.placed]
        spec = one.effect.spec(column.symbol)
        value = one.values.get(column.symbol, spec.typical if column.sort is Sort.SHAPE else 0.0)
        step = 1e-4 * max(abs(value), spec.typical)
        moved = model.with_values({one.parameter_name(column.symbol): value + step})
        loaded, unloaded = rests(moved, data)
        found[row] = (predicted_displacement(moved, data, loaded, unloaded) - predicted) / step


def _sensitivity(
    model: CompliantRobot, data: Observations, loaded: Rest, lever: dict[tuple[int, int], Floats]
) -> Floats:
    """Return (m, 6, n): how the prediction moves with the wrench as read, on the shape as it stands."""
    base = [term for _, term in loaded.terms]
    places = list(lever)
    number = {at: k for k, at in enumerate(places)}
    direct, levered = unit_wrenches(model.chain, loaded.shape, loaded.inputs)
    n_axes = 6 if data.setup.moments_measured else 3
    moved = np.zeros((n_axes, len(places), data.n_states))
    wrench = np.empty_like(loaded.wrench)
    for axis in range(n_axes):
        step = FORCE_STEP if axis < 3 else MOMENT_STEP
        wrench[:] = loaded.wrench
        if axis < 3:
            wrench[:, :3] += step * direct[:, :, axis]
        wrench[:, 3:] += step * (levered if axis < 3 else direct)[:, :, axis % 3]
        loads = NodeLoads(wrench, loaded.inputs.angles, data.order, loaded.weight)
        for before, (one, term) in zip(base, law_terms(model, loads), strict=True):
            amplitude, at = one.amplitude(term.symbol), (term.node, term.component)
            if amplitude:
                moved[axis, number[at]] += (amplitude / step) * (term.value - before.value)
    result = np.zeros((len(data.measured), 6, data.n_states))
    if places:
        levers = np.stack([lever[at] for at in places])
        for row in range(len(data.measured)):
            for axis in range(n_axes):
                result[row, axis] = np.einsum("kn,kn->n", levers[:, row], moved[axis])
    return result


def free_columns(robot: CompliantRobot, fixed: frozenset[str] = frozenset()) -> list[Column]:
    """Return the robot's free parameters in order; ``fixed`` holds full names that keep their values."""
    return [
        Column(number, spec.symbol, spec.sort)
        for number, one in enumerate(robot.placed)
        for spec in one.effect.parameters
        if one.parameter_name(spec.symbol) not in fixed and not spec.discrete
    ]
