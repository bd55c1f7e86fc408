"""Load states from raw states: places in base axes, wrenches on the robot in the set-up's axes, references marked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.found.experiment_kinds import measure_of
from stiffcal.campaign.frames.frames import sigma_of_places
from stiffcal.campaign.manifest.manifest import Manifest, Run
from stiffcal.campaign.manifest.tracker_frames import trackers_of_runs
from stiffcal.campaign.signals.signals import Pose
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, MeasurementSetup, RunInfo
from stiffcal.measurements.set_aside import SetAside, SetAsideCode, set_aside_columns
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.measurements.tracker_axes import each_tracker
from stiffcal.mechanics.chain import Chain
from stiffcal.quaternions import rotation_from_quaternion
from stiffcal.reduction.loads.cycles import UNLOADED_SHARE
from stiffcal.reduction.logs.markers import fitted_poses
from stiffcal.reduction.states.approach import approach_of_drives
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.reduction.states.references import reference_states
from stiffcal.reduction.states.row_sigma import stated_row_by_row, with_own_sigma, with_typical_sigma

STANDARD_GRAVITY = 9.80665  # m/s², where the robot file's gravity has no length


def load_states(raw_states: RawStates, manifest: Manifest, chain: Chain, setup: MeasurementSetup) -> LoadStates:
    """Turn raw states into load states: places in base axes, wrenches in the set-up's axes, references marked.

    Raises
    ------
    InputError
        Joint angles or loads are missing, a run is not in the manifest, a reference does not exist.
    """
    n = len(raw_states.run)
    names = list(dict.fromkeys(raw_states.run))
    manifest_runs = {run.id: run for run in manifest.runs}
    unknown = [name for name in names if manifest_runs and name not in manifest_runs]
    if unknown:
        raise InputError.at(
            FaultCode.RUN_UNKNOWN,
            "campaign.toml", "[[runs]]", f"the data contains run {unknown[0]!r}, which is not listed",
            "add it to [[runs]], or omit [[runs]] if a table has a run column",
        )  # fmt: skip
    number_of = {name: k for k, name in enumerate(names)}
    run = np.array([number_of[name] for name in raw_states.run], dtype=np.int64)
    tracker_of_run = trackers_of_runs(manifest)
    tracker = np.array([tracker_of_run.get(name, 0) for name in raw_states.run], dtype=np.int64)
    position, rotation, markers_measured = _poses(raw_states, manifest, setup, tracker)
    deflection = _deflections(raw_states, manifest, setup, tracker)
    sigma = stated_row_by_row(
        raw_states, setup, tracker, np.where(np.isfinite(deflection[:, :, :3]), deflection[:, :, :3], position)
    )
    of_run = {name: measure_of(entry.experiment) for name, entry in manifest_runs.items()}
    absolute = np.array(
        [of_run.get(name) is StateMeasure.PLACE for name in raw_states.run],
        dtype=np.bool_,
    )
    sigma = with_own_sigma(sigma, absolute, setup.target_names, sigma_of_places(manifest))
    setup = with_typical_sigma(setup, sigma, absolute)
    lengths = _side_by_side(raw_states, [f"lengths.{rod}" for rod in setup.rod_names])
    displacement = _side_by_side(raw_states, [f"displacement.{gauge.name}" for gauge in setup.gauges])
    measured = _anything_measured(position, rotation, deflection, lengths, displacement)
    set_aside = _with_not_measured(raw_states.set_aside, measured, run)
    codes, texts = set_aside_columns(set_aside)
    joints = _joint_angles(raw_states, chain, manifest_runs)
    states = LoadStates(
        runs=tuple(_run_info(name, manifest_runs.get(name), manifest, tracker_of_run.get(name, 0)) for name in names),
        run=run,
        time=raw_states.time,
        hold=raw_states.hold,
        joints=joints,
        wrench=_wrench_of_places(_wrench(raw_states, chain), absolute, raw_states, setup.tared),
        position=position,
        rotation=rotation,
        deflection=deflection,
        reference=np.zeros(n, dtype=np.bool_),
        temperature=raw_states.signals.get("temperature", np.zeros((n, 0))),
        row=raw_states.number,
        n_readings=raw_states.n_readings,
        wrench_scatter=raw_states.scatter.get("wrench", np.full((n, 6), np.nan)),
        position_scatter=_scatter(raw_states, setup, tracker),
        set_aside=texts,
        setup=setup,
        lengths=lengths,
        displacement=displacement,
        markers_measured=markers_measured,
        sigma=sigma,
        motor_sigma=raw_states.signals.get("sigma.motor", np.full((n, 1), np.nan))[:, 0],
        wrench_sigma=raw_states.signals.get("sigma.wrench", np.full((n, 6), np.nan)),
        joint_torque=_torques_at_rest(raw_states, absolute, setup.torque_gain_sigma),
        approach=approach_of_drives(raw_states, joints, absolute, chain, manifest_runs),
        set_aside_code=codes,
    )
    if not states.deflection_given:
        chosen = {name: entry.reference for name, entry in manifest_runs.items()}
        states = replace(states, reference=reference_states(run, names, chosen, states.used))
    states = _loaded_all_the_same(states)
    return _rows_as_runs(states) if states.absolute.any() else states


def _loaded_all_the_same(states: LoadStates) -> LoadStates:
    """Return the states with runs that were to be unloaded, and carry a load, as what they are: loads are checked.

    A load is large next to those of load runs; where no run was to be loaded, what free ones read may be all noise.
    """
    force, moment = (np.linalg.norm(states.wrench[:, part], axis=1) for part in (slice(3), slice(3, 6)))
    load = force if np.nan_to_num(force).any() else moment
    most = np.zeros(len(states.runs))
    np.fmax.at(most, states.run[states.used], load[states.used])
    to_be_loaded = np.array([run.measures is StateMeasure.DISPLACEMENT for run in states.runs], dtype=np.bool_)
    largest = most[to_be_loaded].max(initial=0.0)
    if largest <= 0.0:
        return states
    loaded = most > UNLOADED_SHARE * largest
    runs = list(states.runs)
    for number in np.flatnonzero(loaded).tolist():
        if runs[number].measures is StateMeasure.FRAME:
            runs[number] = replace(runs[number], measures=StateMeasure.DISPLACEMENT)
    return replace(states, runs=tuple(runs))


def _rows_as_runs(states: LoadStates) -> LoadStates:
    """Make each row of an absolute run a run of its own: a place has no reference and shares no offset with others."""
    runs: list[RunInfo] = []
    number = np.empty(len(states), dtype=np.int64)
    absolute = states.absolute
    last = -1
    for k in range(len(states)):
        info = states.runs[int(states.run[k])]
        if absolute[k]:
            runs.append(replace(info, name=f"{info.name} row {states.row[k]}", of=info.name))
        elif states.run[k] != last:
            runs.append(info)
        last = int(states.run[k])
        number[k] = len(runs) - 1
    return replace(states, runs=tuple(runs), run=number, reference=states.reference | absolute)


def _anything_measured(*readings: Floats) -> Booleans:
    """Return (n,) True where one of the readings (n, …) is a number."""
    finite = [np.isfinite(values).any(axis=tuple(range(1, values.ndim))) for values in readings]
    return np.asarray(np.logical_or.reduce(finite))


def _with_not_measured(set_aside: Sequence[SetAside], measured: Booleans, run: Integers) -> list[SetAside]:
    """Set aside the states in which nothing that moves was read, where the same campaign reads it in others of the run.

    Parameters
    ----------
    set_aside : why each state is not used so far.
    measured : (n,) True where anything that moves was read.
    run : (n,) the number of each state's run.
    """
    in_run = np.bincount(run, weights=measured, minlength=int(run.max(initial=-1)) + 1) > 0.0
    single = np.bincount(run) == 1 if run.size else np.zeros(0, dtype=np.bool_)
    missing = ~measured & (in_run[run] | (single[run] & measured.any()))
    reason = SetAside(SetAsideCode.NOT_MEASURED, SetAsideCode.NOT_MEASURED.short_text)
    return [reason if missing[k] and not entry.code else entry for k, entry in enumerate(set_aside)]


def _run_info(name: str, run: Run | None, manifest: Manifest, tracker: int) -> RunInfo:
    if run is None:
        return RunInfo(name, tracker=tracker)
    measures = measure_of(run.experiment)
    sensor = any(manifest.sources[source].wrench is not None for source in run.files)
    return RunInfo(
        name,
        run.experiment,
        run.holdout,
        run.tags,
        run.compensation == "on",
        run.fixture_compliance,
        motor_torque=measures is StateMeasure.MOTOR_ANGLE and not sensor,
        direct=run.approach == "direct",
        tracker=tracker,
        measures=measures,
    )


def _joint_angles(raw_states: RawStates, chain: Chain, manifest_runs: Mapping[str, Run]) -> Floats:
    """Return (n, L) logged angles, rad (prismatic joints: m): from the log, else the run's nominal ones."""
    n_logged = chain.coupling.shape[1]
    joints = raw_states.signals.get("joints", np.full((len(raw_states.run), n_logged), np.nan)).copy()
    for k, name in enumerate(raw_states.run):
        run = manifest_runs.get(name)
        if run is not None and run.joints_deg is not None and not np.isfinite(joints[k]).all():
            joints[k] = chain.from_printed(np.array(run.joints_deg))
    missing = np.flatnonzero(~np.isfinite(joints).all(axis=1))
    if missing.size:
        raise InputError.at(
            FaultCode.SIGNAL_MISSING, "campaign.toml", f"run {raw_states.run[int(missing[0])]}", "no joint angles",
            "log them, or write joints_deg = [0.0, -30.0, 90.0], say, one per joint, for the run",
        )  # fmt: skip
    return joints


