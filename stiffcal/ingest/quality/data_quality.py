"""Watching sources while they are read, and judging the load states that come out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from stiffcal.arrays import Booleans
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.signals.signals import DeadWeight, Deflection, JointSignals, Wrench
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.bodies.measured_links import measure_links
from stiffcal.identification.readings.observations import observe
from stiffcal.ingest.quality.constant_signals import constant_signals
from stiffcal.ingest.quality.header_units import conflict_warnings, declared_units, unit_conflicts
from stiffcal.ingest.quality.places_not_measured import orientations_not_measured, rows_without_place
from stiffcal.ingest.quality.short_logs import short_logs
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.stopped_targets import stopped_targets
from stiffcal.mistakes.displacements.table import TablePlaces, check_other_readings
from stiffcal.mistakes.displacements.turned_sensor import turned_sensor
from stiffcal.mistakes.displacements.unit_slips import (
    angles_like_radians,
    check_displacement_unit,
    loads_like_thousands,
)
from stiffcal.mistakes.displacements.work import check_work
from stiffcal.mistakes.force_zero.faults import force_zero_faults
from stiffcal.mistakes.force_zero.tables import rezeroed_table
from stiffcal.mistakes.references.kinematics import check_kinematics, miss_words
from stiffcal.mistakes.references.match import MEETS_M, match_kinematics
from stiffcal.mistakes.stated_units import stated_units
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.reduction.copies.repeated_rows import repeated_rows
from stiffcal.reduction.copies.rounded import RoundedCopies
from stiffcal.reduction.loads.cycles import UNLOADED_SHARE
from stiffcal.reduction.logs.copied_logs import CopiedRuns, copied_log_warnings, copied_runs
from stiffcal.reduction.logs.log_rows import (
    LogRows,
    columns_of_signals,
    files_of_signals,
    header_at_once,
    header_of_file,
    place_of_row,
)
from stiffcal.reduction.logs.plausibility import LogQuality
from stiffcal.reduction.logs.sampled_readings import ReadingSampler
from stiffcal.reduction.logs.summary import LogSummary
from stiffcal.reduction.set_aside.displacement_measured import check_displacement_measured
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.wording import percent

# States below which rods are not judged: a quick look has one of each run.
ENOUGH_FOR_RODS = 12


@dataclass(frozen=True)
class FileHeader:
    """What the header of a log states that a reader of the campaign ought to know."""

    file: str
    """As the user named it."""
    conflicts: tuple[str, ...]
    """A sentence for each unit that is not the manifest's."""
    remarks: tuple[str, ...]
    at_once: bool
    """Whether all logs of its format are looked at; else the first of a source alone."""


@dataclass(frozen=True)
class ReadLog:
    """What was seen of a log while it was read."""

    source: str
    summary: LogSummary
    headers: tuple[FileHeader, ...]
    """Of its files, as far as they were looked at with this log."""


