"""MuJoCo with drives that give by more than a spring: how far each turns follows the torque that MuJoCo finds on it.

The law of a drive is a displacement over a torque, so that it cannot be a spring of MuJoCo's. It shifts the spring's
rest angle instead: at rest the spring carries all the torque that load, weight and further springs put on the joint,
and the drive stands at ``torque / stiffness + law(torque)``. The laws are written for this robot alone, from the
papers, with none of stiffcal's effects.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from tests.laboratory.mujoco_robot import Cable, MujocoRobot, Settled, Spring


class DriveLaw(ABC):
    """How far the drives turn beyond their springs."""

    @abstractmethod
    def turn(self, torque: Floats, angles: Floats, lasting: float) -> Floats:
        """Return (J,) rad.

        Parameters
        ----------
        torque : (J,) N·m, on the joints.
        angles : (J,) rad, commanded.
        lasting : s, for which the load has acted; infinite in a run's first state.
        """

    @abstractmethod
    def settle(self, torque: Floats, lasting: float) -> None:
        """Take note of the torque at which the robot came to rest, for laws with a memory."""


@dataclass(frozen=True)
class TorqueLaw(DriveLaw):
    """A law of torques and angles alone."""

    law: Callable[[Floats, Floats], Floats]
    """(J,) torque and (J,) commanded angles to (J,) rad."""

    def turn(self, torque: Floats, angles: Floats, lasting: float) -> Floats:
        """Return (J,) rad."""
        return self.law(torque, angles)

    def settle(self, torque: Floats, lasting: float) -> None:
        """No memory."""


@dataclass
class PlayLaw(DriveLaw):
    """A Prandtl–Ishlinskii element: it stays where it is until the torque is more than ``slip`` away."""

    joint: int
    compliance: float
    slip: float
    _at: float = field(default=0.0, init=False)

    def _moved(self, torque: Floats, lasting: float) -> float:
        at = 0.0 if np.isinf(lasting) else self._at
        now = float(torque[self.joint - 1])
        return float(np.clip(at, now - self.slip, now + self.slip))

    def turn(self, torque: Floats, angles: Floats, lasting: float) -> Floats:
        """Return (J,) rad."""
        result = np.zeros_like(torque)
        result[self.joint - 1] = self.compliance * self._moved(torque, lasting)
        return result

    def settle(self, torque: Floats, lasting: float) -> None:
        """Keep the element where it is now."""
        self._at = self._moved(torque, lasting)


@dataclass
class CreepLaw(DriveLaw):
    """A Kelvin–Voigt element: time · dδ/dt = compliance · torque − δ; fully crept at a run's start."""

    joint: int
    compliance: float
    time: float
    _at: float = field(default=0.0, init=False)

    def _crept(self, torque: Floats, lasting: float) -> float:
        now = float(torque[self.joint - 1])
        return now if np.isinf(lasting) else now + (self._at - now) * float(np.exp(-lasting / self.time))

    def turn(self, torque: Floats, angles: Floats, lasting: float) -> Floats:
        """Return (J,) rad."""
        result = np.zeros_like(torque)
        result[self.joint - 1] = self.compliance * self._crept(torque, lasting)
        return result

    def settle(self, torque: Floats, lasting: float) -> None:
        """Keep the element where it is now."""
        self._at = self._crept(torque, lasting)


class MujocoDrives(MujocoRobot):
    """A robot whose drives follow laws in addition to their springs.

    Parameters
    ----------
    chain : without mechanically coupled axes. joint_stiffness, setup, springs, cables : as of `MujocoRobot`.
    laws : their displacements add up.
    """

    def __init__(
        self,
        chain: Chain,
        joint_stiffness: Floats,
        setup: MeasurementSetup,
        springs: Sequence[Spring] = (),
        cables: Sequence[Cable] = (),
        laws: Sequence[DriveLaw] = (),
    ) -> None:
        if chain.mechanical.any():
            raise ValueError("drives of coupled axes sit on no single joint")
        super().__init__(chain, joint_stiffness, setup, springs, cables=cables)
        self.laws = tuple(laws)
        self._spring = np.asarray(joint_stiffness, dtype=np.float64)
        self._dofs = np.array([int(self.model.joint(f"joint{k}").dofadr[0]) for k in range(1, self.n_joints + 1)])
        self._torque = np.zeros(self.n_joints)
        self._commanded = np.zeros(self.n_joints)
        self._lasting = np.inf

    @property
    def joint_torque(self) -> Floats:
        """(J,) N·m on the joints by all but their own drives, where the robot came to rest last."""
        return self._torque.copy()

    def joint_force(self, wrench: Floats) -> Floats:
        """Return (J,) N·m about the joints by a wrench (6,), where the robot came to rest last."""
        return np.asarray(self.force_of(wrench)[self._dofs])

    def lead(self, joints: Floats, wrench: Floats, run: Integers, time: Floats) -> Settled:
        """Find the balance of every state in order.

        Parameters
        ----------
        joints : (n, J) commanded model angles, rad. wrench : (n, 6) as `MujocoRobot.settle`.
        run : (n,) run numbers, states of a run contiguous. time : (n,) s; a load acts since the state before.

        Raises
        ------
        ArithmeticError : a state does not come to rest.
        """
        out = self.blank(len(run))
        for i in range(len(run)):
            self._lasting = np.inf if i == 0 or run[i] != run[i - 1] else float(time[i] - time[i - 1])
            self._commanded = joints[i]
            self.note(out, i, joints[i], self._settle_one(joints[i], wrench[i]))
            for law in self.laws:
                law.settle(self._torque, self._lasting)
        return out

    def _unbalanced(self, wrench: Floats) -> Floats:
        """Generalised force (nv,) left over, each drive's spring at rest where its laws put it."""
        force = super()._unbalanced(wrench)
        wound = self.data.qpos[self._angles] - self._commanded
        # What is left over and what the spring holds: the torque on the joint by all but its own drive.
        self._torque = force[self._dofs] + self._spring * wound
        for law in self.laws:
            force[self._dofs] += self._spring * law.turn(self._torque, self._commanded, self._lasting)
        return force
