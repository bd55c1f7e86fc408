"""Load states: what the instruments read while the load was held, averaged, one entry per hold.

Bodies are numbered along the chain: 0 is the base, k = 1 … J the link that joint k moves, J + 1 the flange.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.markers import Markers
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.measurements.state_measures import StateMeasure

# What the frame is called by which a clamped robot is held, among the targets.
HELD = "held"
# Fields of `LoadStates` with a row for each state.
PER_STATE = (
    "run", "time", "hold", "joints", "wrench", "position", "rotation", "deflection", "reference", "temperature", "row",
    "n_readings", "wrench_scatter", "position_scatter", "set_aside", "lengths", "displacement", "markers_measured",
    "sigma", "motor_sigma", "wrench_sigma", "joint_torque", "approach", "set_aside_code",
)  # fmt: skip


@dataclass(frozen=True)
class Attachment:
    """A frame that rides on a body of the robot."""

    body: int
    """0 base, k = 1 … J link of joint k (its joint frame), J + 1 flange."""
    transform: Floats
    """(4, 4) body_from_frame, m."""


@dataclass(frozen=True)
class TrackerPlace:
    """A place where the instrument stood, and the frame in which it read there."""

    frame: str
    """Name of the manifest's frame in which places were read, "" where that is the base."""
    base_from_frame: Floats
    """(4, 4), m, how its readings were brought to base axes; identity where they came in base axes."""


IN_BASE = TrackerPlace("", np.eye(4))
"""What is read comes in the axes of the base."""


@dataclass(frozen=True)
class Sigma:
    """Standard uncertainty of one load state's reading, SI; None where the manifest does not say."""

    translation: float | None = None
    """m per axis, of a measured pose or deflection."""
    rotation: float | None = None
    """rad per axis, of a measured pose or deflection."""
    force: float | None = None
    """N per axis, of the wrench."""
    moment: float | None = None
    """N·m per axis, of the wrench."""
    length: float | None = None
    """Of a rod's length, m."""
    gauge: float | None = None
    """Of a gauge's displacement along its direction, m."""
    motor_angle: float | None = None
    """Of a motor's angle at the joint's side, rad, where clamped runs count them."""
    absolute_translation: float | None = None
    """m per axis, of a place in an absolute run; None: as ``translation``."""
    absolute_rotation: float | None = None
    """rad per axis, likewise; None: as ``rotation``."""


@dataclass(frozen=True)
class Gauge:
    """A gauge, or a load-displacement device's own: it reads its target's displacement along one direction."""

    name: str
    """The source that logs it."""
    target: int
    """Index of the measured frame in ``MeasurementSetup.targets``."""
    axes: Attachment
    """The frame in whose axes the direction is."""
    direction: Floats
    """(3,) unit vector; a positive reading is a displacement along it."""


