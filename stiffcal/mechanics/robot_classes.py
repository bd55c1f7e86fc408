"""Typical joint compliances by class of robot, where nothing is known of a robot but its geometry.

Good to a factor of two or three: a plan that is made with them chooses sensible poses, and is made anew once the first
runs are measured.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

RobotClass: TypeAlias = Literal["light", "medium", "heavy"]

# Joints from the base that carry the arm; the others are of the wrist.
ARM_JOINTS = 3
# rad/(N·m) of an arm's joint and of a wrist's. Light: harmonic drives, 2e4 to 2e5 N·m/rad (Harmonic Drive AG,
# engineering data CSG-2A). Medium: Wang, Zhang and Fuhlbrigge 2009, section III.C (ABB IRB 4400, 60 kg). Heavy: fits of
# FANUC R-2000iC and KUKA KR 240 (campaigns/fanuc-r2000ic, campaigns/kr240).
COMPLIANCES: dict[RobotClass, tuple[float, float]] = {
    "light": (1e-5, 4e-5),
    "medium": (2e-6, 2e-5),
    "heavy": (5e-7, 3e-6),
}


def typical_compliance(robot_class: RobotClass, joint: int) -> float:
    """Return a typical compliance about a joint's axis, rad/(N·m).

    Examples
    --------
    >>> typical_compliance("medium", 1), typical_compliance("medium", 6)
    (2e-06, 2e-05)
    """
    arm, wrist = COMPLIANCES[robot_class]
    return arm if joint <= ARM_JOINTS else wrist
