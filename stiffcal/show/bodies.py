"""Several tracked bodies in `identify`: each joint separately, and the Cartesian stiffness in full poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import percent, significant

if TYPE_CHECKING:
    from stiffcal.identification.bodies.body_results import CartesianStiffnessResult, JointByItself, JointLineResult

_LOADS = dict(zip(("tx", "ty", "tz", "rx", "ry", "rz"), ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"), strict=True))
COMPONENTS = ("rx", "ry", "rz", "tx", "ty", "tz")


def add_joints(made: PageBuilder, joints: Sequence[JointByItself]) -> None:
    """Add which of each joint's six displacements rise above the noise, and the stiffness of those that do.

    Parameters
    ----------
    joints : between tracked bodies.
    """
    rows = []
    for joint in joints:
        lines: dict[str, JointLineResult] = {line.component: line for line in joint.lines}
        rows.append((f"joint {joint.joint}", *(_cell(lines[component]) for component in COMPONENTS)))
    titles = ("rotation x", "y", "z", "translation x", "y", "z")
    made.table(("each joint separately", *map(number, titles)), rows)
    for joint in joints:
        if joint.couplings:
            couplings = ", ".join(f"{axis} of {_LOADS[load]}" for axis, load in joint.couplings)
            made.say(
                f"joint {joint.joint}: off-diagonal elements of the 6×6 compliance that are significant: {couplings}",
                "bodies",
            )
    made.say("N·m/rad and N/m; –: not significant (below 3σ); ~: nonlinear", "bodies")


def _cell(line: JointLineResult) -> str:
    if not line.above_noise or not line.compliance:
        return "–"
    return ("~" if line.curved else "") + significant(1.0 / line.compliance)


def add_cartesian(made: PageBuilder, poses: Sequence[CartesianStiffnessResult]) -> None:
    """Add the diagonal of the Cartesian stiffness at each pose where wrench and displacement are full.

    Parameters
    ----------
    poses : the Cartesian stiffness, pose by pose.
    """
    rows = [
        (pose.run, direction, *(significant(float(matrix[k, k])) for k in range(6)))
        for pose in poses
        for direction, matrix in (
            ("Schneider et al. 2014, eq. 15", pose.equation_15),
            ("from the compliance", pose.from_compliance),
        )
    ]
    titles = ("Fx/x", "Fy/y", "Fz/z", "Tx/rx", "Ty/ry", "Tz/rz")
    made.table(("Cartesian stiffness", "way", *map(number, titles)), rows)
    made.say(
        "N/m and N·m/rad at the target, base axes; eq. 15 takes the displacements as exact, and their noise draws it "
        f"down, in the weakest direction to {_lost_shares(poses)}",
        "bodies",
    )


def _lost_shares(poses: Sequence[CartesianStiffnessResult]) -> str:
    """Return the share that noise leaves of eq. 15 in the weakest direction, pose by pose."""
    return ", ".join(percent(pose.over_noise / (1.0 + pose.over_noise)) for pose in poses)
