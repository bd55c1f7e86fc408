"""Several tracked bodies: each joint by itself (paper 001), and the Cartesian stiffness at poses where all is full."""

from __future__ import annotations

from functools import partial

from stiffcal.documents import Number
from stiffcal.identification.bodies.body_results import CartesianStiffnessResult
from stiffcal.quantity import LINEAR_STIFFNESS, STIFFNESS, of_stiffness
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    LeftOut,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.joint_motion import draw_about_axes, draw_joint
from stiffcal.report.joint_curves import JointCurve, JointPicture
from stiffcal.uncertainty import NORMAL_95

ORDER = 47
_TITLE = "Each joint separately"
_NAMES = {
    "tx": "translation x", "ty": "translation y", "tz": "translation z",
    "rx": "rotation x", "ry": "rotation y", "rz": "rotation about the axis",
}  # fmt: skip


_LOADS = {
    "tx": "force along x", "ty": "force along y", "tz": "force along z",
    "rx": "moment about x", "ry": "moment about y", "rz": "torque about its axis",
}  # fmt: skip


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out the table of all displacements and their pictures; nothing where one body alone is tracked."""
    joints = content.joint_pictures
    cartesian = [] if content.identify is None else content.identify.cartesian_stiffness or []
    if not joints and not cartesian:
        return None
    blocks: list[Block] = []
    if joints:
        blocks += [Paragraph(_lead(joints)), _table(joints), Paragraph(_couplings(joints))]
        blocks.append(PictureBlock(partial(draw_about_axes, joints), _caption_about_axes(joints)))
        blocks += [PictureBlock(partial(draw_joint, joint), _caption(joint)) for joint in joints]
    if cartesian:
        blocks += _cartesian(cartesian)
    return ReportSection(_TITLE if joints else "Cartesian stiffness", tuple(blocks))


def _n_identified(joints: tuple[JointPicture, ...], kind: str) -> tuple[int, int]:
    """Return how many of the displacements of a kind ("r", "t") rise above the noise, and how many there are."""
    curves = [curve for joint in joints for curve in joint.curves if curve.line.component[0] == kind]
    return sum(curve.line.above_noise for curve in curves), len(curves)


def _lead(joints: tuple[JointPicture, ...]) -> str:
    turns, all_turns = _n_identified(joints, "r")
    shifts, all_shifts = _n_identified(joints, "t")
    return (
        "The links on both sides of a joint are tracked, so the displacement of the joint itself is measured: "
        "relative motion of the two links at the origin of the joint, in joint axes, over the wrench of the load at "
        "that point (Schneider et al. 2014, eq. 4). No model is involved. A compliance above three standard "
        f"uncertainties is significant: {turns} of {all_turns} rotations and {shifts} of {all_shifts} translations are."
    )


def _table(joints: tuple[JointPicture, ...]) -> TableBlock:
    columns = (
        TableColumn("joint", align="left"),
        TableColumn("displacement", align="left"),
        TableColumn("stiffness, separately"),
        TableColumn("stiffness, all joints together"),
        TableColumn("unit", align="left"),
        TableColumn("significant", align="left", width=1.0),
    )
    rows: list[tuple[str, ...]] = []
    for joint in joints:
        for curve in sorted(joint.curves, key=lambda drawn_curve: drawn_curve.line.component[0] != "r"):
            unit = (STIFFNESS if curve.line.component[0] == "r" else LINEAR_STIFFNESS).usual
            scale = unit.factor
            measured = _stiffness(curve.line.compliance, curve.line.std, curve.line.above_noise, scale)
            whole = joint.together.get(curve.line.component)
            together = wording.DASH if whole is None else _stiffness(*whole, scale)
            rows.append(
                (joint.name, _NAMES[curve.line.component], measured, together, unit.name, _verdict(curve, whole))
            )
    caption = (
        "All displacements, rotations first; ± 95 %. Separately: a straight line through the displacements of that "
        "joint. All joints together: the fit of this report to all bodies; a dash where its model has no such spring. "
        "If a compliance is not significant, the value is a lower limit of the stiffness."
    )
    return TableBlock(columns, tuple(rows), caption)


def _couplings(joints: tuple[JointPicture, ...]) -> str:
    """Describe the entries off the diagonal of each joint's whole 6×6."""
    full = [joint for joint in joints if joint.couplings is not None]
    if not full:
        return "The loads do not excite all six directions of any joint: no full 6×6 compliance can be identified."
    text = f"The full 6×6 compliance is identifiable for {wording.listing(joint.name for joint in full)}. "
    coupled = [joint for joint in full if joint.couplings]
    if not coupled:
        return text + "No off-diagonal element is significant."
    descriptions = "; ".join(
        f"{joint.name}: "
        + ", ".join(f"{_NAMES[displacement]} with the {_LOADS[load]}" for displacement, load in joint.couplings or ())
        for joint in coupled
    )
    text += f"Significant off-diagonal elements (one false one expected in a hundred campaigns): {descriptions}."
    curved = [joint.name for joint in coupled if any(curve.line.curved for curve in joint.curves)]
    if curved:
        text += f" A nonlinear characteristic ({wording.listing(curved)}) leaves residuals that resemble couplings."
    return text