class DataQuality:
    """The quality of the data by source and file of a campaign.

    Logs that are read are given to `update` piece by piece, then to `finish`; what was seen of one earlier to `add`.
    """

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self.logs: dict[tuple[str, str, str], LogSummary] = {}
        """By source, file and run, once they are finished, in the order in which they were begun."""
        self._watched: dict[tuple[str, str, str], LogQuality] = {}
        self._settings = {name: _LogSettings.of(campaign, name) for name in campaign.manifest.sources}
        self._copies = RoundedCopies()
        self._copied: tuple[int, list[CopiedRuns]] | None = None
        """Of how many logs, and what was found."""
        self._unit_conflicts: dict[tuple[str, str], tuple[str, ...]] = {}
        self._compared: set[str] = set()
        """Sources whose units were compared with those that a log states."""
        self._of_files: list[str] = []
        self._headers: dict[tuple[str, str, str], list[FileHeader]] = {}

    def update(self, source: str, file: str, rows: LogRows, run: str = "") -> None:
        """Look at rows as they stream past; raises `InputError` at what cannot be.

        One file may hold the logs of several runs, each with its own clock: `run` distinguishes them.
        """
        key, of_source = (source, file, run), self._settings[source]
        settings = self._campaign.manifest.sources[source]
        if key not in self._watched:
            self._headers[key] = self._take_headers(source, file, {})
            place = partial(partial, place_of_row, self._campaign.folder, settings)
            self._watched[key] = LogQuality(
                file,
                place(file),
                not settings.is_states,
                of_source.columns,
                elsewhere={signal: (own, place(own)) for signal, own in of_source.files.items()},
                slides=frozenset() if settings.joints is None else settings.joints.length_columns(),
                declared=declared_units(settings),
                by_the_wall=settings.time is not None and settings.time.in_words,
                sampler=None if settings.is_states else ReadingSampler(of_source.columns, of_source.units),
            )
        self._watched[key].update(rows.number, rows.time, rows.signals)

    def compare_rows(self, source: str, file: str, states: RawStates) -> None:
        """Take in the states of a table, to be compared with all others; those that are excluded do not count."""
        in_use = [k for k, reason in enumerate(states.set_aside) if reason.code is not SetAsideCode.EXCLUDED]
        kept = np.array(in_use, dtype=np.int64)[np.argsort(states.number[in_use], kind="stable")]
        signals = {name: values[kept].T for name, values in states.signals.items()}
        of_source = self._settings[source]
        self._copies.update(file, states.number[kept], signals, of_source.columns, of_source.units)

    def has_begun(self, source: str, file: str, run: str = "") -> bool:
        """Return whether anything of a log was given to `update`, and not yet to `finish`."""
        return (source, file, run) in self._watched

    def finish(self, source: str, file: str, run: str = "") -> ReadLog:
        """Return what was seen of a log that was read to its end; it counts from now on.

        Raises
        ------
        KeyError : nothing of it was given to `update`.
        """
        key = (source, file, run)
        self.logs[key] = self._watched.pop(key).summary()
        return ReadLog(source, self.logs[key], tuple(self._headers.pop(key)))

    def add(self, log: ReadLog, run: str) -> None:
        """Take in what was seen of a log when it was read earlier."""
        self._take_headers(log.source, log.summary.file, {header.file: header for header in log.headers})
        self.logs[log.source, log.summary.file, run] = log.summary

    def described(self, source: str) -> tuple[bool, Mapping[str, tuple[str, ...]], Mapping[str, str]]:
        """Return what the summaries of a source's logs share: sampled, columns, files of signals."""
        of_source = self._settings[source]
        return not self._campaign.manifest.sources[source].is_states, of_source.columns, of_source.files

    def _take_headers(self, source: str, file: str, known: Mapping[str, FileHeader]) -> list[FileHeader]:
        """Take in the headers of a log's files that no earlier log has shown, and return those that were looked at.

        Where a header takes long, that of the source's first log stands for all.
        """
        taken: list[FileHeader] = []
        if not self._campaign.manifest.sources[source].in_files:
            return taken
        for own in dict.fromkeys((file, *self._settings[source].files.values())):
            if (source, own) in self._unit_conflicts:
                continue
            is_first = source not in self._compared
            self._compared.add(source)
            header = known.get(own) or self._look_at_header(source, own, is_first)
            if header is not None and not (is_first or header.at_once):
                header = None
            self._unit_conflicts[source, own] = () if header is None else header.conflicts
            if header is not None:
                taken.append(header)
                self._of_files += [f"{own}: {remark}" for remark in header.remarks]
        return taken

    def _look_at_header(self, source: str, own: str, is_first: bool) -> FileHeader | None:
        settings, folder = self._campaign.manifest.sources[source], self._campaign.folder
        at_once = header_at_once(folder, settings, own)
        if not (is_first or at_once):
            return None
        header = header_of_file(folder, settings, own)
        return FileHeader(own, unit_conflicts(settings, header.units), tuple(header.remarks), at_once)

    def stuck_channel_faults(self) -> list[Fault]:
        """Return a fault for every channel that does not change: the cause where load and motion contradict."""
        mend = "check the sensor, or exclude the channel"
        return [
            Fault(FaultCode.READING_IMPLAUSIBLE, remark.file, "", remark.text, mend)
            for log in self.logs.values()
            for remark in log.still_channels()
        ]

    def constant_signal_faults(self) -> list[Fault]:
        """Return a fault for every signal that is the same in all rows of the campaign; all logs were read."""
        return constant_signals(self.logs)[0]

    def copied_runs(self) -> list[CopiedRuns]:
        """Return the runs whose logs hold the same readings; sought once, until more logs have been read."""
        if self._copied is None or self._copied[0] != len(self.logs):
            self._copied = len(self.logs), copied_runs(self.logs)
        return self._copied[1]

    def remarks(self) -> list[str]:
        """Return warnings: doubts that are no faults."""
        remarks = [remark for log in self.logs.values() for remark in log.remarks()]
        remarks += constant_signals(self.logs)[1] + short_logs(self.logs)
        remarks += self._copies.warnings() + copied_log_warnings(self.copied_runs()) + self._of_files
        remarks += conflict_warnings((file, found) for (_, file), found in self._unit_conflicts.items())
        dead = {key: log.dead() for key, log in self.logs.items()}
        n_logs = Counter(source for source, _, _ in self.logs)
        n_dead = Counter((source, k) for (source, _, _), channels in dead.items() for k in channels)
        remarks += [
            log.dead_channel_remark(k)
            for (source, file, run), log in self.logs.items()
            for k in dead[source, file, run]
            if n_dead[source, k] < n_logs[source]  # alive in another log
        ]
        return remarks


