"""What the rows of an observation are: components of a target's displacement, gauges along a line, rods on links.

Everything a law does reaches the rows through one small displacement of a node. A target's component moves with it by
the lever; a gauge by the lever along its direction; a rod only with the node of its own link, by what the displacement
of the link's end does to the distance of its ends (`stiffcal.mechanics.rods`). Joints and bearings leave it alone: that
is how rods distinguish a bending link from a tilting bearing (paper 000).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rods import rod_matrix
from stiffcal.model.effect import link_node
from stiffcal.model.held_frame import HeldFrame, held_frame
from stiffcal.reduction.loads.motion import gauge_directions

# Kinds of rows. Each has a noise of its own.
TRANSLATION, ROTATION, GAUGE, LENGTH, MOTOR = range(5)
N_KINDS = 5
RowMeasure: TypeAlias = Literal["translation", "rotation", "length", "motor_angle"]
# What each kind is reported as: `stiffcal.identification.noise.reading_noise.rms_by_measure`.
MEASURE_OF: tuple[RowMeasure, ...] = ("translation", "rotation", "translation", "length", "motor_angle")
MEASURES: dict[str, tuple[int, ...]] = {
    measure: tuple(kind for kind in range(N_KINDS) if MEASURE_OF[kind] == measure) for measure in MEASURE_OF
}
# Measures that are determined only where their rows are.
OPTIONAL = ("length", "motor_angle")


@dataclass(frozen=True)
class GaugeRows:
    """Rows that measure a target along a direction: gauges that no state reads together share one."""

    row: Integers
    """(g,) their places among the m rows."""
    target: Integers
    """(g,) indices of targets."""
    direction: Floats
    """(g, 3, n) unit vectors, base axes; zero where the row was not read."""
    gauge: Integers
    """(g, n) which gauge of the set-up was read, −1 where none was."""

    def along(self, full: Floats) -> Floats:
        """Return (…, g, n) of displacements (…, B, 6, n)."""
        return np.asarray(np.einsum("gin,...gin->...gn", self.direction, full[..., self.target, :3, :]))


@dataclass(frozen=True)
class RodRows:
    """Rows of the rods on one link."""

    row: Integers
    """(r,) their places among the m rows."""
    node: int
    """The link's node."""
    matrix: Floats
    """(r, 6) what each reads per displacement of the link's outboard end, beam axes, m per m and rad."""


@dataclass(frozen=True)
class MotorRows:
    """Rows that measure what the motors of a clamped robot had to turn: the flange is held, the drives give."""

    row: Integers
    """(J,) their places among the m rows, one per drive."""
    held: HeldFrame
    """The frame by which the robot is held."""

    def of(self, full: Floats) -> Floats:
        """Return (…, J, n) of displacements (…, B, 6, n)."""
        return np.asarray(np.einsum("jin,...in->...jn", self.held.inverse, full[..., self.held.target, :, :]))


