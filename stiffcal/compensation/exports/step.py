"""The correction for one sample, for a controller's loop: joints and force reading in, joint offsets out.

Everything is set up once; a call works in arrays that stand ready, and allocates none. Two shapes of the chain, with
and without the load, are carried side by side; their difference is the deflection, and one Newton step on the chain's
Jacobian makes the joint offsets from it. A sweep takes the wrenches on the shapes that the sweep before has found, the
first ever on the rigid chain, which alone would be the papers' linear form (002, eq. 8). In a loop a load changes
little from one cycle to the next, so that one sweep a call holds the change of the levers too, weight included: within
some 10⁻⁴ of the balance that `targets.correct_joints` solves, and for one cycle within a per cent after a blow. Laws
with a memory (hysteresis) advance once a call; before the first call weight alone has acted.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.exports.chain_pair import ChainPair
from stiffcal.compensation.linear_nodes import linear_nodes, node_chain
from stiffcal.compensation.tool_weight import reading_filter, tool_in_reading
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot

FIRST_SWEEPS = 3


@dataclass(frozen=True)
class StepSettings:
    """How a controller's loop compensates."""

    cycle_s: float = 0.004
    """Time between two calls, s (002: 4 ms; 001: 1 ms)."""
    cutoff_hz: float | None = None
    """Of the filter for the sensor's noise; None: no filter."""
    tool_mass: float = 0.0
    """kg, of what hangs beyond the sensor and is in its reading."""
    tool_com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """(3,) in the flange frame, m."""
    zeroed_at: Floats | None = None
    """(L,) logged angles, rad, at which the sensor read zero with the tool on; None: it was never zeroed."""
    sweeps: int = 1
    """In each call; the first call after a start makes `FIRST_SWEEPS`, as nothing was found before."""
    damping: float = 5e-3
    """Jacobian's directions that move less than this, m/rad or rad/rad, are corrected less and less."""
    largest_correction: float = float(np.radians(2.0))
    """rad, what a joint's offset is cut off at."""
    leave_out: tuple[str, ...] = ()
    """Names of effects that the loop leaves out where they are not proportional to their load."""


class CompensationStep:
    """A robot's compensation, ready for samples.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    setup : where force sensor and target sit; the target is what is kept in place.
    settings : how the loop runs.

    Attributes
    ----------
    offsets : (L,) rad, what the last call returned: to be added to the commanded logged angles.
    deflection : (6,) of the target by the last call's load, base axes, m and rad.
    wrench : (6,) the last call's process wrench: filtered, without the tool's weight.
    solved : False where the last call found no offsets (a reading or an angle that is no number); they are zero then.
    left_out : effects of the model that are not compensated.

    Raises
    ------
    ValueError : the model holds an effect that is neither linear nor a `ScalarLaw`, and ``leave_out`` does not name it.
    """

    def __init__(self, robot: CompliantRobot, setup: MeasurementSetup, settings: StepSettings | None = None) -> None:
        self.settings = settings or StepSettings()
        laws = linear_nodes(robot, setup, self.settings.leave_out, with_laws=True)
        self.left_out = laws.left_out
        chain = robot.adjusted_chain
        n_logged = chain.coupling.shape[1]
        self.deflection, self.wrench = np.zeros(6), np.zeros(6)
        self._parts = self.wrench.reshape(2, 3)
        self._started, self.solved = False, True
        self._coupling, self._offset = np.ascontiguousarray(chain.coupling), np.ascontiguousarray(chain.offset)
        self._shapes = ChainPair(node_chain(chain, laws), laws, self._coupling, self.settings.damping)
        self._reading = _ProcessWrench(robot, laws.setup, self.settings)
        self._solver = _Solver(self._shapes.motion_and_damping)
        self.offsets = self._solver.offsets
        self._plain = bool(np.array_equal(chain.coupling, np.eye(chain.n_joints)) and not chain.offset.any())
        self._angles = np.zeros(chain.n_joints)
        self._limits = np.ascontiguousarray(chain.limits.T)
        self._limited = bool(np.isfinite(chain.limits).any())
        self._room = np.zeros((2, n_logged))
        self._least, self._most = self._room
        self._size, self._largest, self._square = np.zeros(n_logged), np.zeros(()), np.zeros(())

    def __call__(self, joints: Floats, reading: Floats) -> Floats:
        """Return the offsets (L,), rad, for commanded logged angles (L,), rad, and a reading (6,), N and N·m.

        The array returned is the same one each time, and changes with the next call. Both inputs are contiguous arrays
        of float64; the reading is a wrench on the robot in the set-up's wrench axes about its wrench point.
        """
        shapes, angles = self._shapes, joints
        if not self._plain:
            angles = np.dot(self._coupling, joints, self._angles)
            np.add(angles, self._offset, angles)
        shapes.stand(angles)
        self._reading.take(reading, shapes.axes_of_reading, self.wrench, self._started)
        shapes.respond(self._parts)
        for _ in range((self.settings.sweeps if self._started else FIRST_SWEEPS) - 1):
            shapes.place()
            shapes.respond(self._parts)
        self._started = True
        shapes.remember()
        shapes.deflect(self.deflection)
        self.solved = self._solver.solve(self.deflection)
        if self.solved:
            self._keep_within(joints)
        else:
            self.reset()  # what is no number must not stay in the filter, in the shapes and in the laws' memory
        return self.offsets

    def _keep_within(self, joints: Floats) -> None:
        """Cut the offsets off at the largest correction and at the joint limits."""
        offsets, most = self.offsets, self.settings.largest_correction
        np.dot(offsets, offsets, self._square)
        if self._square.item() > most * most:
            np.abs(offsets, self._size)
            np.maximum.reduce(self._size, out=self._largest)
            if self._largest > most:
                # All joints in proportion: one joint cut off alone would push the tool aside.
                np.divide(most, self._largest, self._largest)
                np.multiply(offsets, self._largest, offsets)
        if self._limited:
            np.subtract(self._limits, joints, self._room)
            np.maximum(offsets, self._least, out=offsets)
            np.minimum(offsets, self._most, out=offsets)

    def reset(self) -> None:
        """Forget what was: the next sample is taken as having stood for ever."""
        self._started = False
        self._shapes.straighten()


