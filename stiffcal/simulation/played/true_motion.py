"""Playing a campaign: where every frame of the robot really is along each run's load path.

The robot is `stiffcal.model.balance.equilibrium`, solved in the holds and at a few loads on every ramp; in between,
places are interpolated in proportion to the load. A ramp moves the target by some 0.5 mm; what the straight line
between two balances a third of that apart leaves out is the curvature of the law over it, nanometres on a smooth law.

Another robot may answer in its place (`RestSolver`): a physics engine without our laws, or a real one's record.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.rotations import rotation_from_vector, vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import NoBalanceError, solve_balance
from stiffcal.model.effect import Observed, ParameterRole, StateOrder
from stiffcal.simulation.played.correction import Correction
from stiffcal.simulation.played.cycles import LoadProgram
from stiffcal.simulation.played.places import Places
from stiffcal.simulation.played.side_constraint import SideConstraintError, balance_with_side_constraint
from stiffcal.simulation.settings import FILE_NAME, Loads

_BASE = Attachment(0, np.eye(4))


@dataclass(frozen=True)
class PlannedRun:
    """One run to be played."""

    name: str
    """The run's id."""
    joints: Floats
    """(L,) logged joint angles, rad."""
    program: LoadProgram
    """What loads it sets, when."""
    loads: Loads
    """The settings they were drawn from."""
    load_point: Attachment
    """Where the load acts."""
    start_s: float
    """s on the campaign's true clock: the run's first hold."""
    warming_K_per_hour: float = 0.0
    """How fast everything warms up, from the campaign's start."""
    start_K: float = np.nan
    """The temperature at the campaign's start; NaN where the run logs none."""

    def warmer(self, time: Floats) -> Floats:
        """Return (n,) K above the temperature of the campaign's start, at times (n,) s from the run's start."""
        return np.asarray(self.warming_K_per_hour * (self.start_s + time) / 3600.0)

    def kelvin(self, time: Floats) -> Floats:
        """Return (n,) K the temperature at the same times, NaN where none is logged."""
        return np.asarray(self.start_K + self.warmer(time))


@dataclass(frozen=True)
class TrueRun:
    """One run as it really was: frames along the load path."""

    planned: PlannedRun
    """What was played."""
    node: Floats
    """(s,) path coordinates of the balances that were solved, rising."""
    position: Mapping[str, Floats]
    """Frame name to (s, 3), m, base axes."""
    turn: Mapping[str, Floats]
    """Frame name to (s, 3), rotation vector of R R_0ᵀ, rad, base axes."""
    unloaded: Mapping[str, Floats]
    """Frame name to (4, 4) base_from_frame at the run's start."""
    nodes: Floats | None = None
    """(s, 2J + 2, 6) the nodes' own displacements since the run's start, node axes, m and rad; None where the robot
    that answers does not return them. Rods on links measure these.
    """
    correction: Correction | None = None
    """What a correcting controller adds over time; None where none corrects."""
    wrench: Floats | None = None
    """(s, 6) what really acts at the load point where the program alone does not say it: a guided tool's side force
    too; N and N·m, base axes. None: the program's.
    """

    def wrench_at(self, path: Floats) -> Floats:
        """Return (n, 6) what acts at path coordinates, N and N·m, base axes, about the load point."""
        return self.planned.program.wrench_at(path) if self.wrench is None else self.between(self.wrench, path)

    def position_at(self, frame: str, path: Floats) -> Floats:
        """Return (n, 3) the frame's origin in base axes at path coordinates, m; without corrections."""
        return self.between(self.position[frame], path)

    def rotation_at(self, frame: str, path: Floats) -> Floats:
        """Return (n, 3, 3) base_from_frame rotation at path coordinates; without corrections."""
        turn = rotation_from_vector(self.between(self.turn[frame], path))
        return np.asarray(turn @ self.unloaded[frame][:3, :3])

    def node_at(self, node: int, path: Floats) -> Floats | None:
        """Return (n, 6) a node's own displacement since the run's start; None where it is not known."""
        return None if self.nodes is None else self.between(self.nodes[:, node], path)

    def between(self, value: Floats, path: Floats) -> Floats:
        """Return (n, …) what is known at the solved places, (s, …), at path coordinates."""
        after = np.clip(np.searchsorted(self.node, path, side="left"), 1, self.node.size - 1)
        step = self.node[after] - self.node[after - 1]
        share = np.clip((path - self.node[after - 1]) / step, 0.0, 1.0)[:, None]
        return np.asarray(value[after - 1] * (1.0 - share) + value[after] * share)