@dataclass(frozen=True)
class MeasurementSetup:
    """Where the instruments sit: all that is needed to relate readings to the chain."""

    wrench_axes: Attachment
    """Frame whose axes the wrench components are in."""
    wrench_point: Attachment
    """Frame whose origin the moment refers to (the sensor), or where the force acts (force only)."""
    targets: tuple[Attachment, ...]
    """The measured frames, one per tracked body, in the order of ``LoadStates.position``."""
    target_names: tuple[str, ...]
    """The frames' names in the manifest."""
    moments_measured: bool
    """False where only forces are known; the moment about ``wrench_point`` is then zero."""
    trackers: tuple[TrackerPlace, ...] = (IN_BASE,)
    """One for each place where the instrument stood, `RunInfo.tracker` counts them; at least one."""
    estimated: tuple[str, ...] = ()
    """Names of the frames that the manifest leaves to be found."""
    load_is_weight: bool = False
    """True where the wrench is the weight of a known mass, along gravity, and not a reading."""
    load_point_sigma: float = 0.0
    """Standard uncertainty of each coordinate of ``wrench_point``, m; 0 where it counts as known."""
    torque_gain_sigma: float = 0.0
    """Relative standard uncertainty of each motor's torque that holds the robot; 0 where torques do not count."""
    tool_mass: float = 0.0
    """kg hung on the flange."""
    tool_com: Floats = field(default_factory=lambda: np.zeros(3))
    """(3,) in the flange frame, m."""
    sigma: Sigma = field(default_factory=Sigma)
    """Stated standard uncertainties."""
    tared: str = "run"
    """"run", "campaign" or "no": when the force sensor was zeroed."""
    rods: tuple[Rods, ...] = ()
    """The rods on each link that has some; ``LoadStates.lengths`` holds them one link after the other."""
    beams: tuple[BeamProperties, ...] = ()
    """What the field of each of these links needs to know of it, in the same order."""
    gauges: tuple[Gauge, ...] = ()
    """In the order of ``LoadStates.displacement``; their targets are among ``targets``."""
    markers: tuple[Markers | None, ...] = ()
    """Of each target the points that its poses come from, None where poses are read; empty where all are."""

    @property
    def rod_names(self) -> tuple[str, ...]:
        """R names of rods, in the order of ``LoadStates.lengths``."""
        return tuple(name for rods in self.rods for name in rods.names)


@dataclass(frozen=True)
class RunInfo:
    """A run as the manifest describes it."""

    name: str
    """The run's id, unique in the campaign."""
    experiment: str = "load"
    """The name of its kind of experiment."""
    holdout: bool = False
    """Never used to fit."""
    tags: tuple[str, ...] = ()
    """Free words."""
    compensated: bool = False
    """The controller was correcting while the run was measured."""
    of: str = field(default="", kw_only=True)
    """The run of the manifest whose row this is, where each row is a run of its own; "" where it is a whole run."""
    swept: bool = field(default=False, kw_only=True)
    """The load went up and down without being held; states are moments of that motion."""
    fixture: tuple[tuple[float, ...], ...] | None = None
    """Of a clamped run, 6 × 6 compliance of the fixture, m/N and rad/(N·m), base axes; None: rigid."""
    motor_torque: bool = field(default=False, kw_only=True)
    """Of a clamped run: True where the load is the motor's torque, the friction of the drive in it; False where a force
    sensor measures it.
    """
    direct: bool = field(default=False, kw_only=True)
    """Of an absolute run, True where the robot went from each row straight to the next."""
    tracker: int = field(default=0, kw_only=True)
    """Which of the set-up's trackers read its places."""
    measures: StateMeasure | None = field(default=StateMeasure.DISPLACEMENT, kw_only=True)
    """What its kind of experiment measures in its states; None where it makes none."""

    @property
    def is_displaced(self) -> bool:
        """True where displacements are measured that a load made: no controller was correcting them."""
        return self.measures is StateMeasure.DISPLACEMENT and not self.compensated


