"""Setting the scene: the robot with every parameter with a value, the frames where they really are, the runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.found.experiment_kinds import measure_of
from stiffcal.campaign.frames.frames import resolve_frames
from stiffcal.campaign.frames.gauges import rods_of
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Frame, Manifest
from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.errors import Fault, raise_faults
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rods import rod_matrix
from stiffcal.model.assembled.assembly import compliant_robot
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.campaign_effects import model_effects
from stiffcal.model.effect import link_node
from stiffcal.simulation.kinds import RunSetup, run_simulation
from stiffcal.simulation.played.cycles import load_program
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight
from stiffcal.simulation.settings import FILE_NAME, SimulationSettings, TrueRobot
from stiffcal.simulation.written.instruments import frames_measured_by
from stiffcal.simulation.written.recording import Stream, stream


def robot_with_values(campaign: Campaign, errors: TrueRobot | None = None, seed: int = 0) -> CompliantRobot:
    """Return the robot as the campaign's model file describes it.

    Parameters
    ----------
    campaign : the folder.
    errors : of `simulate.toml`: how large geometry errors are that model.toml leaves without a value; None: none drawn.
    seed : for these.

    Raises
    ------
    InputError
        an effect or place is not known, or a parameter has no value: one fault each.
    """
    robot = compliant_robot(campaign.chain, campaign.model, model_effects(campaign))
    if errors is not None:
        robot = _with_drawn_geometry(robot, errors, seed)
    raise_faults(
        [
            Fault(
                FaultCode.KEY_MISSING,
                MODEL_FILE,
                f"parameters.{placed_effect.parameter_name(spec.symbol)}",
                "a robot that is to be simulated needs a value here",
                f"write {_value_line(placed_effect.parameter_name(spec.symbol), spec.typical)} ({spec.unit})",
            )
            for placed_effect in robot.placed
            for spec in placed_effect.effect.parameters
            if spec.symbol not in placed_effect.values
        ]
    )
    return robot


def _with_drawn_geometry(robot: CompliantRobot, errors: TrueRobot, seed: int) -> CompliantRobot:
    """Return the robot with values drawn for parameters of geometry (with an assembly tolerance) that have none."""
    rng, size = stream(seed, Stream.GEOMETRY), {"m": errors.geometry_error_m, "rad": errors.geometry_error_rad}
    drawn = {}
    for placed_effect in robot.placed:
        for spec in placed_effect.effect.parameters:
            if spec.tolerance is None or spec.symbol in placed_effect.values or not size.get(spec.unit):
                continue
            drawn[placed_effect.parameter_name(spec.symbol)] = size[spec.unit] * float(rng.standard_normal())
    return robot.with_values(drawn)


def true_frames(campaign: Campaign, settings: SimulationSettings) -> dict[str, Attachment]:
    """Return every frame that an instrument or a load needs, where it really is.

    Raises
    ------
    InputError
        a frame that the manifest leaves to be estimated has no true place, or a name is unknown.
    """
    manifest = campaign.manifest
    faults = [
        Fault(
            FaultCode.FRAME_UNKNOWN,
            FILE_NAME,
            f"frames.{name}",
            "campaign.toml has no such frame",
            "correct the name, or take it out",
        )
        for name in settings.frames
        if name not in manifest.frames
    ]
    faults += [
        Fault(
            FaultCode.FRAME_UNSUITABLE,
            FILE_NAME,
            f"frames.{name}",
            "campaign.toml leaves this frame to be estimated: the simulation must know where it really is",
            f"add [frames.{name}] with xyz_m and a rotation",
        )
        for name, frame in manifest.frames.items()
        if frame.estimate and name not in settings.frames
    ]
    raise_faults(faults)
    frames = dict(manifest.frames)
    for name, true in settings.frames.items():
        frames[name] = Frame(parent=manifest.frames[name].parent, **true.model_dump(exclude_none=True))
    resolved = resolve_frames(manifest.model_copy(update={"frames": frames}), campaign.chain)
    return {name: resolved[name] for name in _needed(manifest, settings, resolved)}


def _needed(manifest: Manifest, settings: SimulationSettings, known: Mapping[str, Attachment]) -> list[str]:
    """Return the frames that matter, each once; unknown load points and axes are faults."""
    faults = []
    names = ["base"]
    kinds = {run.id: run.experiment for run in manifest.runs}
    for run in settings.runs:
        kind = kinds.get(run.id, "load")
        simulation = run_simulation(kind)
        loads = settings.loads_of(run)
        places: Sequence[tuple[str, str]] = [("loads.point", loads.point), ("loads.axes", loads.axes)]
        if simulation is not None:
            places = simulation.frames(settings.motion_of(kind, run))
        for key, name in places:
            if name not in known:
                place = f'runs "{run.id}": {key}'
                faults.append(
                    Fault(
                        FaultCode.FRAME_UNKNOWN,
                        FILE_NAME,
                        place,
                        f'there is no frame "{name}"',
                        "use one of " + ", ".join(known),
                    )
                )
            names.append(name)
    raise_faults(faults)
    for _, _, signal in manifest.signals():
        names += frames_measured_by(signal)
    return list(dict.fromkeys(names))


def rods_on_links(campaign: Campaign) -> dict[str, tuple[int, Floats]]:
    """Return every rod's link node, and what the rod reads, (7,): of the node's displacement, and per kelvin, m."""
    chain = campaign.chain
    return {
        name: (link_node(chain.beams[rods.link].joint), np.append(row, np.nan_to_num(grown)))
        for rods, beam in rods_of(campaign.manifest, chain)
        for name, row, grown in zip(rods.names, rod_matrix(rods, beam), rods.growth, strict=True)
    }


def tool_weight(manifest: Manifest) -> ToolWeight:
    """Return the mass on the flange."""
    tool = manifest.tool
    return ToolWeight(0.0, np.zeros(3)) if tool is None else ToolWeight(tool.mass_kg, np.array(tool.com_m))


def draw_acts(
    campaign: Campaign, settings: SimulationSettings, frames: Mapping[str, Attachment], seed: int
) -> list[PlannedRun]:
    """Draw the load cycles of all runs, one after the other on the campaign's clock.

    Raises
    ------
    InputError
        a run is not the manifest's, or its pose has the wrong number of joints or is out of their reach.
    """
    _check_runs(campaign, settings)
    listed = {run.id: run for run in campaign.manifest.runs}
    planned_runs: list[PlannedRun] = []
    now = 0.0
    for number, run in enumerate(settings.runs):
        loads = settings.loads_of(run)
        joints = campaign.chain.from_printed(np.array(run.joints_deg))
        now += run.pause_before_s if planned_runs else 0.0
        entry = listed.get(run.id)
        kind, moved = (entry.experiment, entry.moved_joint) if entry is not None else ("load", None)
        simulation = run_simulation(kind)
        if simulation is not None:
            rng = stream(seed, Stream.LOADS, number)
            setup = RunSetup(run, moved, loads, frames, now, campaign.chain, rng)
            planned_runs.append(simulation.plan(settings.motion_of(kind, run), setup))
            now += planned_runs[-1].program.duration
            continue
        angles = campaign.chain.model_angles(joints[None, :])
        axes = attached_poses(campaign.chain, angles, frames[loads.axes])[1][0]
        program = load_program(loads, axes, stream(seed, Stream.LOADS, number))
        if measure_of(kind) is StateMeasure.FRAME:
            program = program.first_hold()
        planned_runs.append(PlannedRun(run.id, joints, program, loads, frames[loads.point], now))
        now += program.duration
    return planned_runs


def _value_line(name: str, value: float) -> str:
    return toml_text.pair(name, {"value": value})


def _check_runs(campaign: Campaign, settings: SimulationSettings) -> None:
    """Raise where manifest and settings name different runs, or a pose cannot be."""
    faults: list[Fault] = []
    planned_names = {run.id for run in settings.runs}
    for run in campaign.manifest.runs:
        if run.id not in planned_names:
            mend = f"add [[runs]] with {toml_text.pair('id', run.id)} and joints_deg"
            faults.append(
                Fault(
                    FaultCode.RUN_UNKNOWN, FILE_NAME, "runs", f'the run "{run.id}" of campaign.toml is not here', mend
                )
            )
    known = {run.id for run in campaign.manifest.runs}
    limits = campaign.chain.printed_positions(campaign.chain.limits.T).T
    for pose in settings.runs:
        place = f'runs "{pose.id}"'
        if known and pose.id not in known:
            faults.append(
                Fault(
                    FaultCode.RUN_UNKNOWN,
                    FILE_NAME,
                    place,
                    "campaign.toml has no such run",
                    "correct the id, or add it there",
                )
            )
        if len(pose.joints_deg) != campaign.chain.coupling.shape[1]:
            count = campaign.chain.coupling.shape[1]
            reason = f"{len(pose.joints_deg)} joint angles for a robot of {count}"
            faults.append(Fault(FaultCode.JOINT_COUNT, FILE_NAME, f"{place}: joints_deg", reason, f"write {count}"))
            continue
        rows = zip(campaign.chain.joint_names, pose.joints_deg, limits, campaign.chain.position_units, strict=True)
        for joint, angle, (low, high), unit in rows:
            if not low <= angle <= high:
                mark = "°" if unit == "deg" else " mm"
                reason = f"{joint} = {angle:g}{mark} is out of its reach, {low:g}{mark} … {high:g}{mark}"
                faults.append(
                    Fault(FaultCode.POSE_UNREACHABLE, FILE_NAME, f"{place}: joints_deg", reason, "correct the angle")
                )
    raise_faults(faults)