class RestSolver(Protocol):
    """A robot as an observer meets it: given loads in the order in which they act, it returns where it rests."""

    def __call__(self, joints: Floats, wrench: Floats, setup: MeasurementSetup, order: StateOrder) -> Places:
        """Return the places of the set-up's targets.

        Parameters
        ----------
        joints : (n, J) model joint angles, rad.
        wrench : (n, 6) N and N·m on the robot, in the set-up's wrench axes
            about its wrench point.
        setup : what is mounted on the flange, where the load acts, which frames are looked at.
        order : runs and times of the states; each run starts without any load.
        """
        ...


@dataclass(frozen=True)
class _Nodes:
    """Path coordinates at which one run is solved, and which of them share a balance."""

    path: Floats
    solved: Integers  # (s,) number of the balance, from 0
    first: Integers  # (b,) index of the first node of each balance


def solve_true_runs(
    robot: CompliantRobot,
    planned_runs: Sequence[PlannedRun],
    frames: Mapping[str, Attachment],
    tool: ToolWeight,
    settle: RestSolver | None = None,
    commanded_change: Mapping[str, Floats] | None = None,
) -> list[TrueRun]:
    """Solve all runs in one batch.

    Parameters
    ----------
    robot : chain and effects with values.
    planned_runs : the runs.
    frames : the frames that instruments look at, where they really are.
    tool : what is mounted on the flange.
    settle : returns where the robot comes to rest; None: the exact balance of ``robot``. Effects of observation
        (drift, a slip) are ``robot``'s in either case.
    commanded_change : run to (s, L) rad, by how much a controller moves the joints at each solved place.

    Raises
    ------
    InputError
        the robot does not hold the load, or no side force is found that agrees with a guide.
    """
    refuse_setup_effects(robot)
    names = list(frames)
    true_run = []
    # One batch for each load point: it is part of the set-up.
    for point in dict.fromkeys(planned.loads.point for planned in planned_runs):
        group = [planned for planned in planned_runs if planned.loads.point == point]
        nodes = [_nodes_of(planned) for planned in group]
        joints = [_joints_of(planned, visited, commanded_change) for planned, visited in zip(group, nodes, strict=True)]
        wrench = [
            planned.program.wrench_at(visited.path[visited.first])
            for planned, visited in zip(group, nodes, strict=True)
        ]
        batch = _LoadPointBatch(group, nodes, np.concatenate(joints), frames, tool)
        solve = partial(_solve, robot, batch, settle=settle or _exact_balance(robot))
        stiffness = [planned.loads.guide_N_per_m for planned in group]
        sizes, at = [visited.first.size for visited in nodes], names.index(point)
        try:
            places, acting = balance_with_side_constraint(
                np.concatenate(wrench), np.repeat(stiffness, sizes), sizes, at, solve
            )
        except SideConstraintError as error:
            raise InputError.at(
                FaultCode.NO_CONVERGENCE, FILE_NAME, f'runs "{group[error.run].name}": loads.guide_N_per_m', str(error),
                "lower guide_N_per_m, or take effects with play or friction out of model.toml",
            ) from None  # fmt: skip
        start = 0
        for planned, visited in zip(group, nodes, strict=True):
            stop = start + visited.first.size
            run = _slice_run(planned, visited, places, slice(start, stop), names)
            if planned.loads.guide_N_per_m > 0.0:
                run = replace(run, wrench=acting[start:stop][visited.solved])
            true_run.append(run)
            start = stop
    order = {planned.name: number for number, planned in enumerate(planned_runs)}
    return sorted(true_run, key=lambda run: order[run.planned.name])


