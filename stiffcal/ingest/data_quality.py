"""Watching sources while they are read, and judging the load states that come out."""

from __future__ import annotations

from collections import Counter
from functools import partial

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.naming import MANIFEST_FILE
from stiffcal.campaign.signals import DeadWeight, Deflection, JointSignals, Pose, Wrench
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.measured_links import measure_links
from stiffcal.identification.readings import observe
from stiffcal.ingest.constant_signals import constant_signals
from stiffcal.ingest.header_units import conflict_warnings, declared_units, unit_conflicts
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.mechanics.chain import Chain
from stiffcal.model.composite import CompliantRobot
from stiffcal.reduction.consistency import MEETS_M, check_kinematics, check_work, match_kinematics, miss_words
from stiffcal.reduction.displacement_measured import check_displacement_measured
from stiffcal.reduction.force_zero_faults import force_zero_faults
from stiffcal.reduction.load_cycles import UNLOADED_SHARE
from stiffcal.reduction.logs import Rows, columns_of_signals, files_of_signals, header_of_file, place_of_row
from stiffcal.reduction.plausibility import LogQuality
from stiffcal.reduction.reading_bounds import check_displacements
from stiffcal.reduction.repeated_rows import repeated_rows
from stiffcal.reduction.rezeroed_tables import rezeroed_table
from stiffcal.reduction.rounded_copies import RoundedCopies
from stiffcal.reduction.stopped_targets import stopped_targets
from stiffcal.reduction.unit_slips import check_angle_convention, check_angle_unit, check_displacement_unit

# States below which rods are not judged: a quick look has one of each run.
ENOUGH_FOR_RODS = 12
MOST_ROWS_NAMED = 10


class DataQuality:
    """The quality of the data by source and file of a campaign."""

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self.logs: dict[tuple[str, str, str], LogQuality] = {}
        self._copies = RoundedCopies()
        self._unit_conflicts: dict[tuple[str, str], tuple[str, ...]] = {}
        self._compared: set[str] = set()
        """Sources whose units were compared with those that a log states."""
        self._of_files: list[str] = []

    def update(self, source: str, file: str, rows: Rows, run: str = "") -> None:
        """Look at rows as they stream past; raises `InputError` at what cannot be.

        One file may hold the logs of several runs, each with its own clock: `run` distinguishes them.
        """
        key = (source, file, run)
        if key not in self.logs:
            settings = self._campaign.manifest.sources[source]
            self._look_at_header(source, file)
            place = partial(partial, place_of_row, self._campaign.folder, settings)
            files = files_of_signals(settings, source)
            elsewhere = {signal: (own, place(own)) for signal, own in files.items()}
            self.logs[key] = LogQuality(
                file,
                place(file),
                not settings.is_states,
                columns_of_signals(settings, source),
                elsewhere=elsewhere,
                slides=frozenset() if settings.joints is None else settings.joints.length_columns(),
                declared={column: unit.name for column, unit in declared_units(settings).items()},
                by_the_wall=settings.time is not None and settings.time.in_words,
            )
        self.logs[key].update(rows.number, rows.time, rows.signals)
        settings = self._campaign.manifest.sources[source]
        if settings.is_states:
            factors = {column: unit.factor for column, unit in declared_units(settings).items()}
            self._copies.update(file, rows.number, rows.signals, self.logs[key].columns, factors)

    def _look_at_header(self, source: str, file: str) -> None:
        """Compare a log's units with the manifest's, in the first log alone where that takes long; keep its remarks."""
        settings, folder = self._campaign.manifest.sources[source], self._campaign.folder
        for own in {file, *files_of_signals(settings, source).values()} if settings.in_files else ():
            if (source, own) not in self._unit_conflicts:
                later = source in self._compared
                self._compared.add(source)
                header = header_of_file(folder, settings, own, at_once=later)
                self._unit_conflicts[source, own] = unit_conflicts(settings, header.units)
                self._of_files += [f"{own}: {remark}" for remark in header.remarks]

    def stuck_channel_faults(self) -> list[Fault]:
        """Return a fault for every channel that does not change: the cause where load and motion contradict."""
        mend = "check the sensor, or exclude the channel"
        return [
            Fault(FaultCode.READING_IMPLAUSIBLE, remark.file, "", remark.text, mend)
            for watch in self.logs.values()
            for remark in watch.still_channels()
        ]

    def constant_signal_faults(self) -> list[Fault]:
        """Return a fault for every signal that is the same in all rows of the campaign; all logs were read."""
        return constant_signals(self.logs)[0]

    def remarks(self) -> list[str]:
        """Return warnings: doubts that are no faults."""
        remarks = [remark for watch in self.logs.values() for remark in watch.remarks()]
        remarks += constant_signals(self.logs)[1]
        remarks += self._copies.warnings() + self._of_files
        remarks += conflict_warnings((file, found) for (_, file), found in self._unit_conflicts.items())
        dead = {key: watch.dead() for key, watch in self.logs.items()}
        n_logs = Counter(source for source, _, _ in self.logs)
        n_dead = Counter((source, k) for (source, _, _), channels in dead.items() for k in channels)
        remarks += [
            watch.dead_channel_remark(k)
            for (source, file, run), watch in self.logs.items()
            for k in dead[source, file, run]
            if n_dead[source, k] < n_logs[source]  # alive in another log
        ]
        return remarks