def _torques_at_rest(raw_states: RawStates, absolute: Booleans, gain_sigma: float) -> Floats:
    """Return (n, L) the motors' torques in absolute runs, N·m; no columns where they do not count."""
    torque = raw_states.signals.get("joints.torque")
    if torque is None or gain_sigma <= 0.0 or not absolute.any():
        return np.zeros((len(raw_states.run), 0))
    return np.where(absolute[:, None], torque, np.nan)


def _wrench(raw_states: RawStates, chain: Chain) -> Floats:
    """Return (n, 6) on the robot: as measured, else the weight of a known mass, else none."""
    n = len(raw_states.run)
    if "wrench" in raw_states.signals:
        return raw_states.signals["wrench"]
    if "mass" in raw_states.signals:
        gravity = chain.gravity if np.any(chain.gravity) else np.array([0.0, 0.0, -STANDARD_GRAVITY])
        return np.concatenate([raw_states.signals["mass"] * gravity, np.zeros((n, 3))], axis=1)
    return np.zeros((n, 6))


def _wrench_of_places(wrench: Floats, absolute: Booleans, raw_states: RawStates, tared: str) -> Floats:
    """Return the wrenches (n, 6) with those of absolute runs that log none as no load.

    Raises
    ------
    InputError : rows of absolute runs read a wrench that was zeroed at a reference, which they have not.
    """
    if not absolute.any() or absolute.all():
        return wrench
    names = np.array(raw_states.run)
    read = set(names[np.isfinite(wrench).any(axis=1)].tolist())
    without = absolute & np.array([name not in read for name in names], dtype=np.bool_)
    wrench = np.where(without[:, None], 0.0, wrench)
    loaded = np.flatnonzero(absolute & (np.nan_to_num(wrench) != 0.0).any(axis=1))
    if loaded.size and tared != "no":
        k = int(loaded[0])
        raise InputError.at(
            FaultCode.KEY_CONFLICT, "campaign.toml", f"run {raw_states.run[k]}, row {int(raw_states.number[k])}",
            f'a load is read in an absolute run, which has no reference at which the wrench was zeroed ("{tared}")',
            'write tared = "no" if the reading is the total load, or leave its columns empty in absolute runs',
        )  # fmt: skip
    return wrench