@dataclass(frozen=True)
class _LogSettings:
    """What the manifest states of all logs of a source."""

    columns: Mapping[str, tuple[str, ...]]
    files: Mapping[str, str]
    units: Mapping[str, float]
    """What one of a column's unit is, SI; of logs at the joints' side."""

    @classmethod
    def of(cls, campaign: Campaign, source: str) -> _LogSettings:
        settings = campaign.manifest.sources[source]
        columns = columns_of_signals(settings, source)
        units = {column: unit.factor for column, unit in declared_units(settings).items()}
        if settings.joints is not None and settings.joints.motor and not settings.is_states:
            ratios = zip(columns.get("joints.torque", ()), campaign.chain.gear_ratio.tolist(), strict=False)
            units |= {column: units.get(column, 1.0) * ratio for column, ratio in ratios}
        return cls(columns, files_of_signals(settings, source), units)


def loads_of(states: LoadStates) -> Booleans:
    """Return of each run whether a load moved the robot: where the controller corrects it is not what the load did."""
    return np.array([run.is_displaced for run in states.runs], dtype=np.bool_)


def check_load_states(
    states: LoadStates,
    campaign: Campaign,
    estimated: bool,
    partial_logs: bool = False,
    copied: Sequence[CopiedRuns] = (),
) -> tuple[list[Fault], list[str]]:
    """Return faults, of what cannot be in the load states, and warnings, of what is doubtful.

    Parameters
    ----------
    estimated : True where frames were found from these very states.
    partial_logs : True where more states are to come: of logs only the beginning was read, or files are not there yet.
    copied : runs whose logs hold the same readings, which was said: their states are not compared again.
    """
    chain, manifest = campaign.chain, "campaign.toml"
    loads = loads_of(states)
    chosen = states.select(loads[states.run] & states.used)
    faults = [] if partial_logs else check_displacement_measured(states) + _unloaded(chosen, campaign)
    if faults:
        return faults, []
    outliers = states.set_aside_code == SetAsideCode.BUMPED.value
    zeros = force_zero_faults(chosen, chain)
    known = {run for group in copied for run in group.runs[1:]}
    others = np.array([(run.of or run.name) not in known for run in states.runs], dtype=np.bool_)[states.run]
    repeated = repeated_rows(states.select((loads[states.run] | states.absolute) & states.used & others))
    warnings = loaded_references(chosen) + rezeroed_table(chosen, chain) + repeated + rows_without_place(states)
    warnings += stopped_targets(states.select(loads[states.run] & (states.used | outliers)), chain)
    warnings += orientations_not_measured(states, campaign)
    warnings += [f"{fault.place}: {fault.reason}; {fault.mend}" for fault in zeros]
    if not states.deflection_given and states.setup.targets:
        faults += check_kinematics(states, chain, estimated, stated_units(campaign))
        match = match_kinematics(states, chain)
        if not faults and match.median_m > MEETS_M:
            warnings.append(miss_words(states, chain, estimated, stated_units(campaign), match.median_m))
    if faults:
        return faults, warnings
    faults, doubts = unit_slips(chosen, campaign)
    warnings += rods_that_cannot_be_right(chosen, chain)
    faults = faults or check_work(chosen, chain, manifest, *_wrench_of(campaign)) or _turned(chosen, campaign)
    # a zero that moved under load is enough to turn the work's sign: the cause before its consequence
    return (zeros + faults if faults else []), warnings + doubts


