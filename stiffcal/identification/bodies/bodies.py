"""What several tracked bodies add to the fit: each joint by itself, and the Cartesian stiffness at full poses."""

from __future__ import annotations

import math

from stiffcal.identification.bodies.body_results import (
    CartesianStiffnessResult,
    Fullness,
    JointByItself,
    JointLineResult,
)
from stiffcal.identification.bodies.cartesian_stiffness import cartesian_stiffnesses
from stiffcal.identification.bodies.joint_lines import JointComplianceMatrix, JointLine, joint_compliance
from stiffcal.identification.bodies.joint_motion import JointMotion, joint_motions
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain


def joints_by_themselves(states: LoadStates, chain: Chain) -> list[JointByItself]:
    """Return the joints between tracked bodies; none where one body alone is tracked.

    Parameters
    ----------
    states : all load states of a campaign. chain : the robot's.
    """
    motions = joint_motions(states, chain)
    return [_joint(motion, joint_compliance(motion, len(motions))) for motion in motions]


def cartesian_stiffness(states: LoadStates, chain: Chain) -> list[CartesianStiffnessResult]:
    """Return the Cartesian stiffness at the poses where wrench and displacement are full.

    With one body and its forces alone the wrench is never full, and nothing is lost by not asking.

    Parameters
    ----------
    states : all load states of a campaign. chain : the robot's.
    """
    return [
        CartesianStiffnessResult(
            run=pose.run,
            target=pose.target,
            n_states=pose.n,
            equation_15=pose.stiffness,
            from_compliance=pose.from_compliance,
            fullness=Fullness(wrench=pose.fullness[0], displacement=pose.fullness[1]),
            over_noise=pose.over_noise,
        )
        for pose in cartesian_stiffnesses(states, chain)
    ]


def _joint(motion: JointMotion, compliance: JointComplianceMatrix) -> JointByItself:
    return JointByItself(
        joint=motion.joint,
        between=[motion.inboard or "base", motion.outboard],
        lines=[_line(line) for line in compliance.lines],
        couplings=[list(pair) for pair in compliance.couplings],
        matrix=compliance.matrix,
        matrix_std=compliance.matrix_std,
    )


def _line(line: JointLine) -> JointLineResult:
    def number(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return JointLineResult(
        component=line.component,
        compliance=number(line.compliance),
        std=number(line.std),
        above_noise=line.above_noise,
        curved=line.curved,
        curve=[number(value) for value in line.curve],
        p_curved=line.p_curved,
        scatter=number(line.scatter),
        largest=line.largest,
        n_states=line.n,
    )