def _poses(
    raw_states: RawStates, manifest: Manifest, setup: MeasurementSetup, tracker: Integers
) -> tuple[Floats, Floats, Booleans]:
    """Return positions (n, B, 3) and rotations (n, B, 3, 3) in base axes, and (n, B, K) which points were measured."""
    n, n_targets = len(raw_states.run), len(setup.targets)
    position = np.full((n, n_targets, 3), np.nan)
    rotation = np.full((n, n_targets, 3, 3), np.nan)
    most = max((len(markers.names) for markers in setup.markers if markers is not None), default=0)
    markers_measured = np.zeros((n, n_targets, most), dtype=np.bool_)
    poses: dict[str, Pose] = {}
    for source in manifest.sources.values():
        poses |= source.body_poses()
    for b, body in enumerate(setup.target_names):
        pose = poses.get(body)
        if pose is None:
            continue
        markers = setup.markers[b] if b < len(setup.markers) else None
        if markers is not None:
            marker_places = np.stack([raw_states.signals[f"marker.{body}.{name}"] for name in markers.names], axis=1)
            measured, turned, shows = fitted_poses(markers, marker_places)
            markers_measured[:, b, : shows.shape[1]] = shows
        else:
            missing = np.full((n, 3), np.nan)
            measured = raw_states.signals.get(f"position.{body}", missing)
            quaternion = raw_states.signals.get(f"quaternion.{body}")
            turned = np.full((n, 3, 3), np.nan) if quaternion is None else rotation_from_quaternion(quaternion)
        for read, placed in each_tracker(setup.trackers, tracker):
            position[read, b] = measured[read] @ placed[:3, :3].T + placed[:3, 3]
            rotation[read, b] = placed[:3, :3] @ turned[read]
    return position, rotation, markers_measured