def _unloaded(states: LoadStates, campaign: Campaign) -> list[Fault]:
    """Return a fault where the load that the manifest names is zero in every state of the load runs."""
    signals = [
        f"sources.{source}.{name}"
        for source, name, signal in campaign.manifest.signals()
        if isinstance(signal, Wrench | DeadWeight)
    ]
    if len(states) == 0 or not signals or np.any(states.wrench):
        return []
    reason = f"all loads are zero in all {len(states)} states of the load runs: nothing deforms the robot"
    mend = "check the sensor and its columns; states without a load alone identify no stiffness"
    return [Fault(FaultCode.READING_IMPLAUSIBLE, MANIFEST_FILE, ", ".join(signals), reason, mend)]


def rods_that_cannot_be_right(states: LoadStates, chain: Chain) -> list[str]:
    """Return one line for every rod that its own readings, the others' or the load contradict."""
    if not states.setup.rods or len(states) < ENOUGH_FOR_RODS:
        return []
    links = measure_links(observe(states, chain), CompliantRobot(chain, ()))
    return [fault.sentence for link in links for fault in link.faults]


def unit_slips(states: LoadStates, campaign: Campaign) -> tuple[list[Fault], list[str]]:
    """Return faults and warnings about units that only load, displacement and poses together show."""
    faults: list[Fault] = []
    warnings: list[str] = []
    for source, name, signal in campaign.manifest.signals():
        place = f"sources.{source}.{name}.units"
        if isinstance(signal, Deflection):
            faults += check_displacement_unit(states, signal.unit_of("translation").name, f"{place}.translation")
        elif isinstance(signal, Wrench):
            warnings += loads_like_thousands(states, campaign.chain, f"{place}.force")
        elif isinstance(signal, JointSignals):
            faults = faults or _read_otherwise(states, campaign, f"sources.{source}.{name}")
            if not faults and signal.units.position == "deg":
                warnings += angles_like_radians(states, f"{place}.position")
    return faults, warnings


def _read_otherwise(states: LoadStates, campaign: Campaign, joints: str) -> list[Fault]:
    acts_on, wrench, columns, _ = _wrench_of(campaign)
    places = TablePlaces(joints, wrench, columns, acts_on, MANIFEST_FILE)
    return check_other_readings(states, campaign.chain, stated_units(campaign), places)


def _turned(states: LoadStates, campaign: Campaign) -> list[Fault]:
    """Return a fault where the force sensor is turned on the robot otherwise than its frame states."""
    found = turned_sensor(states, campaign.chain)
    axes = [signal.axes_frame for _, _, signal in campaign.manifest.signals() if isinstance(signal, Wrench)]
    if found is None or not axes or axes[0] is None:
        return []
    frame = campaign.manifest.frames.get(axes[0])
    written = f"rpy_deg = {[int(angle) for angle in found.rpy_deg]}"
    on_flange = frame is not None and frame.parent == "flange"
    where = "write about" if on_flange else "its axes against the flange's are about"
    reason = (
        f"joint-compliance explains {percent(found.declared)} of the deflection, and {percent(found.turned)} "
        f"with the sensor turned by {found.turn_deg:.0f}°"
    )
    mend = f"{where} {written}, as its mounting shows it, or check the order and signs of the force's columns"
    return [Fault(FaultCode.WRENCH_MISMATCH, MANIFEST_FILE, f"frames.{axes[0]}", reason, mend)]


def _wrench_of(campaign: Campaign) -> tuple[str, str, tuple[str, ...], tuple[str, ...]]:
    """Return on what the first wrench in the manifest acts as it states, its key, its columns and their units."""
    for source, name, signal in campaign.manifest.signals():
        if isinstance(signal, Wrench):
            units = (signal.units.force, signal.units.moment)
            return signal.acts_on, f"sources.{source}.{name}", signal.columns, units
    return "robot", "wrench", (), ()


def loaded_references(states: LoadStates) -> list[str]:
    """Return a warning for every run whose reference carries a load: no displacement from the unloaded robot."""
    remarks = []
    size = np.linalg.norm(states.wrench[:, :3], axis=1)
    members = states.members()
    for k in np.flatnonzero(states.reference):
        own = members[states.run[k]]
        largest = float(size[own].max())
        if size[k] > UNLOADED_SHARE * largest > 0.0 and own.size > 1:
            name = states.runs[int(states.run[k])].name
            remarks.append(
                f"run {name}: its reference, state {states.row[k]}, has a load of {size[k]:.0f} N of {largest:.0f} N"
            )
    return remarks
