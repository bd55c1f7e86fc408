"""What several tracked bodies say beside the fit: each joint by itself, and the Cartesian stiffness at full poses."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stiffcal.workflow.steps import Document, Ingested

if TYPE_CHECKING:
    from stiffcal.identification.joint_lines import JointComplianceMatrix, JointLine
    from stiffcal.identification.joint_motion import JointMotion


def bodies_document(data: Ingested) -> Document:
    """Return ``joints_by_themselves`` and ``cartesian_stiffness`` of the `identify` document, as far as there are any.

    Parameters
    ----------
    data : a campaign with its load states.
    """
    from stiffcal.identification.cartesian_stiffness import cartesian_stiffnesses
    from stiffcal.identification.joint_lines import joint_compliance
    from stiffcal.identification.joint_motion import joint_motions

    found: Document = {}
    chain = data.campaign.chain
    motions = joint_motions(data.states, chain)
    if motions:
        found["joints_by_themselves"] = [_joint(motion, joint_compliance(motion, len(motions))) for motion in motions]
    # With one body and its forces alone the wrench is never full, and nothing is lost by not asking.
    full = cartesian_stiffnesses(data.states, chain)
    if full:
        found["cartesian_stiffness"] = [
            {
                "run": one.run,
                "target": one.target,
                "n_states": one.n,
                "equation_15": one.stiffness.tolist(),
                "from_compliance": one.from_compliance.tolist(),
                "fullness": {"wrench": one.fullness[0], "displacement": one.fullness[1]},
                "over_noise": one.over_noise,
            }
            for one in full
        ]
    return found


def _joint(motion: JointMotion, found: JointComplianceMatrix) -> dict[str, Any]:
    return {
        "joint": motion.joint,
        "between": [motion.inboard or "base", motion.outboard],
        "lines": [_line(line) for line in found.lines],
        "couplings": [list(pair) for pair in found.couplings],
        "matrix": None if found.matrix is None else found.matrix.tolist(),
        "matrix_std": None if found.matrix_std is None else found.matrix_std.tolist(),
    }


def _line(line: JointLine) -> dict[str, Any]:
    def number(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "component": line.component,
        "compliance": number(line.compliance),
        "std": number(line.std),
        "above_noise": line.above_noise,
        "curved": line.curved,
        "curve": [number(value) for value in line.curve],
        "p_curved": line.p_curved,
        "scatter": number(line.scatter),
        "largest": line.largest,
        "n_states": line.n,
    }