class _ProcessWrench:
    """The process wrench of a reading: without the tool's weight, filtered; one product for all six components.

    Rows of the state: the filter's two memories, the reading, the tool's weight in it, and what of that it had already
    when it was zeroed. The product writes the memories and the filtered wrench into the other of two such arrays.
    """

    def __init__(self, robot: CompliantRobot, setup: MeasurementSetup, settings: StepSettings) -> None:
        b, a = reading_filter(settings.cutoff_hz, settings.cycle_s)
        signs = np.array([1.0, -1.0, 1.0])  # reading − weight + weight when zeroed
        row = np.concatenate([[1.0, 0.0], b[0] * signs])
        first = np.concatenate([[0.0, 1.0], b[1] * signs]) - a[0] * row
        second = np.concatenate([[0.0, 0.0], b[2] * signs]) - a[1] * row
        self._matrix = np.stack([first, second, row])
        self._settled = np.array([1.0 - b[0], b[2] - a[1]])
        even, odd = np.zeros((5, 6)), np.zeros((5, 6))
        self._states = [(even, even[2], even[3], odd[:3], odd[2]), (odd, odd[2], odd[3], even[:3], even[2])]
        self._gravity, self._in_sensor = np.append(robot.chain.gravity, 0.0), np.zeros(3)
        self._there = settings.tool_mass > 0.0
        if not self._there:
            return
        com = np.array(settings.tool_com)
        self._weight, zeroed = tool_in_reading(robot.adjusted_chain, setup, settings.tool_mass, com, settings.zeroed_at)
        even[4] = odd[4] = zeroed

    def take(self, reading: Floats, axes: Floats, wrench: Floats, started: bool) -> None:
        """Write the process wrench (6,) of a reading (6,); axes (3, 4): the sensor's, row by row."""
        states = self._states
        state, own_reading, weight, after, filtered = states[0]
        states.reverse()
        np.copyto(own_reading, reading)
        if self._there:
            np.dot(axes, self._gravity, self._in_sensor)
            np.dot(self._weight, self._in_sensor, weight)
        if not started:
            np.multiply(self._settled[:, None], state[2] - state[3] + state[4], state[:2])
        np.dot(self._matrix, state, after)
        np.copyto(wrench, filtered)


class _Solver:
    """Joint offsets from a deflection: the least motion that takes it back, damped near singular poses."""

    def __init__(self, motion_and_damping: Floats) -> None:
        from scipy.linalg import lapack

        self._motion = motion_and_damping
        self._columns = motion_and_damping.T
        self._normal = np.zeros((6, 6))
        # symmetric: its transpose is the same matrix in the order that LAPACK works in without a copy
        self._normal_there = self._normal.T
        self._solve_positive = lapack.dposv
        self._right = np.zeros((6, 1))
        self._right_flat = self._right[:, 0]
        self._solved = np.zeros(len(self._columns))
        self.offsets = self._solved[:-6]

    def solve(self, deflection: Floats) -> bool:
        """Write −J⁺ D into ``offsets`` (L,); False where there is none, and the offsets are zero."""
        np.dot(self._motion, self._columns, self._normal)
        np.copyto(self._right_flat, deflection)
        info = self._solve_positive(self._normal_there, self._right, 0, 1, 1)[2]
        np.dot(self._right_flat, self._motion, self._solved)
        # a pivot that is no number, or a deflection that is none: the sum shows both
        if info == 0 and isfinite(self._solved.sum()):
            return True
        self._solved.fill(0.0)
        return False
