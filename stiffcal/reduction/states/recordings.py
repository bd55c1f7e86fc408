"""Load states of a run from its logs: clocks aligned, holds found or taken from a table, each signal averaged."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.found.experiment_kinds import measure_of
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.set_aside import IN_USE, SetAside, SetAsideCode
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.reduction.clocks.course import ClockCourse, clock_courses
from stiffcal.reduction.clocks.gaps import JUMP_S, longest_gap
from stiffcal.reduction.clocks.lag_search import SharedSignal, moves
from stiffcal.reduction.clocks.offsets import SourceClockOffset, align_clocks
from stiffcal.reduction.holds.finding import Holds, find_holds
from stiffcal.reduction.holds.swept import find_sweeps, is_swept
from stiffcal.reduction.holds.unused import UnusedCode, UnusedStretch
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.wording import significant

# Signals by which two logs' clocks are compared, the load first.
_SHARED = ("wrench", "position.", "marker.", "lengths.", "displacement.", "joints")
# A joint log without a clock may stand for the whole run when its joints stay within this: a tenth of what a
# direction-finding touch of the pendant moves, and 0.1 mm at 1 m.
STANDING_RAD = 1e-4
TEMPERATURE = "temperature"  # changes within a run though the joints stand, and slowly: a nearly known clock will do
MISSED = 0.25  # of the holds, outside of a device's log: more is hardly an early end of logging
LEAST_EXCITED = 0.5  # of a hold, by every device: less is no state


@dataclass(frozen=True)
class ReducedRun:
    """A run, reduced."""

    states: RawStates
    """Its load states."""
    clocks: dict[str, SourceClockOffset]
    """Source to offset."""
    holds: Holds
    """On the first source's clock."""
    dropped: tuple[UnusedStretch, ...]
    """What was thrown away, and why."""
    warnings: tuple[str, ...]
    """What the user ought to know."""
    passes: int = 0
    """Of a load that was swept: how often it went from one turning point to the next; 0 where it was held."""
    courses: tuple[ClockCourse, ...] = ()
    """How its clocks run against each other."""


def shared_signal(source: str, blocks: Blocks) -> SharedSignal:
    """Return the signal to compare this log's clock with others': the load if logged, else a displacement it causes."""
    for stem in _SHARED:
        names = [name for name in blocks.mean if name == stem or (stem.endswith(".") and name.startswith(stem))]
        if names:
            values = np.concatenate([blocks.mean[name] for name in names], axis=1)
            # of a force along one axis the others, and the moments, are no signal
            moving = np.ptp(values, axis=0) > 0.0
            values = values[:, moving] if moving.any() else values
            return SharedSignal(source, blocks.time, values, leads=stem == "wrench")
    names = list(blocks.mean)
    return SharedSignal(source, blocks.time, np.concatenate([blocks.mean[name] for name in names], axis=1), False)