@dataclass(frozen=True)
class RowLayout:
    """What the m rows are."""

    kind: Integers
    """(m,) TRANSLATION, ROTATION, GAUGE, LENGTH or MOTOR."""
    body: Integers
    """(m,) the target; of a rod, which of the set-up's links with rods."""
    component: Integers
    """(m,) 0 … 5 of the target's displacement; a gauge row's number; a rod's number on its link."""
    gauges: GaugeRows | None = None
    """The gauge rows, or None."""
    rods: tuple[RodRows, ...] = ()
    """The rod rows, link by link."""
    motors: MotorRows | None = None
    """The rows of clamped motors, or None."""

    @property
    def plain(self) -> bool:
        """True where all rows are components of targets' displacements."""
        return self.gauges is None and not self.rods and self.motors is None

    @property
    def held(self) -> HeldFrame | None:
        """The frame by which the robot is held in clamped runs; None where there are none."""
        return None if self.motors is None else self.motors.held

    def with_held_wrench(self, change: Floats) -> RowLayout:
        """Return the layout with (6, n) more of what the fixture does to the held frame, N and N·m, base axes."""
        if self.motors is None:
            return self
        held = replace(self.motors.held, wrench=self.motors.held.wrench + change)
        return replace(self, motors=replace(self.motors, held=held))

    def subset(self, pick: slice | Booleans | Integers) -> RowLayout:
        """Return the layout of some states."""
        gauges, motors = self.gauges, self.motors
        if gauges is not None:
            gauges = replace(gauges, direction=gauges.direction[:, :, pick], gauge=gauges.gauge[:, pick])
        if motors is not None:
            motors = replace(motors, held=motors.held.subset(pick))
        return replace(self, gauges=gauges, motors=motors)

    def of_targets(self, full: Floats) -> Floats:
        """Return (…, m, n) rows of targets' displacements (…, B, 6, n); rods measure none of them."""
        if self.plain:
            if self._every_component(full.shape[-3]):
                return full.reshape(*full.shape[:-3], -1, full.shape[-1])
            return np.asarray(full[..., self.body, self.component, :])
        result = np.zeros((*full.shape[:-3], len(self.kind), full.shape[-1]))
        target_rows = np.flatnonzero(self.kind <= ROTATION)
        result[..., target_rows, :] = full[..., self.body[target_rows], self.component[target_rows], :]
        if self.gauges is not None:
            result[..., self.gauges.row, :] = self.gauges.along(full)
        if self.motors is not None:
            result[..., self.motors.row, :] = self.motors.of(full)
        return result

    def _every_component(self, n_targets: int) -> bool:
        """Return whether the rows are all components of all targets in their order."""
        place = 6 * self.body + self.component
        return len(place) == 6 * n_targets and bool((place == np.arange(len(place))).all())

    def add_rods(self, rows: Floats, displacement: Floats) -> None:
        """Add to rows (m, n) what the rods read of nodes' displacements (nodes, 6, n)."""
        for rods in self.rods:
            rows[rods.row] += rods.matrix @ displacement[rods.node]

    def add_rod_levers(self, rows: Floats, node: int, component: int) -> None:
        """Add to rows (m, n) what the rods read of a unit of one component of one node's displacement."""
        for rods in self.rods:
            if rods.node == node:
                rows[rods.row] += rods.matrix[:, component, None]


def layout_of(kinds: Sequence[int], bodies: Sequence[int], components: Sequence[int]) -> RowLayout:
    """Return a layout without gauges and rods."""
    kind, body, component = (np.array(numbers, dtype=np.int64) for numbers in (kinds, bodies, components))
    return RowLayout(kind, body, component)


def with_gauges(
    layout: RowLayout, measured: list[Floats], states: LoadStates, chain: Chain, reference: Integers | None
) -> RowLayout:
    """Add rows for the gauges, and their readings to ``measured``.

    Gauges on one target that no state reads together share a row: a device that presses now along one direction, now
    along another, is one instrument with one noise.

    Parameters
    ----------
    reference : (n,) index of each state's reference reading, or None where readings are differences already.
    """
    reading = states.displacement if reference is None else states.displacement - states.displacement[reference]
    groups: list[list[int]] = []
    for number, gauge in enumerate(states.setup.gauges):
        read = np.isfinite(reading[:, number])
        if not read.any():
            continue
        for group in groups:
            never_together = not any((np.isfinite(reading[:, other_gauge]) & read).any() for other_gauge in group)
            if never_together and states.setup.gauges[group[0]].target == gauge.target:
                group.append(number)
                break
        else:
            groups.append([number])
    if not groups:
        return layout
    directions = gauge_directions(states, chain)
    first, n = len(measured), len(states)
    direction, gauge_of_state = np.zeros((len(groups), 3, n)), np.full((len(groups), n), -1, dtype=np.int64)
    target = np.array([states.setup.gauges[group[0]].target for group in groups], dtype=np.int64)
    for k, group in enumerate(groups):
        values = np.full(n, np.nan)
        for number in group:
            read = np.isfinite(reading[:, number])
            values[read], gauge_of_state[k, read] = reading[read, number], number
            direction[k][:, read] = directions[read, number].T
        measured.append(values)
    rows = np.arange(first, len(measured))
    added = _extend_rows(layout, GAUGE, target, np.arange(len(groups)))
    return replace(added, gauges=GaugeRows(rows, target, direction, gauge_of_state))