@dataclass(frozen=True)
class ToolWeight:
    """Mass on the flange, kg, and its centre in the flange frame, m."""

    mass: float
    com: Floats


def _nodes_of(planned: PlannedRun) -> _Nodes:
    """Choose where on its path a run is solved: in each hold, and at equal steps of load on each ramp."""
    path: list[float] = []
    solved: list[int] = []
    balance = -1
    within = planned.loads.hold_points
    ramp = planned.loads.ramp_points
    for hold in range(len(planned.program)):
        if within == 1:
            balance += 1
            path += [2.0 * hold, 2.0 * hold + 1.0]
            solved += [balance, balance]
        else:
            # denser at the hold's start, where what creeps is fastest
            for share in np.linspace(0.0, 1.0, within) ** 2:
                balance += 1
                path.append(2.0 * hold + float(share))
                solved.append(balance)
        if hold + 1 < len(planned.program):
            for k in range(1, ramp + 1):
                balance += 1
                path.append(2.0 * hold + 1.0 + k / (ramp + 1))
                solved.append(balance)
    numbers = np.array(solved, dtype=np.int64)
    first = np.flatnonzero(np.concatenate([[True], np.diff(numbers) > 0])).astype(np.int64)
    return _Nodes(np.array(path), numbers, first)


def _joints_of(planned: PlannedRun, nodes: _Nodes, commanded_change: Mapping[str, Floats] | None) -> Floats:
    """Return (b, L) the logged angles at which each balance of a run is solved, rad."""
    joints = np.repeat(planned.joints[None], nodes.first.size, axis=0)
    return joints if commanded_change is None else joints + commanded_change[planned.name][nodes.first]


@dataclass(frozen=True)
class _LoadPointBatch:
    """Runs with one load point: what is solved, at which logged angles (b, L), and what is looked at."""

    planned_runs: Sequence[PlannedRun]
    nodes: Sequence[_Nodes]
    logged: Floats
    frames: Mapping[str, Attachment]
    tool: ToolWeight


def _solve(robot: CompliantRobot, batch: _LoadPointBatch, wrench: Floats, settle: RestSolver) -> Places:
    """Find the places in several runs with one load point under wrenches (b, 6); observation effects included."""
    setup = MeasurementSetup(
        wrench_axes=_BASE,
        wrench_point=batch.planned_runs[0].load_point,
        targets=tuple(batch.frames.values()),
        target_names=tuple(batch.frames),
        moments_measured=True,
        tool_mass=batch.tool.mass,
        tool_com=batch.tool.com,
    )
    logged = batch.logged
    order = _order_of(robot, batch.planned_runs, batch.nodes)
    places = settle(robot.chain.model_angles(logged), wrench, setup, order)
    shift = observed_shift(robot, places.displacement, order)
    turned = rotation_from_vector(shift[..., 3:]) @ places.rotation
    return Places(places.position + shift[..., :3], turned, places.displacement + shift, places.nodes)


def _exact_balance(robot: CompliantRobot) -> RestSolver:
    """Return the exact balance as a `RestSolver`."""

    def settle(joints: Floats, wrench: Floats, setup: MeasurementSetup, order: StateOrder) -> Places:
        try:
            balance = solve_balance(robot, joints, wrench, setup, order)
        except NoBalanceError as error:
            raise error.of_load(FILE_NAME, "loads", "lower max_force_N, or stiffen model.toml") from None
        return Places(balance.target_position, balance.target_rotation, balance.displacement, balance.nodes)

    return settle