def _deflections(raw_states: RawStates, manifest: Manifest, setup: MeasurementSetup, tracker: Integers) -> Floats:
    """Return (n, B, 6) displacements already taken, base axes; NaN where there are none."""
    deflection = np.full((len(raw_states.run), len(setup.targets), 6), np.nan)
    if "translation" not in raw_states.signals:
        return deflection
    body = next(source.deflection.body for source in manifest.sources.values() if source.deflection is not None)
    b = setup.target_names.index(body)
    for read, placed in each_tracker(setup.trackers, tracker):
        deflection[read, b, :3] = raw_states.signals["translation"][read] @ placed[:3, :3].T
        if "rotation" in raw_states.signals:
            deflection[read, b, 3:] = raw_states.signals["rotation"][read] @ placed[:3, :3].T
    return deflection


def _side_by_side(raw_states: RawStates, signals: Sequence[str]) -> Floats:
    """Return (n, c) of signals of one channel each; NaN where a run does not log one."""
    nothing = np.full((len(raw_states.run), 1), np.nan)
    columns = [raw_states.signals.get(signal, nothing) for signal in signals]
    return np.concatenate(columns, axis=1) if columns else np.zeros((len(raw_states.run), 0))


def _scatter(raw_states: RawStates, setup: MeasurementSetup, tracker: Integers) -> Floats:
    """Return (n, B, 3) standard deviation of single positions within the hold, base axes.

    Noise is taken as alike along the instrument's axes as far as turning goes: variances are turned, not covariances.
    """
    scatter = np.full((len(raw_states.run), len(setup.targets), 3), np.nan)
    for b, body in enumerate(setup.target_names):
        name = f"position.{body}"
        if name in raw_states.scatter:
            for read, placed in each_tracker(setup.trackers, tracker):
                scatter[read, b] = np.sqrt(raw_states.scatter[name][read] ** 2 @ (placed[:3, :3] ** 2).T)
    return scatter