def with_rods(
    layout: RowLayout, measured: list[Floats], states: LoadStates, chain: Chain, reference: Integers | None
) -> RowLayout:
    """Add rows for the rods, and their changes of length to ``measured``; parameters as in `with_gauges`."""
    change = states.lengths if reference is None else states.lengths - states.lengths[reference]
    column, rod_rows = 0, list(layout.rods)
    for link, (rods, beam) in enumerate(zip(states.setup.rods, states.setup.beams, strict=True)):
        columns = np.arange(column, column + len(rods.names))
        column += len(rods.names)
        states_read = np.flatnonzero(np.isfinite(change[:, columns]).any(axis=0))
        if not len(states_read):
            continue
        rows = np.arange(len(measured), len(measured) + len(states_read))
        measured.extend(change[:, columns[k]] for k in states_read)
        layout = _extend_rows(layout, LENGTH, np.full(len(states_read), link), states_read)
        rod_rows.append(RodRows(rows, link_node(chain.beams[rods.link].joint), rod_matrix(rods, beam)[states_read]))
    return replace(layout, rods=tuple(rod_rows))


def with_motors(
    layout: RowLayout, measured: list[Floats], states: LoadStates, chain: Chain, reference: Integers
) -> RowLayout:
    """Add a row for each drive's motor of the clamped runs, and to ``measured`` what the drives had to give.

    J (Δd_motor + δ) = −C_fixture W (physics, section 1), read through the pseudo-inverse of J in the run's pose, which
    keeps what the flange feels: δ = −J⁺ J Δd_motor − J⁺ C_fixture W since the run's reference.
    """
    held = held_frame(chain, states, reference)
    if held is None:
        return layout
    n_drives = chain.n_joints
    # (6, n) how far the motors have moved the frame, had nothing given, and how far the fixture has given
    moved = np.einsum("ijn,nj->in", held.jacobian, states.joints - states.joints[reference])
    for number in np.unique(states.run[states.clamped]):
        in_run, fixture = np.flatnonzero(states.run == number), states.runs[int(number)].fixture
        if fixture is not None:
            moved[:, in_run] += np.array(fixture) @ held.wrench[:, in_run]
    motor_readings = -np.einsum("jin,in->jn", held.inverse, moved)
    motor_readings[:, ~states.clamped] = np.nan
    for number in np.unique(states.run[states.clamped]):
        in_run = np.flatnonzero(states.run == number)
        # The others stand still and carry no torque but the sensor's noise: within a play that turns them at random.
        driven = int(np.argmax(np.ptp(states.joints[in_run] @ chain.drives_of_logged.T, axis=0)))
        motor_readings[np.ix_(np.arange(n_drives) != driven, in_run)] = np.nan
    rows = np.arange(len(measured), len(measured) + n_drives)
    measured.extend(motor_readings)
    added = _extend_rows(layout, MOTOR, np.full(n_drives, held.target), np.arange(n_drives))
    return replace(added, motors=MotorRows(rows, held))


def _extend_rows(layout: RowLayout, kind: int, body: Integers, component: Integers) -> RowLayout:
    return replace(
        layout,
        kind=np.append(layout.kind, np.full(len(body), kind)).astype(np.int64),
        body=np.append(layout.body, body).astype(np.int64),
        component=np.append(layout.component, component).astype(np.int64),
    )
