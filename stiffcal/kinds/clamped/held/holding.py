"""What holds a clamped robot: the wrench of the fixture, read by a sensor or taken from the moved motor's torque."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.kinds.clamped.held.chain import drive_weight
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.mechanics.clamped_inverse import clamped_inverse
from stiffcal.mechanics.kinematics import attached_poses


def held_wrench(campaign: Campaign, readings: ClampedReadings, run: Run, joint: int) -> Floats | None:
    """Return (n, 6) what the fixture does to the robot, N and N·m, sensor axes; None where nothing determines it.

    Without a sensor it is the smallest wrench that balances the moved drive's torque, less its share of the weight:
    Jᵀ W = τ with W = (J⁺)ᵀ τ, the other drives carrying none.

    Parameters
    ----------
    readings : of one run. run : its entry in the manifest. joint : the moved joint, from 1.
    """
    if np.isfinite(readings.wrench).all():
        return readings.wrench
    chain = campaign.chain
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    torque = readings.torque[:, joint - 1]
    if not setup.moments_measured or not np.isfinite(torque).all():
        return None
    pose = readings.joints.mean(axis=0) if run.joints_deg is None else np.deg2rad(np.array(run.joints_deg))
    angles = chain.model_angles(pose[None])
    inverse, _ = clamped_inverse(chain, angles, setup.wrench_point)
    carried = -torque - drive_weight(chain, setup, angles)[joint - 1]
    axes = attached_poses(chain, angles, setup.wrench_axes)[1][0]
    direction = np.concatenate([inverse[joint - 1, :3] @ axes, inverse[joint - 1, 3:] @ axes])
    return np.asarray(carried[:, None] * direction)
