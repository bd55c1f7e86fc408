"""What to measure next: the pose and load that would tell look-alikes apart, and what else would help."""

from __future__ import annotations

from stiffcal.report import wording
from stiffcal.report.blocks import Block, Facts, LeftOut, Paragraph, ReportSection
from stiffcal.report.content import Document, ReportContent

ORDER = 78
_TITLE = "What to measure next"


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the separating measurement, or say that none is needed."""
    document = content.diagnose
    if document is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    blocks: list[Block] = []
    if document.get("next_measurement"):
        blocks.extend(_separating(document["next_measurement"], content.joint_names, "The diagnosis"))
    for one in content.earlier_diagnoses:
        if one.get("next_measurement"):
            blocks.extend(
                _separating(one["next_measurement"], content.joint_names, f"The diagnosis of fit {one['fit_id']}")
            )
    if not blocks:
        return LeftOut(_TITLE, _no_measurement_reason(document))
    return ReportSection(_TITLE, tuple(blocks))


def _no_measurement_reason(document: Document) -> str:
    if document["unexplained"]:
        return (
            "no known effects are to be told apart; more poses along what the remainder follows would show its course"
        )
    if len(document["missing"]) == 1 and document["missing"][0]["alternatives"]:
        return "no single load in reach tells the foremost of the look-alikes apart by more than the noise"
    return "no effect has a look-alike that another pose would have to rule out"


def _separating(measure: Document, joints: tuple[str, ...], who: str) -> list[Block]:
    one, other = (f"{each['effect']} ({wording.place(each['where'])})" for each in measure["separates"][:2])
    pose = ", ".join(
        f"{name} {wording.digits(angle)}°" for name, angle in zip(joints, measure["pose_deg"], strict=False)
    )
    force = ", ".join(wording.digits(value) for value in measure["load"][:3])
    facts = [("pose", pose), ("force", f"({force}) N, in the sensor’s axes")]
    if any(abs(value) > 0.0 for value in measure["load"][3:]):
        moment = ", ".join(wording.digits(value) for value in measure["load"][3:])
        facts.append(("moment", f"({moment}) N·m"))
    facts.append(("there they differ by", f"{wording.length(measure['difference_m'])} at the tool"))
    if measure.get("gain"):
        facts.append(("gain", f"{wording.digits(measure['gain'])} times the noise"))
    text = f"{who} cannot tell {one} from {other} in the poses measured so far. One load in this pose would:"
    return [Paragraph(text), Facts(tuple(facts))]
