"""The whole clamped chain: what of a motor's motion its own drive takes up, and what torque that drive carries.

The flange is held, so that motors, drives and fixture close on each other (physics, section 1, with D = −C_fixture W):

    J (Δd_motor + δ(τ)) + C_fixture W = 0,    τ = Jᵀ W + weight

in drive coordinates d. One lever alone would take all of the motion for the moved joint's; here the equation is solved
with the pseudo-inverse of J. Where J has full rank each drive takes up its own motor's motion. In poses where joints
turn the flange alike (004's doubt about joints 4 and 6) only a combination is measured, and the other drives' share,
predicted by their own curves, is taken off.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.clamped.held.torque_source import TorqueSource
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.loops.torque_angle import TorqueAngleLaw
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.clamped_inverse import clamped_inverse
from stiffcal.mechanics.kinematics import attached_poses

# A joint of which less than this share is visible in a pose is not measured there.
LEAST_EXCITED = 0.1


@dataclass(frozen=True)
class ClampedChain:
    """One clamped run in drive coordinates, relative to one moved joint."""

    joint: int
    """The moved joint, from 1."""
    motion: Floats
    """(n, J) rad, how far the motors have turned the drives since the run's start."""
    torque: Floats
    """(n, J) N·m, what the surroundings and weight do about each drive's axis."""
    sensitivity: Floats
    """(J,) how much of each drive's turn the clamped flange shows in the moved joint's row; (0, …, 1, …, 0) where
    joints are distinguished in this pose.
    """
    fixture: Floats
    """(n,) rad, how far the fixture's give turns the moved joint."""
    source: TorqueSource
    """"force sensor" or "motor torque"."""
    moments_measured: bool
    """False where the torque comes from the force's lever alone."""
    weight: float
    """N·m, the moved drive's share of the weight; 0 where masses are not known."""
    lever: float
    """m, of the force about the moved joint: torque over the force's length, median; NaN without a sensor."""

    @property
    def is_excited(self) -> bool:
        """False where this pose does not show the moved joint's drive."""
        return bool(self.sensitivity[self.joint - 1] > LEAST_EXCITED)

    @property
    def is_distinguishable(self) -> bool:
        """True where no other drive's give looks like the moved one's."""
        other_joints = np.delete(self.sensitivity, self.joint - 1)
        return bool(np.abs(other_joints).max(initial=0.0) < 1e-3 * self.sensitivity[self.joint - 1])

    def angle(self, laws: Mapping[int, TorqueAngleLaw]) -> Floats:
        """Return (n,) φ = φ_a − φ_m of the moved joint, rad: its drive's give, the others' taken off.

        Parameters
        ----------
        laws : the other joints' laws, by joint from 1; joints that are not there count as rigid.
        """
        k = self.joint - 1
        total = self.motion @ self.sensitivity + self.fixture
        if not self.is_distinguishable:
            for joint, law in laws.items():
                if joint != self.joint and abs(self.sensitivity[joint - 1]) > 1e-3:
                    total = total + self.sensitivity[joint - 1] * drive_deflection(law, self.torque[:, joint - 1])
        return np.asarray(-total / self.sensitivity[k])

    def share_of_others(self, laws: Mapping[int, TorqueAngleLaw]) -> float:
        """Return the largest part of the motion that other drives take up, as a share of it."""
        span = float(np.ptp(self.motion[:, self.joint - 1]))
        if self.is_distinguishable or span <= 0.0:
            return 0.0
        return float(np.ptp(self.angle(laws) - self.angle({}))) / span


def drive_deflection(law: TorqueAngleLaw, torque: Floats) -> Floats:
    """Return (n,) rad: how far a joint's drive gives under torques, play included, from the middle of its play."""
    angle, grid = law.grid()
    return np.asarray(np.interp(torque, grid, angle) - law.middle)


def clamped_chain(
    readings: ClampedReadings,
    joint: int,
    chain: Chain,
    setup: MeasurementSetup,
    pose: Floats,
    fixture: Floats | None,
) -> ClampedChain:
    """Bring one clamped run to drive coordinates.

    Parameters
    ----------
    readings : of one run.
    joint : the moved joint, from 1.
    chain, setup : the robot, and where the force sensor sits.
    pose : (L,) logged angles, rad.
    fixture : (6, 6) compliance, m/N and rad/(N·m), base axes; None: rigid.
    """
    angles = chain.model_angles(pose[None])
    drives = chain.drive_axes
    inverse, jacobian = clamped_inverse(chain, angles, setup.wrench_point)
    sensitivity = (inverse @ jacobian)[joint - 1]
    start = np.median(readings.joints[: max(3, len(readings) // 200)], axis=0)
    motion = (readings.joints - start) @ chain.coupling.T @ np.linalg.inv(drives).T
    measured = bool(np.isfinite(readings.wrench).all())
    weight_torque = drive_weight(chain, setup, angles)
    if measured:
        axes = attached_poses(chain, angles, setup.wrench_axes)[1][0]
        wrench = np.concatenate([readings.wrench[:, :3] @ axes.T, readings.wrench[:, 3:] @ axes.T], axis=1)
        torque = wrench @ jacobian + weight_torque
    else:
        torque = -np.nan_to_num(readings.torque)
        alone = np.zeros_like(torque)
        alone[:, joint - 1] = torque[:, joint - 1]
        wrench = alone @ inverse
    give = np.zeros(len(readings)) if fixture is None else (wrench @ fixture.T) @ inverse[joint - 1]
    force = np.sqrt(np.sum(wrench[:, :3] ** 2, axis=1))
    pulled = force > 0.3 * force.max(initial=0.0)
    moved_torque = torque[:, joint - 1] - (weight_torque[joint - 1] if measured else 0.0)
    return ClampedChain(
        joint=joint,
        motion=motion,
        torque=torque,
        sensitivity=sensitivity,
        fixture=give,
        source="force sensor" if measured else "motor torque",
        moments_measured=setup.moments_measured or not measured,
        weight=float(weight_torque[joint - 1]),
        lever=float(np.median(np.abs(moved_torque[pulled]) / force[pulled]))
        if measured and pulled.any()
        else float("nan"),
    )


def drive_weight(chain: Chain, setup: MeasurementSetup, angles: Floats) -> Floats:
    """Return (J,) torques of the weight about the drives' axes, N·m; zero where masses are not known.

    Parameters
    ----------
    angles : (1, J) model angles, rad.
    """
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.model.balance.rest import find_rest
    from stiffcal.model.effect import RZ, Inputs

    if not chain.masses_known and setup.tool_mass == 0.0:
        return np.zeros(chain.n_joints)
    inputs = Inputs(np.ascontiguousarray(angles.T), np.zeros((6, 1)), setup, loaded=False)
    rest = find_rest(CompliantRobot(chain, ()), inputs)
    return np.asarray(rest.wrench[1 : 2 * chain.n_joints : 2, RZ, 0] @ chain.drive_axes)
