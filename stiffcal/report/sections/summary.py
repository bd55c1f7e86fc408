"""The answer in short, on the first page."""

from __future__ import annotations

from stiffcal.reduction.registration import RegistrationSummary
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Facts, Items, LeftOut, Paragraph, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.sections.sources import FIRST_PAGE_HOLDS, sources_table
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult

ORDER = 10
NOT_YOURS = (
    "Not computed by you: these results came with the campaign folder, and the logs to compute them again are missing."
)


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the result in a few sentences, and where it comes from."""
    blocks: list[Block] = []
    if content.identify is not None and content.identify.origin == "foreign":
        blocks.append(Paragraph(NOT_YOURS, "key"))
    if content.ingest is not None and content.ingest.registration is not None:
        blocks.append(Paragraph(_registration_sentence(content.ingest.registration)))
    sentences = _fit_sentences(content)
    if content.readings_alone and content.validate is not None:
        sentences += _heldout_readings(content.validate)
    else:
        sentences += _heldout_sentences(content.validate)
    if sentences:
        blocks.append(Paragraph(" ".join(sentences), "key"))
    results = (content.ingest, content.identify, content.validate)
    warnings = [text for result in results if result is not None for text in result.warnings]
    if warnings:
        blocks.append(Paragraph("To be kept in mind:"))
        blocks.append(Items(tuple(dict.fromkeys(warnings))))
    blocks.append(Facts(_provenance_rows(content)))
    if 0 < len(content.provenance.sources) <= FIRST_PAGE_HOLDS:
        blocks.append(sources_table(content.provenance.sources))
    return ReportSection("In short", tuple(blocks))


def _registration_sentence(registration: RegistrationSummary) -> str:
    """Return how well the kinematics meets the places by which frames were estimated."""
    missed = wording.measure_text({"translation": registration.rms_m, "rotation": registration.rms_rad})
    return (
        f"Registration of {wording.listing(registration.frames)} in {wording.count(registration.n_poses, 'pose')}: the "
        f"kinematics misses the measured places by {missed} rms."
    )


def _fit_sentences(content: ReportContent) -> list[str]:
    if content.identify is None:
        return ["No model has been fitted yet; this report shows what was measured."]
    fit = content.identify
    if content.readings_alone:
        return [_readings_sentence(content, fit)]
    text = (
        f"The model ({wording.model_words(fit.model)}) was fitted to "
        f"{wording.count(fit.n_states, 'load state')} in {wording.count(fit.n_runs, 'run')} of the "
        f"{content.provenance.robot}"
    )
    return [f"{text}; on these data it leaves {wording.measure_text(fit.rms)} rms."]


def _readings_sentence(content: ReportContent, fit: IdentifyResult) -> str:
    model = f"The model ({wording.model_words(fit.model)})"
    fitted_model = (content.readings_alone[0].fitted if len(content.readings_alone) == 1 else "") or model
    readings = wording.count(fit.n_readings or 0, "reading")
    return (
        f"{fitted_model} of the {content.provenance.robot} was fitted to {readings} in "
        f"{wording.count(fit.n_runs, 'run')}; on these data it leaves {wording.measure_text(fit.rms)} rms."
    )


def _heldout_readings(validation: ValidateResult) -> list[str]:
    left = wording.part(validation.relative, "torque")
    if wording.part(validation.rms, "torque") is None:
        return ["There is nothing held-out to judge it by: each joint was driven in one usable pose alone."]
    sentences = [
        f"In what the fit had not seen ({validation.scheme}) it leaves {wording.measure_text(validation.rms)} rms"
    ]
    sentences[0] += f", without a model {wording.measure_text(validation.zero_model)}"
    sentences[0] += f": {wording.percent(1.0 - left)} of the torque is predicted." if left is not None else "."
    if validation.noise is not None:
        sentences.append(f"Repeats alone scatter {wording.measure_text(validation.noise)} rms.")
    else:
        sentences.append("How much of this is noise cannot be judged: too little was repeated.")
    return sentences


def _heldout_sentences(validation: ValidateResult | None) -> list[str]:
    """Give the error to expect in new poses, with the deflection itself and the noise."""
    if validation is None:
        return ["What error to expect in new poses has not been tested yet (no validation)."]
    error = (
        f"In poses that the fit had not seen it leaves {wording.measure_text(validation.rms)} rms of a deflection of "
        f"{wording.measure_text(validation.zero_model)}"
    )
    left = validation.relative.translation
    if left is not None:
        error += f": {wording.percent(1.0 - left)} of the deflection is predicted"
    sentences = [f"{error}.", noise_sentence(validation)]
    if not validation.passed:
        sentences.append("The campaign's own thresholds do not hold.")
    return sentences


def noise_sentence(validation: ValidateResult) -> str:
    """Return what the instruments scatter, or that this cannot be judged."""
    if wording.part(validation.noise, "translation") is not None:
        return f"The instruments and the setting of loads alone scatter {wording.measure_text(validation.noise)} rms."
    return (
        "How much of this is noise cannot be judged: no load was repeated, and the manifest states no uncertainty of "
        "the instruments."
    )


def _provenance_rows(content: ReportContent) -> tuple[tuple[str, str], ...]:
    origin = content.provenance
    rows = [("campaign", origin.campaign), ("robot", origin.robot), ("date", origin.date)]
    if origin.versions:
        rows.append(("made with", ", ".join(f"{name} {version}" for name, version in origin.versions)))
    if origin.settings:
        rows.append(("settings", ", ".join(f"{name}: {value}" for name, value in origin.settings)))
    if len(origin.sources) > FIRST_PAGE_HOLDS:
        files = wording.count(len(origin.sources), "file")
        rows.append(("sources", f"{files}, listed with their SHA-256 under “Sources” at the end"))
    return tuple(rows)
