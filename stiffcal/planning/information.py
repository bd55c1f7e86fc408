"""What a run would bring: the information of a pose with its load steps, from the model's own regressors and noise.

A run is one pose: it is read unloaded, then at every load step, then unloaded again. As in the fit (`identification`)
displacements count from a free offset of the run, the noise of the wrench is carried through the model, and the
observation matrix is that of a Gauss-Newton step about the balanced shape. Of absolute places a run is one pose read
once, under the robot's own weight and perhaps a payload: no offset, and no unloaded reading.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.campaign.found.experiment_kinds import measure_of
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import Observations, derivatives, observe
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import LoadStates, MeasurementSetup, RunInfo, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import ParameterRole
from stiffcal.reduction.loads.motion import gauge_directions

RunKind: TypeAlias = Literal["load", "absolute", "clamped"]
# Unloaded readings of a run: before the load steps, and after them.
UNLOADED_READINGS: dict[RunKind, tuple[int, int]] = {"load": (1, 1), "absolute": (0, 0), "clamped": (1, 0)}
# Runs whose regressors are made together: memory stays small whatever the number of candidates.
RUNS_AT_ONCE = 500


@dataclass(frozen=True)
class RunInformation:
    """What each of N runs would bring on p parameters."""

    names: tuple[str, ...]
    """Full names of the p parameters, as in the fit."""
    values: Floats
    """(p,) what the law multiplies with: of a stiffness its inverse."""
    factors: Floats
    """(N, r, p) AᵀA is the run's information on the parameters relative to their values; of a parameter whose value is
    zero, relative to its typical size.
    """
    scale: Floats
    """(p,) the value, or typical size, that ``factors`` are relative to."""
    typical: Floats
    """(p,) the parameters' typical sizes, in the same unit."""
    nonlinear: Booleans
    """(p,) True for nonlinear parameters."""
    further: Floats
    """(N, r, q) the same readings' change by whatever else was asked for; q is 0 where nothing was."""


def information_of_runs(
    robot: CompliantRobot,
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    noise: Noise,
    with_rotation: bool,
    fixed: frozenset[str] = frozenset(),
    further: Callable[[Observations], Floats] | None = None,
    kind: RunKind = "load",
    turn: Floats | None = None,
) -> RunInformation:
    """Return what runs would bring.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    joints : (N, L) logged joint angles of the runs, rad.
    wrench : (N, K, 6) N and N·m, the K load steps of each run, axes and point of the set-up.
    setup : where the instruments sit.
    noise : of one load state.
    with_rotation : the targets' orientations are measured too.
    fixed : full names of parameters that are not to be identified.
    further : returns (q, m, n) changes of the readings that are carried through in the same way, as
        `identification.fitting.geometry.geometry_columns`.
    kind : "absolute": places are read, each pose once: the K load steps are read as they are, and nothing unloaded;
        "clamped": angles of driven motors, after one unloaded reading.
    turn : (N, K, L) rad, how far logged joints' motors are driven at the load steps of clamped runs.

    Raises
    ------
    NoBalanceError : a load is more than the springs hold.
    """
    columns = free_columns(robot, fixed)
    specs = [robot.placed[column.placed].effect.spec(column.symbol) for column in columns]
    values = np.array(
        [
            robot.placed[column.placed].amplitude(column.symbol)
            if column.role.value != "shape"
            else robot.placed[column.placed].shape()[column.symbol]
            for column in columns
        ]
    )
    typical = np.array([abs(spec.amplitude_of(spec.typical)) for spec in specs])
    sized = np.array([counts_from_nominal(robot.placed[column.placed]) for column in columns])
    scale = np.where((values != 0.0) & ~sized, np.abs(values), typical)
    names = tuple(robot.placed[column.placed].parameter_name(column.symbol) for column in columns)
    nonlinear = np.array([column.role is ParameterRole.NONLINEAR for column in columns], dtype=np.bool_)
    n_runs = len(wrench)
    blocks = []
    for first in range(0, n_runs, RUNS_AT_ONCE):
        rows = slice(first, min(first + RUNS_AT_ONCE, n_runs))
        driven = None if turn is None else turn[rows]
        data = observations_of_runs(
            robot, joints[rows], wrench[rows], setup, with_rotation, kind, driven, reads_along_lines(noise, setup)
        )
        more = further(data) if further is not None else np.zeros((0, *data.measured.shape))
        # the unloaded readings belong to the run, whose offset the fit will find
        about = LoadRows.about(robot, replace(data, free_offset=kind != "absolute"), columns, noise)
        stack = np.concatenate([about.derivative * scale[:, None, None], more])
        count = rows.stop - rows.start
        per_run = about.space.rows(stack).reshape(len(stack), len(data.measured), count, -1)
        # (N, m K, q): readings of a run below each other
        blocks.append(np.moveaxis(per_run, (2, 3, 1, 0), (0, 1, 2, 3)).reshape(count, -1, len(stack)))
    p, factors = len(columns), np.concatenate(blocks)
    return RunInformation(names, values, factors[:, :, :p], scale, typical, nonlinear, factors[:, :, p:])


