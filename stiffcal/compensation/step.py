"""The correction for one sample, for a controller's loop: joints and force reading in, joint offsets out.

Everything is set up once; a call works in arrays that stand ready, and allocates none. Two shapes of the chain, with
and without the load, are carried side by side; their difference is the deflection, and one Newton step on the chain's
Jacobian makes the joint offsets from it. A sweep takes the wrenches on the shapes that the sweep before has found, the
first ever on the rigid chain, which alone would be the papers' linear form (002, eq. 8). In a loop a load changes
little from one cycle to the next, so that one sweep a call holds the change of the levers too, weight included: within
some 10⁻⁴ of the balance that `targets.correct_joints` solves, and for one cycle within a per cent after a blow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from stiffcal.compensation.linear_nodes import linear_nodes, node_chain
from stiffcal.compensation.step_shapes import Shapes
from stiffcal.compensation.tool_weight import tool_arm, weight_matrix
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.low_pass import LowPass
from stiffcal.model.composite import CompliantRobot

Floats = NDArray[np.float64]


FIRST_SWEEPS = 3


@dataclass(frozen=True)
class StepSettings:
    """How a controller's loop compensates.

    Attributes
    ----------
    cycle_s : time between two calls, s (002: 4 ms; 001: 1 ms).
    cutoff_hz : of the filter for the sensor's noise; None: no filter.
    tool_mass : kg, of what hangs beyond the sensor and is in its reading; tool_com : (3,) in the flange frame, m.
    zeroed_at : (L,) logged angles, rad, at which the sensor read zero with the tool on; None: it was never zeroed.
    sweeps : in each call; the first call after a start makes `FIRST_SWEEPS`, as nothing was found before.
    damping : Jacobian's directions that move less than this, m/rad or rad/rad, are corrected less and less.
    largest_correction : rad, what a joint's offset is cut off at.
    leave_out : names of effects that the loop may leave out, because it cannot hold them.
    """

    cycle_s: float = 0.004
    cutoff_hz: float | None = None
    tool_mass: float = 0.0
    tool_com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    zeroed_at: Floats | None = None
    sweeps: int = 1
    damping: float = 5e-3
    largest_correction: float = float(np.radians(2.0))
    leave_out: tuple[str, ...] = ()


class CompensationStep:
    """A robot's compensation, ready for samples.

    Parameters
    ----------
    robot : chain and effects, every parameter valued.
    setup : where force sensor and target sit; the target is what is kept in place.
    settings : how the loop runs.

    Attributes
    ----------
    offsets : (L,) rad, what the last call returned: to be added to the commanded logged angles.
    deflection : (6,) of the target by the last call's load, base axes, m and rad.
    wrench : (6,) the last call's process wrench: filtered, without the tool's weight.
    left_out : effects of the model that are not compensated.

    Raises
    ------
    ValueError : the model holds an effect that the loop cannot hold, and ``leave_out`` does not name it.
    """

    def __init__(self, robot: CompliantRobot, setup: MeasurementSetup, settings: StepSettings | None = None) -> None:
        self.settings = settings or StepSettings()
        laws = linear_nodes(robot, setup, self.settings.leave_out)
        self.left_out = laws.left_out
        chain = robot.chain
        n_logged = chain.coupling.shape[1]
        self.offsets, self.deflection, self.wrench = np.zeros(n_logged), np.zeros(6), np.zeros(6)
        self._filter = None
        if self.settings.cutoff_hz is not None:
            self._filter = LowPass(self.settings.cutoff_hz, 1.0 / self.settings.cycle_s)
        self._started = False
        self._reading = np.zeros(6)
        self._shapes = Shapes(node_chain(chain, laws), laws)
        self._tool = _ToolWeight(robot, laws.setup, self.settings)
        self._solver = _Solver(chain.coupling, chain.n_joints, self.settings.damping)
        self._coupling, self._offset = np.ascontiguousarray(chain.coupling), np.ascontiguousarray(chain.offset)
        self._angles = np.zeros(chain.n_joints)
        self._low, self._high = np.array(chain.limits[:, 0]), np.array(chain.limits[:, 1])
        self._room = np.zeros((2, n_logged))
        self._size, self._largest = np.zeros(n_logged), np.zeros(())

    def __call__(self, joints: Floats, reading: Floats) -> Floats:
        """Return the offsets (L,), rad, for commanded logged angles (L,), rad, and a reading (6,), N and N·m.

        The array returned is the same one each time, and changes with the next call. Both inputs are contiguous arrays
        of float64; the reading is a wrench on the robot in the set-up's wrench axes about its wrench point.
        """
        np.matmul(self._coupling, joints, out=self._angles)
        np.add(self._angles, self._offset, out=self._angles)
        shapes = self._shapes
        shapes.stand(self._angles)
        self._tool.take_out(reading, shapes.axes_of_reading, self._reading)
        if self._filter is None:
            np.copyto(self.wrench, self._reading)
        else:
            if not self._started:
                self._filter.settle(self._reading)
            self._filter.step(self._reading, self.wrench)
        shapes.load(self.wrench)
        for _ in range(self.settings.sweeps if self._started else FIRST_SWEEPS):
            shapes.sweep()
        self._started = True
        shapes.difference(self.deflection)
        self._solver.solve(shapes, self.deflection, self.offsets)
        np.abs(self.offsets, out=self._size)
        np.maximum.reduce(self._size, out=self._largest)
        if self._largest > self.settings.largest_correction:
            # All joints in proportion: one joint cut off alone would push the tool aside.
            np.divide(self.settings.largest_correction, self._largest, out=self._largest)
            np.multiply(self.offsets, self._largest, out=self.offsets)
        np.subtract(self._low, joints, out=self._room[0])
        np.subtract(self._high, joints, out=self._room[1])
        np.maximum(self.offsets, self._room[0], out=self.offsets)
        np.minimum(self.offsets, self._room[1], out=self.offsets)
        return self.offsets

    def reset(self) -> None:
        """Forget what was: the next sample is taken as having stood for ever."""
        self._started = False
        self._shapes.straighten()


class _ToolWeight:
    """What the weight of the tool beyond the sensor makes it read, taken out."""

    def __init__(self, robot: CompliantRobot, setup: MeasurementSetup, settings: StepSettings) -> None:
        chain, sensor = robot.chain, setup.wrench_axes
        self._there = settings.tool_mass > 0.0
        self._gravity, self._in_sensor = np.array(chain.gravity), np.zeros(3)
        self._read, self._at_zero = np.zeros(6), np.zeros(6)
        self._matrix = np.zeros((6, 3))
        if not self._there:
            return
        if not np.allclose(setup.wrench_axes.transform, setup.wrench_point.transform):
            raise ValueError("a tool's weight is taken out of a reading whose axes and point are one frame, the sensor")
        arm = tool_arm(chain, sensor, np.array(settings.tool_com))
        self._matrix = weight_matrix(arm, settings.tool_mass)
        if settings.zeroed_at is not None:
            angles = chain.model_angles(np.atleast_2d(settings.zeroed_at))
            _, rotation = attached_poses(chain, angles, Attachment(sensor.body, sensor.transform))
            self._at_zero = self._matrix @ rotation[0].T @ chain.gravity

    def take_out(self, reading: Floats, sensor_axes: Floats, out: Floats) -> None:
        """Write a reading (6,) without the tool's weight into ``out``; sensor_axes (3, 3): base_from_sensor."""
        if not self._there:
            np.copyto(out, reading)
            return
        np.matmul(self._gravity, sensor_axes, out=self._in_sensor)
        np.matmul(self._matrix, self._in_sensor, out=self._read)
        np.subtract(reading, self._read, out=out)
        np.add(out, self._at_zero, out=out)