def _order_of(robot: CompliantRobot, planned_runs: Sequence[PlannedRun], nodes: Sequence[_Nodes]) -> StateOrder:
    """Return order and times of the balances, for laws with a memory of load or time."""
    run, time, hold, since, kelvin, rise = [], [], [], [], [], []
    for number, (planned, mine) in enumerate(zip(planned_runs, nodes, strict=True)):
        program = planned.program
        path = mine.path[mine.first]
        moment = _time_on(program, path)
        # a hold that is solved once stands for its middle
        if planned.loads.hold_points == 1:
            holding = path % 2.0 == 0.0
            middle = 0.5 * (program.start + program.end)
            moment[holding] = middle[(path[holding] / 2.0).astype(np.int64)]
        which = (path / 2.0).astype(np.int64)
        in_hold = path - 2.0 * which <= 1.0
        run.append(np.full(path.size, number, dtype=np.int64))
        time.append(planned.start_s + moment)
        hold.append(np.where(in_hold, moment - program.start[which], 0.0))
        reference = 0.5 * (program.start[:1] + program.end[:1])
        since.append(moment - reference)
        kelvin.append(planned.kelvin(moment))
        rise.append(kelvin[-1] - planned.kelvin(reference))
    size = sum(positions.size for positions in run)
    return StateOrder(
        run=np.concatenate(run),
        time=np.concatenate(time),
        hold=np.concatenate(hold),
        motor=np.zeros((robot.chain.n_joints, size)),
        temperature=np.concatenate(rise),
        since_reference=np.concatenate(since),
        kelvin=np.concatenate(kelvin),
    )


def _time_on(program: LoadProgram, path: Floats) -> Floats:
    """Return when a run is at path coordinates, s from its start (the path never runs back)."""
    fine = np.unique(
        np.concatenate(
            [program.start, program.end]
            + [np.linspace(a, b, 65) for a, b in zip(program.end[:-1], program.start[1:], strict=True)]
        )
    )
    return np.asarray(np.interp(path, program.path(fine), fine))


def observed_shift(robot: CompliantRobot, displacement: Floats, order: StateOrder) -> Floats:
    """Return (n, B, 6) what observation effects (drift, a slip) add to the places of the targets."""
    observed = Observed(np.moveaxis(displacement, 0, -1), order)
    total = np.zeros_like(observed.displacement)
    for placed_effect in robot.placed:
        for symbol, column in placed_effect.observation_columns(observed).items():
            total = total + placed_effect.amplitude(symbol) * column
    return np.moveaxis(total, -1, 0)


def refuse_setup_effects(robot: CompliantRobot) -> None:
    """Raise where the model holds turned or shifted frames: those are given in simulate.toml, where nothing can mix."""
    for placed_effect in robot.placed:
        if placed_effect.specs(ParameterRole.SETUP):
            name = placed_effect.effect.name
            raise InputError.at(
                FaultCode.SIMULATION_UNSUPPORTED,
                "model.toml",
                f'effects "{name}"',
                "a frame error is not an effect of the robot, and cannot be simulated from model.toml",
                "remove it and write the true position of the frame in simulate.toml, [frames.NAME]",
            )


def _slice_run(planned: PlannedRun, nodes: _Nodes, places: Places, rows: slice, names: Sequence[str]) -> TrueRun:
    """Take one run out of a batch."""
    position, turn, unloaded = {}, {}, {}
    for body, name in enumerate(names):
        positions, rotations = places.position[rows, body], places.rotation[rows, body]
        start = np.eye(4)
        start[:3, :3], start[:3, 3] = rotations[0], positions[0]
        position[name] = positions[nodes.solved]
        turn[name] = vector_from_rotation(rotations @ rotations[0].T)[nodes.solved]
        unloaded[name] = start
    if places.nodes is None:
        return TrueRun(planned, nodes.path, position, turn, unloaded)
    own = places.nodes[rows]
    return TrueRun(planned, nodes.path, position, turn, unloaded, (own - own[0])[nodes.solved])
