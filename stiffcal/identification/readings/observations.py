"""What was measured, ready for a fit: load states turned into rows of numbers, one column per state.

Displacements are taken relative to one reading per run; as that reading is as noisy as the others, each run carries a
free constant offset instead of trusting it (physics, section 3).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.readings.joints_at_rest import with_other_joints_at_rest
from stiffcal.identification.readings.pose_history import pose_history
from stiffcal.identification.readings.pose_spread import PoseSpread, pose_spread
from stiffcal.identification.readings.row_layout import (
    ROTATION,
    RowLayout,
    layout_of,
    with_gauges,
    with_motors,
    with_rods,
)
from stiffcal.measurements.load_states import LoadStates, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, turn_between
from stiffcal.mechanics.like_poses import joint_phases
from stiffcal.model.effect import StateOrder
from stiffcal.reduction.loads.cycles import run_members
from stiffcal.reduction.set_aside.outliers import load_is_good


@dataclass(frozen=True)
class ClampedSigma:
    """Standard uncertainty of the states of clamped runs, from the scatter of neighbouring readings; NaN in others."""

    motor: Floats
    """(n,) rad, of the moved motor's angle."""
    wrench: Floats
    """(6, n) N and N·m."""
    dof: float
    """Degrees of freedom behind them: readings."""

    def subset(self, pick: slice | Booleans | Integers) -> ClampedSigma:
        """Return that of some states."""
        return ClampedSigma(self.motor[pick], self.wrench[:, pick], self.dof)


@dataclass(frozen=True)
class WrenchCorrection:
    """By how much a fit has moved wrenches that were read, and what that moves in the rows."""

    wrench: Floats
    """(6, n) N and N·m, added to what was read …"""
    held: Floats
    """(6, n) … the same in base axes, added to what the fixture does to the held frame."""
    rows: Floats
    """(m, n) m and rad, added to what was measured: the model's derivative times the correction."""
    proposed: Floats
    """(n,) by how much the last step would have moved the wrench, in its standard uncertainties; NaN where it is not
    corrected.
    """
    relaxation: Floats
    """(n,) by what share of that it was moved."""

    def subset(self, pick: slice | Booleans | Integers) -> WrenchCorrection:
        """Return that of some states."""
        return WrenchCorrection(
            self.wrench[:, pick], self.held[:, pick], self.rows[:, pick], self.proposed[pick], self.relaxation[pick]
        )  # fmt: skip


