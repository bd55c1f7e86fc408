"""Joint angles that a controller counts together: the angle of a joint as it stands against the horizontal.

On FANUC's and some other controllers the angle of joint 3 stands still while joint 2 moves the forearm: it is the sum
of two angles of the robot file, or the difference. Such axes are parallel; `logged` of robot.toml states the sum.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.escapes import toml_text
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import jacobians

# Of the sine of the angle between two axes: what the lengths and angles of a robot file leave.
_PARALLEL = 1e-3


@dataclass(frozen=True)
class CoupledAngles:
    """Angles of which one is counted together with the one before it."""

    joints: Floats
    """(n, L) rad, as they would be."""
    place: str
    """Of the mistake."""
    words: str
    """What is tried, as in "with … they agree"."""
    mend: str
    """What to write."""


def coupled_angles(joints: Floats, chain: Chain) -> Iterator[CoupledAngles]:
    """Yield the angles with each joint counted together with the one before it, where their axes are parallel.

    Parameters
    ----------
    joints : (n, L) logged, rad. chain : the robot.
    """
    if len(joints) == 0 or len(chain.joint_names) != joints.shape[1]:
        return
    flange = Attachment(chain.n_joints + 1, np.eye(4))
    axes = jacobians(chain, chain.model_angles(joints[:1]), flange)[0, 3:]
    for second in range(1, joints.shape[1]):
        first = second - 1
        if chain.prismatic[[first, second]].any() or second >= axes.shape[1]:
            continue
        if np.linalg.norm(np.cross(axes[:, first], axes[:, second])) > _PARALLEL:
            continue
        one, other = chain.joint_names[first], chain.joint_names[second]
        for sign, symbol in ((1.0, "+"), (-1.0, "−")):
            counted = joints.copy()
            counted[:, second] += sign * joints[:, first]
            yield CoupledAngles(
                counted,
                f"joints {one} and {other}",
                f"{other} {symbol} {one} in place of {other}",
                f"the controller counts {other} together with {one}, as against the horizontal: write "
                f"{toml_text.pair('logged', {one: int(sign), other: 1})} for joint {other} in the robot file",
            )