def check_load_states(
    states: LoadStates, campaign: Campaign, estimated: bool, partial_logs: bool = False
) -> tuple[list[Fault], list[str]]:
    """Return faults, of what cannot be in the load states, and warnings, of what is doubtful.

    Parameters
    ----------
    estimated : True where frames were found from these very states.
    partial_logs : True where more states are to come: of logs only the beginning was read, or files are not there yet.
    """
    chain, manifest = campaign.chain, "campaign.toml"
    # Where the controller was correcting, what is measured is not what the load did.
    loads = np.array([run.experiment == "load" and not run.compensated for run in states.runs], dtype=np.bool_)
    chosen = states.select(loads[states.run] & states.used)
    faults = check_displacements([run.name for run in states.runs], chosen.run, chosen.position, manifest)
    if not faults and not partial_logs:
        faults = check_displacement_measured(states) + _unloaded(chosen, campaign)
    if faults:
        return faults, []
    outliers = states.set_aside_code == SetAsideCode.BUMPED.value
    zeros = force_zero_faults(chosen, chain)
    repeated = repeated_rows(states.select((loads[states.run] | states.absolute) & states.used))
    warnings = loaded_references(chosen) + rezeroed_table(chosen, chain) + repeated + rows_without_place(states)
    warnings += stopped_targets(states.select(loads[states.run] & (states.used | outliers)), chain)
    warnings += orientations_not_measured(states, campaign)
    warnings += [f"{fault.place}: {fault.reason}; {fault.mend}" for fault in zeros]
    if not states.deflection_given and states.setup.targets:
        faults += check_kinematics(states, chain, estimated)
        match = match_kinematics(states, chain)
        if not faults and match.median_m > MEETS_M:
            warnings.append(miss_words(states, chain, estimated, match.median_m))
    if faults:
        return faults, warnings
    faults, doubts = unit_slips(chosen, campaign)
    warnings += rods_that_cannot_be_right(chosen, chain)
    faults = faults or check_work(chosen, chain, manifest, *_wrench_of(campaign))
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
        elif isinstance(signal, JointSignals):
            if signal.units.position == "deg":
                slips, doubts = check_angle_unit(states, campaign.chain, f"{place}.position")
                faults, warnings = faults + slips, warnings + doubts
            if not faults:
                faults += check_angle_convention(states, campaign.chain, f"sources.{source}.{name}")
    return faults, warnings


def _wrench_of(campaign: Campaign) -> tuple[str, str, tuple[str, ...]]:
    """Return on what the first wrench in the manifest acts as it states, its key, and its columns."""
    for source, name, signal in campaign.manifest.signals():
        if isinstance(signal, Wrench):
            return signal.acts_on, f"sources.{source}.{name}", signal.columns
    return "robot", "wrench", ()


def rows_without_place(states: LoadStates) -> list[str]:
    """Return a warning for rows of absolute runs in which no target was measured."""
    missing = np.flatnonzero(states.absolute & (states.set_aside_code == SetAsideCode.NOT_MEASURED.value))
    if not missing.size:
        return []
    rows = ", ".join(str(int(row)) for row in states.row[missing[:MOST_ROWS_NAMED]])
    more = f" and {missing.size - MOST_ROWS_NAMED} more" if missing.size > MOST_ROWS_NAMED else ""
    return [f"no target was measured in row {rows}{more} of absolute runs: not used"]


def orientations_not_measured(states: LoadStates, campaign: Campaign) -> list[str]:
    """Return a warning for each orientation that the manifest names where no state has one: positions alone count."""
    given = [np.isfinite(part).any() for part in (states.rotation, states.deflection[:, :, 3:])]
    named = [
        (f"sources.{source}.{name}", columns)
        for source, name, signal in campaign.manifest.signals()
        if (columns := _orientation_columns(signal))
    ]
    if any(given) or not named or not states.used.any():
        return []
    return [
        f"{place}: no state has an orientation, {', '.join(columns)} have gaps in all rows: positions alone are used"
        for place, columns in named
    ]


def _orientation_columns(signal: object) -> tuple[str, ...]:
    if isinstance(signal, Pose):
        return () if signal.orientation is None else signal.orientation[1]
    return tuple(signal.rotation or ()) if isinstance(signal, Deflection) else ()


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