def reads_along_lines(noise: Noise, setup: MeasurementSetup) -> bool:
    """Return whether displacement is read by devices along their lines alone: no reading in space has a noise."""
    return bool(setup.gauges) and noise.translation == 0.0 and noise.gauge > 0.0


def counts_from_nominal(placed: PlacedEffect) -> bool:
    """Return whether an effect's parameters are small differences from the robot file or the manifest.

    For geometry and frames an uncertainty relative to the value is meaningless: it is taken relative to their typical
    size.
    """
    return placed.place.kind == "frames" or placed.changes_geometry


def observations_of_runs(
    robot: CompliantRobot,
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    with_rotation: bool,
    kind: RunKind = "load",
    turn: Floats | None = None,
    along_lines: bool = False,
) -> Observations:
    """Return readings of the runs, all zero: what they would be weighed and compared with, not their values.

    Parameters
    ----------
    robot, joints, wrench, setup, with_rotation, kind, turn : as in `information_of_runs`.
    along_lines : of the set-up's devices the one whose line is nearest to the force's reads, and nothing else.
    """
    n_runs, n_steps = wrench.shape[:2]
    first, last = UNLOADED_READINGS[kind]
    per_run = first + n_steps + last
    loads, angles = np.zeros((n_runs, per_run, 6)), np.repeat(joints[:, None], per_run, axis=1)
    loads[:, first : first + n_steps] = wrench
    if turn is not None:
        angles[:, first : first + n_steps] += turn
    n, targets = n_runs * per_run, len(setup.targets)
    deflection = np.full((n, targets, 6), np.nan)
    position, rotation = np.full((n, targets, 3), np.nan), np.full((n, targets, 3, 3), np.nan)
    if kind == "absolute":
        position[:] = 0.0
        if with_rotation:
            rotation[:] = np.eye(3)
    elif kind == "load" and not along_lines:
        deflection[:, :, : 6 if with_rotation else 3] = 0.0
    reference = np.zeros((n_runs, per_run), dtype=np.bool_)
    reference[:, 0] = kind != "absolute"
    numbers, measures = np.arange(n), measure_of(kind)
    states = LoadStates(
        runs=tuple(RunInfo(f"run {number + 1}", experiment=kind, measures=measures) for number in range(n_runs)),
        run=np.repeat(np.arange(n_runs), per_run),
        time=np.full(n, np.nan),
        hold=np.full(n, np.nan),
        joints=angles.reshape(n, -1),
        wrench=loads.reshape(n, 6),
        position=position,
        rotation=rotation,
        deflection=deflection,
        reference=reference.reshape(n),
        temperature=np.zeros((n, 0)),
        row=numbers + 1,
        n_readings=np.ones(n, dtype=np.int64),
        wrench_scatter=np.full((n, 6), np.nan),
        position_scatter=np.full((n, targets, 3), np.nan),
        set_aside=np.full(n, "", dtype=np.str_),
        setup=replace(setup, rods=(), beams=(), gauges=setup.gauges if along_lines else (), markers=()),
    )
    return observe(_read_by_nearest_device(states, robot.chain) if along_lines else states, robot.chain)


def _read_by_nearest_device(states: LoadStates, chain: Chain) -> LoadStates:
    """Return the states, each run read by the device whose line is nearest to that of its largest force."""
    angles = chain.model_angles(states.joints)
    force = np.einsum("nab,nb->na", attached_poses(chain, angles, states.setup.wrench_axes)[1], states.wrench[:, :3])
    along = np.abs(np.einsum("nga,na->ng", gauge_directions(states, chain), force))
    reading = np.full(along.shape, np.nan)
    for members in members_of(states.run):
        reading[members, int(np.argmax(along[members].max(axis=0)))] = 0.0
    return replace(states, displacement=reading)


def prediction_rows(
    robot: CompliantRobot,
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    scale: Floats,
    fixed: frozenset[str] = frozenset(),
    kind: RunKind = "load",
) -> Floats:
    """Return (3 n, p): the derivative of the first target's deflection by the parameters relative to ``scale``, m.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    joints : (n, L) logged joint angles, rad.
    wrench : (n, 6) loads there.
    setup : where the instruments sit.
    scale : (p,) of `RunInformation`.
    fixed : full names of parameters that are not to be identified.
    kind : "absolute": of the first target's place in the tracker's frame in place of its deflection.
    """
    columns = free_columns(robot, fixed)
    setup = replace(setup, targets=setup.targets[:1], target_names=setup.target_names[:1])
    kind = "absolute" if kind == "absolute" else "load"
    data = observations_of_runs(robot, joints, wrench[:, None], setup, False, kind)
    first, last = UNLOADED_READINGS[kind]
    loaded = derivatives(robot, data, columns)[:, :, first :: 1 + first + last]
    return np.asarray((loaded * scale[:, None, None]).reshape(len(columns), -1).T)
