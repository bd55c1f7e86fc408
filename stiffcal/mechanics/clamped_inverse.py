"""How the drives of a robot turn with a frame by which it is held."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import jacobians

# Singular values below this share of the largest count as none: two axes within about a sixth of a degree.
RANK = 0.003


def clamped_inverse(chain: Chain, angles: Floats, held: Attachment) -> tuple[Floats, Floats]:
    """Return (J, 6) and (6, J): how the drives turn with the held frame, and how it moves with them; base axes.

    Parameters
    ----------
    angles : (1, J) model angles, rad.
    held : the frame by which the robot is held.
    """
    jacobian = jacobians(chain, angles, held)[0] @ chain.drive_axes
    return inverse_of(jacobian), np.asarray(jacobian)


def inverse_of(jacobian: Floats) -> Floats:
    """Return (J, 6) the pseudo-inverse of a Jacobian (6, J), m and rad per rad, without singular directions."""
    # lengths count by the lever, so that metres and radians weigh alike
    lever = float(np.sqrt(np.mean(np.sum(jacobian[:3] ** 2, axis=0)))) or 1.0
    scale = np.array([1.0 / lever] * 3 + [1.0] * 3)
    return np.asarray(np.linalg.pinv(scale[:, None] * jacobian, rcond=RANK) * scale)