@dataclass(frozen=True)
class Observations:
    """What was measured, ready for a fit: n states, m rows each, state axis last."""

    angles: Floats
    """(J, n) model joint angles, rad, constant within a run."""
    wrench: Floats
    """(6, n) on the robot, N and N·m, in the set-up's axes (`MeasurementSetup.wrench_axes`)."""
    order: StateOrder
    """Order and time of the states."""
    measured: Floats
    """(m, n) displacement since the run's reference reading, base axes, m and rad; change of a gauge or of a rod, m; 0
    where not measured.
    """
    measured_mask: Booleans
    """(m, n) True where measured."""
    layout: RowLayout
    """What the rows are."""
    free_offset: bool
    """True where each run of displacements carries a free offset; absolute places have none (`carries_offset`)."""
    run: Integers
    """(n,) run number."""
    setup: MeasurementSetup
    """Where the instruments sit."""
    index: Integers
    """(n,) index of the state in the campaign's load states."""
    spread: PoseSpread | None = None
    """How far each pose is known where poses come from points, some of them hidden at times; else None."""
    tracker: Integers | None = None
    """(n,) which of the set-up's trackers reads each state; None: there is one."""
    run_names: tuple[str, ...] = ()
    """Of the campaign's runs, by run number."""
    run_kinds: tuple[str, ...] = ()
    """Their kinds of experiment, as the manifest names them; load runs where not given."""
    absolute: Booleans = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(n,) True where a place was measured: the displacement is counted from the robot file's undeformed robot. Nowhere
    if not given.
    """
    joint_torque: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    """(L, n) N·m, of the motors about the logged axes at rest, NaN where not logged; L is 0 where none counts."""
    clamped: ClampedSigma | None = None
    """What the readings of clamped runs are known to; None where there are none, or where repeats show it."""
    prismatic: Booleans = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(J,) True where a joint's angle is a length, m. Nowhere if not given."""
    correction: WrenchCorrection | None = None
    """What is added to the wrenches and rows already, where laws bend within the wrench's noise; None: nothing."""

    def __post_init__(self) -> None:
        if self.absolute.size == 0:
            object.__setattr__(self, "absolute", np.zeros(len(self.run), dtype=np.bool_))
        if self.prismatic.size == 0:
            object.__setattr__(self, "prismatic", np.zeros(len(self.angles), dtype=np.bool_))
        if self.joint_torque.size == 0:
            object.__setattr__(self, "joint_torque", np.zeros((0, len(self.run))))

    @property
    def phases(self) -> Floats:
        """(J, n) model angles, rad, for sines and cosines of them: of a prismatic joint half a turn over its range."""
        return joint_phases(self.angles, self.prismatic)

    @property
    def carries_offset(self) -> Booleans:
        """(n,) True for the states of runs that carry a free offset."""
        return np.asarray(~self.absolute & self.free_offset)

    @property
    def added(self) -> Floats | float:
        """(m, n) what a correction has added to the rows; 0 where there is none."""
        return 0.0 if self.correction is None else self.correction.rows

    def corrected(self, correction: WrenchCorrection) -> Observations:
        """Return the observations with another correction in place of their own.

        With the wrench moved to where it is most probable, and the rows by the model's derivative times that, the
        residual of a linear law stays as it is, and its variance is that of both readings (effective variance).
        """
        before = self.correction
        wrench, held, rows = correction.wrench, correction.held, correction.rows
        if before is not None:
            wrench, held, rows = wrench - before.wrench, held - before.held, rows - before.rows
        layout = self.layout.with_held_wrench(held)
        return replace(
            self, wrench=self.wrench + wrench, measured=self.measured + rows, layout=layout, correction=correction
        )

    @property
    def uncorrected(self) -> Observations:
        """The observations with clamped states' wrenches as they were read, whatever model was fitted."""
        own = self.correction
        if own is None:
            return self
        layout = self.layout.with_held_wrench(-own.held)
        wrench, measured = self.wrench - own.wrench, self.measured - own.rows
        return replace(self, wrench=wrench, measured=measured, layout=layout, correction=None)

    @property
    def as_read(self) -> Floats:
        """The rows (m, n) without the correction of clamped states' wrenches, which depends on the model."""
        return self.measured - self.added

    def place_of(self, state: int) -> str:
        """Return in words where a state was measured, for messages."""
        run = int(self.run[state])
        return f'run "{self.run_names[run]}"' if run < len(self.run_names) else f"run {run + 1}"

    @property
    def n_states(self) -> int:
        """How many states there are, n."""
        return int(self.run.shape[0])

    @property
    def n_measured(self) -> int:
        """How many of the n states have a reading."""
        return int(np.count_nonzero(self.measured_mask.any(axis=0)))

    @property
    def kind(self) -> Integers:
        """(m,) TRANSLATION, ROTATION, GAUGE, LENGTH or MOTOR."""
        return self.layout.kind

    @property
    def rotational(self) -> Booleans:
        """(m,) True for rotation components."""
        return np.asarray(self.layout.kind == ROTATION)

    @property
    def body(self) -> Integers:
        """(m,) which target (or link with rods) the row belongs to."""
        return self.layout.body

    @property
    def component(self) -> Integers:
        """(m,) 0 … 5 of the target's displacement; else the row's number among its like."""
        return self.layout.component

    def rows_of(self, *kinds: int) -> Integers:
        """Return the places of the rows of these kinds."""
        return np.flatnonzero(np.isin(self.layout.kind, kinds))

    def subset(self, pick: slice | Booleans | Integers) -> Observations:
        """Return some of the states."""
        return replace(
            self,
            angles=self.angles[:, pick],
            wrench=self.wrench[:, pick],
            order=self.order.block(pick),
            measured=self.measured[:, pick],
            measured_mask=self.measured_mask[:, pick],
            layout=self.layout.subset(pick),
            run=self.run[pick],
            index=self.index[pick],
            tracker=None if self.tracker is None else self.tracker[pick],
            absolute=self.absolute[pick],
            joint_torque=self.joint_torque[:, pick],
            spread=None if self.spread is None else self.spread.subset(pick),
            clamped=None if self.clamped is None else self.clamped.subset(pick),
            correction=None if self.correction is None else self.correction.subset(pick),
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
    """Turn load states into observations for a fit; readings set aside count as not measured."""
    states = with_other_joints_at_rest(states, chain)
    reference = _reference_of_runs(states)
    is_deflection = states.deflection_given
    pieces: list[Floats] = []
    kinds, bodies, components = [], [], []
    for b in range(states.position.shape[1]):
        displacement = states.deflection[:, b] if is_deflection else _displacement(states, b, reference)
        displacement = _with_absolute(displacement, states, chain, b)
        for axis in range(6):
            if np.isfinite(displacement[:, axis]).any():
                pieces.append(displacement[:, axis])
                kinds.append(int(axis >= 3))
                bodies.append(b)
                components.append(axis)
    layout = layout_of(kinds, bodies, components)
    layout = with_gauges(layout, pieces, states, chain, None if is_deflection else reference)
    layout = with_rods(layout, pieces, states, chain, None if is_deflection else reference)
    layout = with_motors(layout, pieces, states, chain, reference)
    measured = np.stack(pieces) if pieces else np.zeros((0, len(states)))
    # A bumped reading is no observation, but the robot went through its load, and laws with a memory must too.
    keep = np.flatnonzero(load_is_good(states) & np.isfinite(states.wrench[:, :3]).all(axis=1))
    spread = pose_spread(states, layout)
    measured = measured[:, keep]
    measured_mask = np.isfinite(measured) & states.used[keep]
    return Observations(
        angles=_run_angles(states, chain)[:, keep],
        wrench=np.ascontiguousarray(np.nan_to_num(states.wrench[keep]).T),
        order=_order(states, chain, reference, keep),
        measured=np.where(measured_mask, measured, 0.0),
        measured_mask=measured_mask,
        layout=layout.subset(keep),
        free_offset=not is_deflection and not states.absolute.all(),
        run=states.run[keep],
        setup=states.setup,
        index=keep,
        tracker=states.tracker[keep] if len(states.setup.trackers) > 1 else None,
        absolute=states.absolute[keep],
        spread=None if spread is None else spread.subset(keep),
        run_names=tuple(run.name for run in states.runs),
        run_kinds=tuple(run.experiment for run in states.runs),
        joint_torque=np.ascontiguousarray(states.joint_torque[keep].T),
        prismatic=chain.prismatic,
        clamped=_clamped_sigma(states, keep),
    )


def _clamped_sigma(states: LoadStates, keep: Integers) -> ClampedSigma | None:
    known = np.isfinite(states.motor_sigma[keep])
    if not known.any():
        return None
    dof = float(np.sum(states.n_readings[keep][known]))
    return ClampedSigma(states.motor_sigma[keep], np.ascontiguousarray(states.wrench_sigma[keep].T), dof)


def _displacement(states: LoadStates, b: int, reference: Integers) -> Floats:
    """Return (n, 6) of a target since its run's reference reading; NaN where not measured."""
    translation = states.position[:, b] - states.position[reference, b]
    rotation = np.ascontiguousarray(np.moveaxis(states.rotation[:, b], 0, -1))
    rotation_vectors = turn_between(rotation, rotation[:, :, reference]).T
    return np.concatenate([translation, rotation_vectors], axis=1)


def _with_absolute(displacement: Floats, states: LoadStates, chain: Chain, b: int) -> Floats:
    """Return (n, 6) displacements; those of absolute places from where the robot file puts the target, unloaded."""
    absolute = states.absolute
    if not absolute.any():
        return displacement
    target = states.setup.targets[b]
    place, rotation = attached_poses(chain, chain.model_angles(states.joints[absolute]), target)
    measured = np.ascontiguousarray(np.moveaxis(states.rotation[absolute, b], 0, -1))
    turn = turn_between(measured, np.ascontiguousarray(np.moveaxis(rotation, 0, -1))).T
    result = displacement.copy()
    result[absolute] = np.concatenate([states.position[absolute, b] - place, turn], axis=1)
    return result


def _run_angles(states: LoadStates, chain: Chain) -> Floats:
    """Return (J, n) model angles, each run's mean: the pose stands still, and a mean takes the encoders' noise out."""
    angles = np.ascontiguousarray(chain.model_angles(states.joints).T)
    _, number = np.unique(states.run, return_inverse=True)
    count = np.bincount(number)
    return np.stack([(np.bincount(number, weights=row) / count)[number] for row in angles])


def _order(states: LoadStates, chain: Chain, reference: Integers, keep: Integers) -> StateOrder:
    angles = chain.model_angles(states.joints)
    # A clamped motor is driven, and its motion is what is measured there: it is not pushed off.
    motor = np.where(states.clamped, 0.0, (angles - angles[reference]).T)
    kelvin = states.temperature[:, 0] if states.temperature.shape[1] else np.full(len(states), np.nan)
    since = states.time - states.time[reference]
    if states.absolute.any():
        # Drift counts from the first row: an absolute place has no reference of its own.
        since = np.where(states.absolute, states.time - np.nanmin(states.time[states.absolute], initial=np.inf), since)
    return StateOrder(
        run=states.run[keep],
        time=states.time[keep],
        hold=states.hold[keep],
        motor=np.ascontiguousarray(np.nan_to_num(motor[:, keep])),
        temperature=(kelvin - kelvin[reference])[keep],
        since_reference=since[keep],
        number=keep + 1,
        swept=np.array([run.swept for run in states.runs], dtype=np.bool_)[states.run[keep]],
        motor_torque=np.array([run.motor_torque for run in states.runs], dtype=np.bool_)[states.run[keep]],
        kelvin=kelvin[keep],
        approach=np.ascontiguousarray(states.approach[keep].T),
        history=pose_history(states, chain, keep),
    )
