"""Runs with the controller correcting next to the same poses without it, as they were measured (002, Fig. 6, 7)."""

from __future__ import annotations

import json

import numpy as np

from stiffcal.errors import InputError
from stiffcal.files import read_regular
from stiffcal.ingest.reading.recording_tables import recording_name
from stiffcal.measurements.columns import values_of
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.tables import states_from_table
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.like_poses import SAME_POSE_RAD
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.quantity import DELAY
from stiffcal.reduction.states.commanded import compensated_states
from stiffcal.report.compensation_content import ComparedPose, HalfRun, TimePair, Trace, WithAndWithout
from stiffcal.simulation.truth import TRUTH_FILE
from stiffcal.stages.steps import Ingested, stored_ingest
from stiffcal.wording import in_unit

# Tags of a run that describe its load over time.
_KINDS = {"step": "step", "impulse": "step", "process": "process", "drilling": "process", "milling": "process"}
# A load has come when this share of it is there; a displacement is taken back when half of it is.
_COME, _HALF = 0.1, 0.5
_MOST_POINTS = 4000


def with_and_without(data: Ingested) -> WithAndWithout | None:
    """Return the pairs of runs with and without compensation; None where no run was measured with it."""
    states = states_from_table(data.table)
    on = compensated_states(states)
    if not on.any():
        return None
    first = {run: int(np.flatnonzero(states.run == run)[0]) for run in np.unique(states.run)}
    poses, over_time = [], []
    for run in np.unique(states.run[on]):
        partner = _partner(states, first, int(run))
        if partner is None:
            continue
        kind = next((_KINDS[tag] for tag in states.runs[run].tags if tag in _KINDS), "")
        if not states.deflection_given and states.setup.targets:
            poses.append(_compared(data, states, partner, int(run)))
        if kind:
            pair = _over_time(data, states, partner, int(run), kind)
            if pair is not None:
                over_time.append(pair)
    return WithAndWithout(tuple(poses), tuple(over_time), _delay_remark(data))


def _delay_remark(data: Ingested) -> str:
    """Return the parts of a simulated campaign's delay; a measured one has no truth.json."""
    file = data.campaign.folder / TRUTH_FILE
    try:
        made = json.loads(read_regular(file))["controller"]
        delay, lag, cycle = (float(made[key]) for key in ("delay_s", "filter_lag_s", "cycle_s"))
    except (InputError, OSError, ValueError, KeyError, TypeError, RecursionError):
        return ""
    filtered = f"with a filter of {in_unit(lag, DELAY.usual)} delay" if lag else "without filter"
    return (
        f"This campaign is simulated. Its controller applies a correction "
        f"{in_unit(delay, DELAY.usual)} after the reading, "
        f"{filtered}, with a cycle of {in_unit(cycle, DELAY.usual)}. Robot and load are in static "
        f"equilibrium at every moment; "
        f"vibrations and drive dynamics are not simulated."
    )


def _partner(states: LoadStates, first: dict[int, int], run: int) -> int | None:
    """Return the run without compensation in the same pose with the same tags, else in the same pose."""
    tags = set(states.runs[run].tags)
    same_pose = [
        candidate
        for candidate, state in first.items()
        if not states.runs[candidate].compensated
        and np.abs(states.joints[state] - states.joints[first[run]]).max() < SAME_POSE_RAD
    ]
    same_tags = [candidate for candidate in same_pose if set(states.runs[candidate].tags) == tags]
    return next(iter(same_tags), next(iter(same_pose), None))


def _half(data: Ingested, states: LoadStates, run: int) -> HalfRun:
    members = np.flatnonzero((states.run == run) & (states.set_aside == ""))
    marked = members[states.reference[members]]
    start = int(marked[0]) if marked.size else int(members[0])
    chain = data.campaign.chain
    _, axes = attached_poses(chain, chain.model_angles(states.joints[members]), states.setup.wrench_axes)
    force = np.einsum("nij,nj->ni", axes, states.wrench[members, :3])
    turn = states.rotation[members, 0] @ states.rotation[start, 0].T
    rotation = np.full((len(members), 3), np.nan)
    finite = np.isfinite(turn).all(axis=(1, 2))
    rotation[finite] = vector_from_rotation(turn[finite])
    at = int(np.flatnonzero(members == start)[0])
    return HalfRun(
        states.runs[run].name, force - force[at], states.position[members, 0] - states.position[start, 0], rotation
    )