def _stiffness(compliance: Number, std: Number, above: bool, scale: float) -> str:
    """Return a stiffness ± 95 %; a lower bound where the compliance is not significant."""
    if compliance is None or std is None:
        return wording.DASH
    if not above:
        most = max(compliance, 0.0) + NORMAL_95 * std
        return f"above {wording.significant(scale / most)}" if most > 0.0 else wording.DASH
    return wording.plus_minus(scale / compliance, NORMAL_95 * std * scale / compliance**2)


def _verdict(curve: JointCurve, whole: tuple[float, float, bool] | None) -> str:
    text = ("yes, nonlinear" if curve.line.curved else "yes") if curve.line.above_noise else "no"
    if whole is not None and whole[2] != curve.line.above_noise:
        text += "; all joints together " + ("yes" if whole[2] else "no")
    return text


def _caption_about_axes(joints: tuple[JointPicture, ...]) -> str:
    curved = [joint.name for joint in joints if joint.curves[5].line.curved]
    text = (
        "The dominant compliances: each joint’s rotation about the axis over the torque (Schneider et al. 2014, Fig. "
        "2b)."
    )
    if curved:
        names = wording.listing(curved)
        text += f" A straight line does not fit {names}: backlash, or a stiffening or softening spring."
    if any(joint.laws for joint in joints):
        text += " “All joints together”: this report’s model, fitted to all bodies at once, for the joint."
    return text


def _caption(joint: JointPicture) -> str:
    inboard, outboard = joint.between
    n_loads = sum(curve.displacement.size for curve in joint.curves[:1])
    return (
        f"{joint.name}, {outboard} against {inboard}: six displacements of the origin of the joint over the same "
        f"components of its wrench, {n_loads} loads; one scale per row, offset of each run removed."
    )


def _cartesian(poses: list[CartesianStiffnessResult]) -> list[Block]:
    columns = (
        TableColumn("pose", align="left"),
        TableColumn("way", align="left"),
        *(TableColumn(f"{'about ' * (k > 2)}{'xyz'[k % 3]}", of_stiffness(k).usual.name) for k in range(6)),
    )
    rows = []
    for pose in poses:
        for words, matrix in (
            ("Schneider et al. 2014, eq. 15", pose.equation_15),
            ("from the compliance", pose.from_compliance),
        ):
            diagonal = [float(matrix[k, k]) * of_stiffness(k).usual.factor for k in range(6)]
            rows.append((pose.run, words, *(wording.significant(value) for value in diagonal)))
    shares = wording.listing(wording.percent(pose.over_noise / (1.0 + pose.over_noise)) for pose in poses)
    text = (
        "If the loads at one pose cover all six directions, the Cartesian stiffness at the target follows from "
        "wrenches and displacements alone. Eq. 15 of Schneider et al. (2014) takes the displacements as exact; their "
        f"errors bias the stiffness low, in the weakest direction to {shares}. The compliance, fitted in the opposite "
        "direction and inverted, is free of this bias."
    )
    caption = f"Diagonal of the Cartesian stiffness at {poses[0].target}, base axes, the other directions fixed."
    return [SubheadingBlock("Cartesian stiffness"), Paragraph(text), TableBlock(columns, tuple(rows), caption)]
