"""The frame of an instrument that was levelled."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

# A base is upright within this: levels and feet of robots are better than a milliradian.
UPRIGHT_RAD = 1e-3


def levelled(base_from_tracker: Floats, gravity: Floats) -> Floats:
    """Return a transform whose z axis points up, its x axis as near to the given one's as that allows.

    Raises
    ------
    InputError : the base does not stand or hang upright.
    """
    up = -gravity / np.linalg.norm(gravity)
    if np.hypot(up[0], up[1]) > UPRIGHT_RAD:
        raise InputError.at(
            FaultCode.KEY_CONFLICT,
            "campaign.toml", "frames", "level requires a base that stands or hangs upright (gravity of robot.toml)",
            "remove level: the frame is then estimated whole",
        )  # fmt: skip
    levelled = base_from_tracker.copy()
    z = np.array([0.0, 0.0, np.sign(up[2])])
    across = levelled[:3, 0] - z * (z @ levelled[:3, 0])
    if np.linalg.norm(across) < UPRIGHT_RAD:
        across = levelled[:3, 1] - z * (z @ levelled[:3, 1])
    x = across / np.linalg.norm(across)
    levelled[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    return levelled
