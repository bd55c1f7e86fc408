"""MuJoCo along a load path: dry friction, stops and dampers, whose rest depends on how the robot came there.

MuJoCo steps in time, with its own contact solver. Each step starts from standstill (a robot damped beyond measure), and
every drive carries the inertia of its spring times the step's square, far more than all links: then one step takes
every spring to where it balances the forces of the moment, and a handful of steps brings the whole robot to rest, from
one side, without a swing that would let a slider slip further than the load does. Friction is MuJoCo's
``frictionloss``, made hard by its no-slip pass (else what sticks would creep); stops are joint limits; a damper's time
is real time, stretched to MuJoCo's step.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from stiffcal.arrays import Floats, Integers
from tests.laboratory.mujoco_robot import MujocoRobot, Settled

STEP = 100.0
"""s of MuJoCo's clock: rotors of stiffness × STEP² outweigh the links' inertia a million times."""

AT_REST = 1e-13
"""rad or m: the last step's size at which the robot counts as at rest."""

IMPEDANCE = 0.9999
"""MuJoCo's largest: its stops are never quite hard."""

PUSHED_BACK = 0.9
"""Share of what is beyond a stop that one step takes back; all of it would bounce off, and never come to rest."""

STOP_SOFTNESS = (1.0 - IMPEDANCE) / IMPEDANCE / PUSHED_BACK
"""By so much of the spring next to it a stop gives."""

FROZEN = 1e12
"""Damping over stiffness × STEP of what must not move while the rest settles."""


class MujocoPath:
    """A robot that is led along its loads.

    Parameters
    ----------
    robot : with whatever springs, friction, stops, dampers.
    ramp : parts in which each change of the load is made.
    tick : s, longest real time between two looks at the dampers.
    """

    def __init__(self, robot: MujocoRobot, ramp: int = 4, tick: float = 0.2) -> None:
        self.robot, self.ramp, self.tick = robot, ramp, tick
        model: Any = robot.model
        stiffness = robot.stiffness_of_springs()
        model.opt.timestep = STEP
        model.opt.noslip_iterations, model.opt.noslip_tolerance = 100, 1e-15
        # solved force by force: the default's costs, squares of accelerations, end in rounding far above rest
        model.opt.solver = mujoco.mjtSolver.mjSOL_PGS
        model.opt.iterations, model.opt.tolerance = 100, 0.0
        model.dof_armature[:] = stiffness * STEP**2
        model.jnt_solref[:] = -PUSHED_BACK / STEP**2, -1.0 / STEP
        model.jnt_solimp[:, :2] = IMPEDANCE
        self._time = np.where(stiffness > 0.0, np.asarray(model.dof_damping) / np.maximum(stiffness, 1e-300), 0.0)
        self._frozen = np.where(self._time > 0.0, FROZEN * stiffness * STEP, 0.0)
        self._stiffness = stiffness
        mujoco.mj_setConst(model, robot.data)

    def walk(self, joints: Floats, wrench: Floats, run: Integers, time: Floats | None = None) -> Settled:
        """Lead the robot through all runs.

        Parameters
        ----------
        joints : (n, J) commanded model angles, rad. wrench : (n, 6) as `MujocoRobot.settle`.
        run : (n,) run numbers, states of a run contiguous; each starts with every spring slack, then weight acts.
        time : (n,) s, when each state is looked at; the load changes evenly in between. Needed by dampers.
        """
        out = self.robot.blank(len(run))
        when = np.zeros(len(run)) if time is None else time
        for i in range(len(run)):
            if i == 0 or run[i] != run[i - 1]:
                self.robot.command(joints[i])
                # weight has acted for ever: no damper holds it up
                self._come_to_rest(np.zeros(6), np.zeros_like(self._time))
                before, since = np.zeros(6), when[i]
            steps = self._move(before, wrench[i], max(when[i] - since, 0.0))
            self.robot.note(out, i, joints[i], steps)
            before, since = wrench[i], when[i]
        return out

    def _move(self, start: Floats, end: Floats, lasting: float) -> int:
        """Change the load evenly within a real time; return MuJoCo's steps."""
        slow = bool(self._time.any())
        parts = max(self.ramp, int(np.ceil(lasting / self.tick)) if slow else 1)
        steps = 0
        for part in range(1, parts + 1):
            load = start + (end - start) * (part / parts)
            if slow and lasting > 0.0:
                self._step(load, self._stiffness * self._time * STEP / (lasting / parts))
                steps += 1
            steps += self._come_to_rest(load, self._frozen)
        return steps

    def _come_to_rest(self, load: Floats, damping: Floats) -> int:
        for step in range(1, 200):
            if self._step(load, damping) < AT_REST:
                mujoco.mj_kinematics(self.robot.model, self.robot.data)
                return step
        raise ArithmeticError(f"no rest under {load}")

    def _step(self, load: Floats, damping: Floats) -> float:
        """Make one step from standstill; return how far anything moved, rad or m."""
        model, data = self.robot.model, self.robot.data
        model.dof_damping[:] = damping
        data.qvel[:] = 0.0
        mujoco.mj_step1(model, data)
        data.qfrc_applied[:] = self.robot.force_of(load)
        mujoco.mj_step2(model, data)
        return float(np.abs(data.qvel).max()) * STEP