def reduce_run(run: Run, logs: Mapping[str, Blocks], tabled: Holds | None = None) -> ReducedRun:
    """Reduce the logs of one run to load states.

    Parameters
    ----------
    run : the manifest's entry.
    logs : source to block averages in SI, in the manifest's order; the first one's clock counts, or the load's where
        the first log stands still: nothing can be compared with it.
    tabled : holds that a table states, on the first source's clock; None: they are found.

    Raises
    ------
    InputError
        No hold is found, or a log that moves cannot be placed in time.
    """
    shared = [shared_signal(source, blocks) for source, blocks in logs.items()]
    if tabled is None and not run.clock_ahead_s:  # else the manifest states times of the first source's clock
        shared = _load_before_what_stands(shared)
        logs = {signal.source: logs[signal.source] for signal in shared}
    clocks = align_clocks(shared, run.clock_ahead_s)
    devices = {name for name, blocks in logs.items() if any(key.startswith("displacement.") for key in blocks.mean)}
    holds, passes = (tabled, 0) if tabled is not None else _find_run_holds(run, shared, clocks, devices)
    if len(holds) == 0:
        raise InputError.at(
            FaultCode.STATES_MISSING, f"run {run.id}", "", "no load state found: the load was never constant",
            'keep each load constant for a second or more, or write states = "….csv" with columns start, end',
        )  # fmt: skip
    clocks, courses = clock_courses(shared, clocks, run.clock_ahead_s)
    warnings: list[str] = []
    holds, brief = _with_brief_ones(holds)
    dropped = list(holds.dropped)
    keep = np.ones(len(holds), dtype=np.bool_)
    placed: list[tuple[str, Blocks, float | None]] = []
    for source, blocks in logs.items():
        ahead = _ahead(run, source, logs, clocks[source], warnings)
        placed.append((source, blocks, ahead))
        if ahead is None:
            continue
        # what the device measured of a hold is averaged, unless it missed the better half
        start = np.maximum(holds.start, blocks.start[0] - ahead)
        end = np.minimum(holds.end, blocks.end[-1] - ahead + blocks.interval)
        covered = end - start >= LEAST_EXCITED * (holds.end - holds.start)
        for k in np.flatnonzero(keep & ~covered):
            dropped.append(UnusedStretch(float(holds.start[k]), float(holds.end[k]), UnusedCode.NOT_LOGGED, source))
        if (~covered).sum() > MISSED * len(holds):
            warnings.append(_missed_holds_text(run.id, source, int((~covered).sum()), len(holds)))
        keep &= covered
        holds = replace(holds, start=np.where(covered, start, holds.start), end=np.where(covered, end, holds.end))
    if not (keep & ~brief).any():
        raise InputError.at(
            FaultCode.STATES_MISSING,
            f"run {run.id}",
            "",
            "the logs of this run have no common load state",
            "check which files belong together",
        )
    numbers = np.flatnonzero(keep)
    states = _average_holds(run, holds, numbers, placed)
    lasted = holds.left - holds.reached
    set_aside = [
        SetAside(SetAsideCode.HELD_BRIEFLY, f"dwell too short: {significant(seconds, 2)} s") for seconds in lasted
    ]
    states = replace(states, set_aside=[set_aside[k] if brief[k] else IN_USE for k in numbers])
    dropped = sorted(dropped, key=lambda stretch: stretch.start)
    return ReducedRun(states, clocks, holds, tuple(dropped), tuple(warnings), passes, tuple(courses))


def _load_before_what_stands(shared: list[SharedSignal]) -> list[SharedSignal]:
    """Return the logs with the load's first where the first one stands still, as joint angles in one pose do."""
    if moves(shared[0].values):
        return shared
    load = next((signal for signal in shared if signal.leads and moves(signal.values)), shared[0])
    return [load, *(signal for signal in shared if signal is not load)]


def beginning(run: Run, logs: Mapping[str, Blocks]) -> RawStates:
    """Return one state from the beginning of each log: for a quick look, before a run has ended."""
    placed: list[tuple[str, Blocks, float | None]] = [
        (source, blocks, blocks.start[0] - next(iter(logs.values())).start[0]) for source, blocks in logs.items()
    ]
    first = next(iter(logs.values()))
    start = np.array([first.start[0]])
    end = start + min(np.ptp(first.time), 0.5) + 1e-9
    holds = Holds(start, end, start, end)
    return _average_holds(run, holds, np.zeros(1, dtype=np.int64), placed)


def _find_run_holds(
    run: Run, shared: list[SharedSignal], clocks: Mapping[str, SourceClockOffset], devices: Set[str]
) -> tuple[Holds, int]:
    """Find holds in the load, else in what moved most clearly, and bring them to the first source's clock.

    A load that was swept rather than held gives the moments at which it passed a few levels, and how often it went up
    or down. A device that presses along one line and reads the displacement there (``devices``) may rest at the ends
    of its sweeps; any other load counts as swept only where no hold is found at all.
    """
    for signal in sorted(shared, key=lambda signal: not signal.leads):
        ahead = clocks[signal.source].value
        if ahead is None or not moves(signal.values):
            continue
        swept = None
        if signal.source in devices and is_swept(signal.time, signal.values):
            swept = find_sweeps(signal.time, signal.values)
        run_holds = find_holds(signal.time, signal.values) if swept is None else swept.holds
        if len(run_holds) == 0 and signal.leads and is_swept(signal.time, signal.values):
            swept = find_sweeps(signal.time, signal.values)
            run_holds = run_holds if swept is None else swept.holds
        if len(run_holds) == 0:
            continue
        shifted = tuple(replace(d, start=d.start - ahead, end=d.end - ahead) for d in run_holds.dropped)
        holds = Holds(
            run_holds.start - ahead, run_holds.end - ahead, run_holds.reached - ahead, run_holds.left - ahead, shifted
        )
        return holds, 0 if swept is None else swept.passes
    # nothing moves: one unloaded pose ("free"), or a forgotten load; the whole log is one hold
    if measure_of(run.experiment) is StateMeasure.FRAME:
        first = shared[0]
        ends = np.array([first.time[0]]), np.array([first.time[-1]])
        return Holds(*ends, *ends), 0
    return Holds(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0)), 0