def _compared(data: Ingested, states: LoadStates, off: int, on: int) -> ComparedPose:
    halves = _half(data, states, off), _half(data, states, on)
    sizes: list[tuple[tuple[float, float], tuple[float, float]]] = []
    for half in halves:
        load = np.linalg.norm(half.force, axis=1)
        loaded = load > _COME * load.max(initial=0.0)
        lengths = [np.linalg.norm(errors[loaded], axis=1) for errors in (half.displacement, half.rotation)]
        rms = [
            float(np.sqrt(np.mean(lengths_of_kind**2))) if lengths_of_kind.size else float("nan")
            for lengths_of_kind in lengths
        ]
        sizes.append(((rms[0], rms[1]), (float(lengths[0].max()), float(lengths[1].max()))))
    joints = states.joints[np.flatnonzero(states.run == off)[0]]
    angles = data.campaign.chain.position_words(joints)
    names = data.joint_names
    return ComparedPose(
        f"{names[0]} … {names[-1]} = {angles}", *halves, sizes[0][0], sizes[1][0], sizes[0][1], sizes[1][1]
    )


def _over_time(data: Ingested, states: LoadStates, off: int, on: int, kind: str) -> TimePair | None:
    """Return two runs over time, or None where wrench and pose were not logged over time."""
    traces = [_trace(data, states, run) for run in (off, on)]
    if traces[0] is None or traces[1] is None:
        return None
    uncorrected = float(traces[0].displacement.max())
    delay, remaining = _delay_and_remaining(traces[1])
    return TimePair(kind, traces[0], traces[1], delay, remaining, uncorrected)


def _delay_and_remaining(trace: Trace) -> tuple[float, float]:
    """Return s from the load's coming until half of what it moved is taken back, and m, what remains then for good."""
    load = np.linalg.norm(trace.wrench[:, :3] - trace.wrench[0, :3], axis=1)
    loaded = load > _COME * load.max()
    between = np.interp(trace.time, trace.time[loaded], np.ones(int(loaded.sum())), left=0.0, right=0.0) > 0.0
    unloaded = np.flatnonzero(between & ~loaded)
    last = int(unloaded[0]) if unloaded.size else int(np.flatnonzero(loaded)[-1]) + 1
    begin = int(np.flatnonzero(loaded)[0])
    stretch = trace.displacement[begin:last]
    top = int(np.argmax(stretch))
    below_half = np.flatnonzero(stretch[top:] < _HALF * stretch[top])
    delay = float(trace.time[begin + top + below_half[0]] - trace.time[begin]) if below_half.size else float("nan")
    tail = stretch[-max(3, len(stretch) // 4) :]
    return delay, float(np.median(tail))


def _trace(data: Ingested, states: LoadStates, run: int) -> Trace | None:
    """Return a run's readings on the force sensor's clock, its time counted from when the load comes."""
    name = states.runs[run].name
    sources = data.campaign.manifest.sources
    wrench = next((key for key, device in sources.items() if device.wrench is not None and not device.is_states), None)
    pose = next((key for key, device in sources.items() if device.pose is not None and not device.is_states), None)
    if wrench is None or pose is None:
        return None
    tables = [recording_name(name, source) for source in (wrench, pose)]
    if any(table not in data.store.tables for table in tables):
        return None
    ahead = _clocks(data, name)
    force_table, pose_table = (data.store.read_table(table) for table in tables)
    time = np.asarray(values_of(force_table.column("time_s"))) - ahead.get(wrench, 0.0)
    force = np.stack(
        [np.asarray(values_of(force_table.column(key))) for key in force_table.column_names if key[:2] in _WRENCH],
        axis=1,
    )
    target = states.setup.target_names[0]
    place = np.stack([np.asarray(values_of(pose_table.column(f"{target}_{axis}_m"))) for axis in "xyz"], axis=1)
    at = np.asarray(values_of(pose_table.column("time_s"))) - ahead.get(pose, 0.0)
    whole = np.zeros((len(force), 6))
    whole[:, : force.shape[1]] = force
    n_initial = max(3, int(0.05 * len(place)))
    distance = np.linalg.norm(place - np.median(place[:n_initial], axis=0), axis=1)
    size = np.linalg.norm(whole[:, :3] - np.median(whole[: max(3, len(whole) // 20), :3], axis=0), axis=1)
    begin = time[int(np.argmax(size > _HALF * size.max()))]
    finite = np.isfinite(distance)
    inside = (time >= at[finite][0]) & (time <= at[finite][-1])
    pick = np.flatnonzero(inside)[:: max(1, int(inside.sum() / _MOST_POINTS))]
    return Trace(name, time[pick] - begin, whole[pick], np.interp(time[pick], at[finite], distance[finite]))


_WRENCH = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def _clocks(data: Ingested, run: str) -> dict[str, float]:
    """Return source to the seconds that its clock shows more than the first source's, in a run."""
    ingest = stored_ingest(data.store)
    for entry in () if ingest is None else ingest.runs:
        if entry.id == run:
            return {source: offset.value or 0.0 for source, offset in entry.clock_ahead_s.items()}
    return {}
