"""The frame by which a clamped robot is held: what moves it, what it carries, and how the drives turn with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import HELD, LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.clamped_inverse import clamped_inverse
from stiffcal.mechanics.kinematics import attached_poses


@dataclass(frozen=True)
class HeldFrame:
    """The held frame in n states; all zero in those that were not clamped. Base axes, about the frame's origin."""

    target: int
    """Its index among the targets."""
    inverse: Floats
    """(J, 6, n) turn of the drives per displacement of the frame, rad per m and rad."""
    jacobian: Floats
    """(6, L, n) displacement of the frame per turn of each logged joint, m and rad per rad."""
    wrench: Floats
    """(6, n) what the fixture does to the robot since the run's reference, N and N·m."""

    def subset(self, pick: slice | Booleans | Integers) -> HeldFrame:
        """Return some of the states."""
        return HeldFrame(self.target, self.inverse[:, :, pick], self.jacobian[:, :, pick], self.wrench[:, pick])


def held_frame(chain: Chain, states: LoadStates, reference: Integers | None = None) -> HeldFrame | None:
    """Return the held frame of clamped runs, each run in its mean pose; None where no run was clamped.

    Parameters
    ----------
    reference : (n,) index of each state's reference state, from which the wrench counts; None: from no load.
    """
    clamped = states.clamped
    if not clamped.any() or HELD not in states.setup.target_names:
        return None
    target, n = states.setup.target_names.index(HELD), len(states)
    logged = np.linalg.inv(chain.drive_axes) @ chain.coupling
    load = states.wrench if reference is None else states.wrench - states.wrench[reference]
    inverse, jacobian = np.zeros((chain.n_joints, 6, n)), np.zeros((6, logged.shape[1], n))
    wrench = np.zeros((6, n))
    for number in np.unique(states.run[clamped]):
        in_run = np.flatnonzero(states.run == number)
        angles = chain.model_angles(states.joints[in_run].mean(axis=0)[None])
        inverse_of_run, drives = clamped_inverse(chain, angles, states.setup.targets[target])
        axes = attached_poses(chain, angles, states.setup.wrench_axes)[1][0]
        inverse[:, :, in_run], jacobian[:, :, in_run] = inverse_of_run[:, :, None], (drives @ logged)[:, :, None]
        wrench[:3, in_run], wrench[3:, in_run] = axes @ load[in_run, :3].T, axes @ load[in_run, 3:].T
    return HeldFrame(target, inverse, jacobian, wrench)