def _ahead(
    run: Run, source: str, logs: Mapping[str, Blocks], clock: SourceClockOffset, warnings: list[str]
) -> float | None:
    """Return a log's clock offset, None where it stands still and any time will do."""
    if clock.value is not None:
        return clock.value
    blocks = logs[source]
    joints = blocks.mean.get("joints")
    joints_stand = joints is not None and bool(np.ptp(joints, axis=0).max() < STANDING_RAD)
    if joints_stand or all(not moves(values) for values in blocks.mean.values()):
        return None
    if (
        joints is not None
        and set(blocks.mean) <= {"joints", TEMPERATURE}
        and bool((joints.std(axis=0) < 10.0 * STANDING_RAD).all())
    ):
        warnings.append(
            f"run {run.id}: the clock of {source} is unknown ({clock.reason}); its mean over the run is used"
        )
        return None
    reason, mend = (
        clock.reason or "not known",
        f"give {toml_text.pair('clock_ahead_s', {source: 0.0})} for this run (s)",
    )
    gap, name = max((longest_gap(log.time), name) for name, log in logs.items())
    if gap.length > JUMP_S:
        reason += f"; the times of {name} jump by {significant(gap.length)} s before {gap.before:.1f} s"
        file = run.files.get(name, "the log")
        mend = f"was it reset there? correct the times in a copy of {file}, or split the run; else {mend}"
    raise InputError.at(FaultCode.CLOCK_UNKNOWN, f"run {run.id}", f"clock of {source}", reason, mend)


def _missed_holds_text(run: str, source: str, missed: int, count: int) -> str:
    return (
        f"run {run}: with the estimated clocks {missed} of {count} dwells are outside the log of {source} and not "
        "used; if both devices logged at the same time, this clock offset is wrong (possible causes: repeated "
        "loads, a clock that was reset, a sensor that was zeroed again): split the run there, or give "
        f"{toml_text.pair('clock_ahead_s', {source: 0.0})} (s)"
    )


def _with_brief_ones(holds: Holds) -> tuple[Holds, NDArray[np.bool_]]:
    """Return the holds in order together with what was held too briefly to be read, and which those are (h,).

    They become states that are set aside: their load was there, and friction and creep remember it.
    """
    pauses = [piece for piece in holds.dropped if piece.code == UnusedCode.HELD_BRIEFLY]
    reached = np.array([piece.start for piece in pauses])
    hold_end = np.array([piece.end for piece in pauses])
    quarter = 0.25 * (hold_end - reached)
    ends = (
        (holds.start, reached + quarter),
        (holds.end, hold_end - quarter),
        (holds.reached, reached),
        (holds.left, hold_end),
    )
    order = np.argsort(np.concatenate([holds.start, reached + quarter]), kind="stable")
    start, end, reached, hold_end = (np.concatenate(pair)[order] for pair in ends)
    not_brief = tuple(piece for piece in holds.dropped if piece.code != UnusedCode.HELD_BRIEFLY)
    return Holds(start, end, reached, hold_end, not_brief), order >= len(holds)