class _Solver:
    """Joint offsets from a deflection: the least motion that takes it back, damped beside singular poses."""

    def __init__(self, coupling: Floats, n_joints: int, damping: float) -> None:
        n_logged = coupling.shape[1]
        self._same = bool(np.array_equal(coupling, np.eye(n_joints)))
        self._coupling = np.ascontiguousarray(coupling.T)
        self._rows = np.zeros((n_logged, 6))
        self._columns = self._rows.T
        self._normal = np.zeros((6, 6))
        # symmetric: its transpose is the same matrix in the order that LAPACK works in without a copy
        self._normal_there = self._normal.T
        self._damping = damping * damping * np.eye(6)
        self._right = np.zeros((6, 1))
        self._right_flat = self._right[:, 0]

    def solve(self, shapes: Shapes, deflection: Floats, offsets: Floats) -> None:
        """Write −J⁺ D into ``offsets`` (L,)."""
        shapes.differentiate()
        rows = shapes.jacobian
        if not self._same:
            np.matmul(self._coupling, shapes.jacobian, out=self._rows)
            rows, columns = self._rows, self._columns
        else:
            columns = shapes.jacobian_columns
        np.matmul(columns, rows, out=self._normal)
        np.add(self._normal, self._damping, out=self._normal)
        np.negative(deflection, out=self._right_flat)
        lapack.dposv(self._normal_there, self._right, overwrite_a=1, overwrite_b=1)
        np.matmul(rows, self._right_flat, out=offsets)
