"""What to measure next: the pose and load that would distinguish look-alikes, and what else would help."""

from __future__ import annotations

from stiffcal.diagnosis.answers.results import DiagnoseResult, SeparatingMeasurement
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Facts, LeftOut, Paragraph, ReportSection
from stiffcal.report.content import ReportContent

ORDER = 78
_TITLE = "What to measure next"


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out the separating measurement, or the reason why none is needed."""
    diagnosis = content.diagnose
    if diagnosis is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    blocks: list[Block] = []
    if diagnosis.next_measurement is not None:
        blocks.extend(_separating(diagnosis.next_measurement, content, "The diagnosis"))
    for earlier in content.earlier_diagnoses:
        if earlier.next_measurement is not None:
            origin = f"The diagnosis of fit {earlier.fit_id}"
            blocks.extend(_separating(earlier.next_measurement, content, origin))
    if not blocks:
        why = _no_measurement_reason(diagnosis)
        return LeftOut(_TITLE, why) if why else None
    return ReportSection(_TITLE, tuple(blocks))


def _no_measurement_reason(diagnosis: DiagnoseResult) -> str:
    if diagnosis.unexplained:
        return (
            "no known effects have to be distinguished; more poses over the variables on which the remaining "
            "error depends would show its shape"
        )
    if len(diagnosis.missing) == 1 and diagnosis.missing[0].alternatives:
        return (
            "no load of this campaign’s size, in any one pose, separates the two leading look-alikes by more than the "
            "noise"
        )
    return ""


def _separating(measurement: SeparatingMeasurement, content: ReportContent, origin: str) -> list[Block]:
    first, second = map(wording.effect_at, measurement.separates[:2])
    pose = ", ".join(
        f"{name} {wording.significant(at)}{' mm' if k in content.prismatic_joints else '°'}"
        for k, (name, at) in enumerate(zip(content.joint_names, measurement.pose_deg, strict=False), start=1)
    )
    force = ", ".join(wording.significant(value) for value in measurement.load[:3])
    facts = [("pose", pose), ("force", f"({force}) N, in the sensor’s axes")]
    if any(abs(value) > 0.0 for value in measurement.load[3:]):
        moment = ", ".join(wording.significant(value) for value in measurement.load[3:])
        facts.append(("moment", f"({moment}) N·m"))
    facts.append(("predicted difference", f"{wording.length(measurement.difference_m)} at the tool"))
    if measurement.gain:
        facts.append(("gain", f"{wording.significant(measurement.gain)} times the noise"))
    text = (
        f"{origin} cannot distinguish {first} from {second} in these poses. One load in this pose would separate them:"
    )
    return [Paragraph(text), Facts(tuple(facts))]