def _average_holds(
    run: Run, holds: Holds, numbers: NDArray[np.int64], placed: list[tuple[str, Blocks, float | None]]
) -> RawStates:
    """Average every signal over every hold."""
    signals: dict[str, Floats] = {}
    scatter: dict[str, Floats] = {}
    n_readings = np.full(numbers.size, np.iinfo(np.int64).max, dtype=np.int64)
    start, end = holds.start[numbers], holds.end[numbers]
    for _, blocks, ahead in placed:
        means, spreads, counts = hold_means(blocks, start, end, ahead)
        if ahead is None and TEMPERATURE in blocks.mean:
            nearly = _ahead_nearly(blocks, placed[0][1], holds)
            temperature_means, temperature_spreads, _ = hold_means(_only(blocks, TEMPERATURE), start, end, nearly)
            means |= temperature_means
            spreads |= temperature_spreads
        signals |= means
        scatter |= spreads
        if ahead is not None:
            n_readings = np.minimum(n_readings, counts)
    return RawStates(
        run=[run.id] * numbers.size,
        number=numbers + 1,
        time=0.5 * (start + end),
        hold=0.5 * (start + end) - half_way(holds)[numbers],
        signals=signals,
        scatter=scatter,
        n_readings=n_readings,
        set_aside=[IN_USE] * numbers.size,
    )


def _ahead_nearly(blocks: Blocks, first: Blocks, holds: Holds) -> float:
    """Return the clock offset of a log that shares nothing with the others, good enough for what changes slowly.

    Where its times as they are cover all holds the clocks are taken as one; else both logs began together.
    """
    is_one_clock = blocks.start[0] <= holds.start.min() and holds.end.max() <= blocks.end[-1] + blocks.interval
    return 0.0 if is_one_clock else float(blocks.start[0] - first.start[0])


def _only(blocks: Blocks, signal: str) -> Blocks:
    return replace(blocks, mean={signal: blocks.mean[signal]}, variance={signal: blocks.variance[signal]})


def half_way(holds: Holds) -> Floats:
    """Return (h,) when the load was half-way to each hold, s.

    What gives slowly follows an even ramp as it follows a step in the ramp's middle. Where a load held too briefly lies
    before a hold, or a break, the way to it took as long as the others usually do.

    Examples
    --------
    >>> import numpy as np
    >>> half_way(Holds(np.array([0.1, 3.1]), np.array([1.9, 4.9]), np.array([0.0, 3.0]), np.array([2.0, 5.0])))
    array([0. , 2.5])
    """
    ramp = np.maximum(holds.reached[1:] - holds.left[:-1], 0.0)
    usual = np.minimum(ramp, np.median(ramp)) if ramp.size else ramp
    return holds.reached - 0.5 * np.append(0.0, usual)


def hold_means(
    blocks: Blocks, start: Floats, end: Floats, ahead: float | None
) -> tuple[dict[str, Floats], dict[str, Floats], NDArray[np.int64]]:
    """Return mean and standard deviation of single readings of each signal in each hold, and the counts.

    Parameters
    ----------
    start, end : (h,) s on the first source's clock.
    ahead : s that the log's clock shows more; None: the log stands still, all of it counts for every hold.
    """
    n = len(blocks)
    if ahead is None:
        first, last = np.zeros(start.size, dtype=np.int64), np.full(start.size, n, dtype=np.int64)
    else:
        middle = 0.5 * (start + end) + ahead
        first = np.searchsorted(blocks.start, start + ahead, side="left")
        last = np.searchsorted(blocks.end, end + ahead, side="right")
        # a hold shorter than a block: the block in whose middle it lies
        short = last <= first
        nearest = np.clip(np.searchsorted(blocks.time, middle), 0, n - 1)
        first, last = np.where(short, nearest, first), np.where(short, nearest + 1, last)
    counts = np.concatenate([[0], np.cumsum(blocks.count)])
    total = counts[last] - counts[first]
    means: dict[str, Floats] = {}
    spreads: dict[str, Floats] = {}
    for name, mean in blocks.mean.items():
        weight = blocks.count[:, None].astype(np.float64)
        middle_value = mean.mean(axis=0)
        away = mean - middle_value
        sums = _cumulative_sums(away * weight)
        squares = _cumulative_sums(away**2 * weight + blocks.variance[name] * np.maximum(weight - 1.0, 0.0))
        average = (sums[last] - sums[first]) / total[:, None]
        about = np.maximum((squares[last] - squares[first]) - total[:, None] * average**2, 0.0)
        means[name] = average + middle_value
        spreads[name] = np.sqrt(about / np.maximum(total - 1, 1)[:, None])
    return means, spreads, total


def _cumulative_sums(values: Floats) -> Floats:
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