@dataclass(frozen=True)
class LoadStates:
    """n load states, grouped by run (contiguous) and in the order in which they were reached."""

    runs: tuple[RunInfo, ...]
    """R runs."""
    run: Integers
    """(n,) index into ``runs``."""
    time: Floats
    """(n,) s on the campaign clock, NaN where not logged; of what is averaged over a hold the middle."""
    hold: Floats
    """(n,) s since the load was reached, NaN where not known; in logs since it was half-way there."""
    joints: Floats
    """(n, L) logged joint angles, rad (what the controller shows; the robot file turns them into model angles)."""
    wrench: Floats
    """(n, 6) N, N·m: force then moment, what the surroundings do to the robot, axes and point as in the setup."""
    position: Floats
    """(n, B, 3) m, base axes, of each target; NaN where not measured."""
    rotation: Floats
    """(n, B, 3, 3) base_from_target; NaN where orientation is not measured."""
    deflection: Floats
    """(n, B, 6) m, rad, base axes: loaded minus unloaded where the campaign holds that; else NaN."""
    reference: Booleans
    """(n,) True for the run's reference state."""
    temperature: Floats
    """(n, T) kelvin or degC as logged; T may be 0."""
    row: Integers
    """(n,) data row of the states table from 1, or the hold's number in the run."""
    n_readings: Integers
    """(n,) readings averaged into the state."""
    wrench_scatter: Floats
    """(n, 6) standard deviation of single readings within the hold, NaN where not known."""
    position_scatter: Floats
    """(n, B, 3) likewise, m."""
    set_aside: NDArray[np.str_]
    """(n,) text for people why the state is not used, "" where it is."""
    setup: MeasurementSetup
    """Where the instruments sit."""
    lengths: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    """(n, R) m, of each rod as read, less what it grows with the temperature where that is known: changes are what
    counts; NaN where not logged. R may be 0.
    """
    displacement: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    """(n, G) m, of each gauge as read, along its direction; NaN where not logged. G may be 0."""
    markers_measured: Booleans = field(default_factory=lambda: np.zeros((0, 0, 0), dtype=np.bool_))
    """(n, B, K) which of a target's points were measured, in the order of ``setup.markers``; K is that of the target
    with most of them, 0 where poses are read.
    """
    sigma: Floats = field(default_factory=lambda: np.zeros((0, 0, 6)))
    """(n, B, 6) standard uncertainty of each target's place and turn, m and rad, base axes, where the log states it row
    by row; NaN where it does not.
    """
    motor_sigma: Floats = field(default_factory=lambda: np.zeros(0))
    """(n,) standard uncertainty of the moved motor's angle in clamped runs, rad, at the joint's side: the scatter of
    neighbouring readings; NaN elsewhere.
    """
    wrench_sigma: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    """(n, 6) the same of the wrench in clamped runs, N and N·m; NaN elsewhere."""
    joint_torque: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    """(n, L) N·m, of the motors about the logged axes at rest, where an absolute run logs them; NaN elsewhere. L is 0
    where none counts.
    """
    approach: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    """(n, J) direction of each drive's last motion before the rows of absolute runs: 1, −1, or 0 where it is not known;
    no columns where none is.
    """
    set_aside_code: NDArray[np.str_] = field(default_factory=lambda: np.zeros(0, dtype=np.str_))
    """(n,) values of `SetAsideCode`; where not given, what has a text is excluded."""

    def __post_init__(self) -> None:
        # Campaigns without rods, gauges or torques need not say so: no columns, as many rows as there are states.
        for name in ("lengths", "displacement", "joint_torque", "approach"):
            if getattr(self, name).size == 0:
                object.__setattr__(self, name, np.zeros((len(self), 0)))
        if self.markers_measured.size == 0:
            nothing = np.zeros((len(self), self.position.shape[1], 0), dtype=np.bool_)
            object.__setattr__(self, "markers_measured", nothing)
        if self.sigma.size == 0:
            object.__setattr__(self, "sigma", np.full((len(self), self.position.shape[1], 6), np.nan))
        if self.motor_sigma.size == 0:
            object.__setattr__(self, "motor_sigma", np.full(len(self), np.nan))
            object.__setattr__(self, "wrench_sigma", np.full((len(self), 6), np.nan))
        if self.set_aside_code.size == 0:
            excluded = np.where(self.set_aside == "", SetAsideCode.NONE.value, SetAsideCode.EXCLUDED.value)
            object.__setattr__(self, "set_aside_code", excluded)
        lengths = {name: len(getattr(self, name)) for name in PER_STATE}
        if others := {name: rows for name, rows in lengths.items() if rows != len(self)}:
            raise ValueError(f"{len(self)} states, but rows of {others}")
        if ((self.set_aside_code == "") != (self.set_aside == "")).any():
            raise ValueError("a state that is set aside has a code and a text, one that is used has neither")

    def __len__(self) -> int:
        return int(self.run.shape[0])

    @property
    def has_orientation(self) -> bool:
        """True where the targets' orientations (or rotational deflections) are measured."""
        return bool(np.isfinite(self.rotation).any() or np.isfinite(self.deflection[:, :, 3:]).any())

    @property
    def deflection_given(self) -> bool:
        """True where displacements came already taken, loaded minus unloaded."""
        return bool(np.isfinite(self.deflection).any())

    @property
    def clamped(self) -> Booleans:
        """(n,) True for states of runs whose flange was held: what is measured there is the motors' angles."""
        return np.array([run.measures is StateMeasure.MOTOR_ANGLE for run in self.runs], dtype=np.bool_)[self.run]

    @property
    def absolute(self) -> Booleans:
        """(n,) True for states of which places count, not displacements since a reference."""
        return np.array([run.measures is StateMeasure.PLACE for run in self.runs], dtype=np.bool_)[self.run]

    @property
    def tracker(self) -> Integers:
        """(n,) which of the set-up's trackers read each state."""
        if len(self.setup.trackers) == 1:
            return np.zeros(len(self), dtype=np.int64)
        return np.array([run.tracker for run in self.runs], dtype=np.int64)[self.run]

    @property
    def base_from_tracker(self) -> Floats:
        """(n, 4, 4) how the readings of each state were brought to base axes, m."""
        return np.stack([tracker.base_from_frame for tracker in self.setup.trackers])[self.tracker]

    @property
    def has_poses(self) -> bool:
        """True where a target's place was measured, or its displacement in three components."""
        return bool(np.isfinite(self.position).any() or np.isfinite(self.deflection).any())

    def select(self, keep: Booleans | Integers) -> LoadStates:
        """Return the states picked by a mask or by indices; runs keep their numbers."""
        arrays = {name: getattr(self, name)[keep] for name in PER_STATE}
        return replace(self, **arrays)

    @property
    def used(self) -> Booleans:
        """(n,) True for the states that are not set aside."""
        return np.asarray(self.set_aside_code == SetAsideCode.NONE.value, dtype=np.bool_)

    def with_set_aside(
        self, chosen: Booleans | Integers | Sequence[int], code: SetAsideCode, reasons: str | Sequence[str]
    ) -> LoadStates:
        """Return the states with some set aside.

        Parameters
        ----------
        chosen : mask or indices of k states.
        code : their cause.
        reasons : the text of all, or k texts.
        """
        codes, texts = self.set_aside_code.astype(object), self.set_aside.astype(object)
        codes[chosen], texts[chosen] = code.value, reasons
        return replace(self, set_aside=texts.astype(np.str_), set_aside_code=codes.astype(np.str_))

    def members_by_name(self) -> dict[str, Integers]:
        """Return the states of each run of the manifest, as indices: rows of an absolute run together."""
        names = [run.of or run.name for run in self.runs]
        listed = list(dict.fromkeys(names))
        place = {name: number for number, name in enumerate(listed)}
        number_of_run = np.array([place[name] for name in names], dtype=np.int64)
        return dict(zip(listed, members_of(number_of_run[self.run], len(listed)), strict=True))

    def members(self) -> list[Integers]:
        """Return the states of each of the R runs, as indices; empty for a run without states."""
        return members_of(self.run, len(self.runs))


def members_of(number: Integers, count: int | None = None) -> list[Integers]:
    """Return, for every number, the positions where it stands, ascending: all of them in one pass.

    Parameters
    ----------
    number : (n,) of a run, a fold and so on, not negative.
    count : return lists for the numbers 0 … count − 1, empty where one does not occur; None: for those that occur.

    Examples
    --------
    >>> [part.tolist() for part in members_of(np.array([2, 0, 2]))]
    [[1], [0, 2]]
    >>> [part.tolist() for part in members_of(np.array([2, 0, 2]), 3)]
    [[1], [], [0, 2]]
    """
    order = np.argsort(number, kind="stable")
    if count is None:
        return list(np.split(order, np.flatnonzero(np.diff(number[order])) + 1)) if len(number) else []
    return list(np.split(order, np.searchsorted(number[order], np.arange(1, count))))[:count]
