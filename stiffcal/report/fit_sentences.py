"""Sentences about the fit: its data, its residual, its error in held-out data, the noise."""

from __future__ import annotations

from stiffcal.identification.readings.state_kinds import state_kinds
from stiffcal.reduction.registration.frames import RegistrationSummary
from stiffcal.report import wording
from stiffcal.report.content import ReportContent
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.model_words import model_words
from stiffcal.results.registration_words import convention_in_words, remainder_in_words
from stiffcal.results.validate_result import ValidateResult


def fit_sentences(content: ReportContent) -> list[str]:
    """Return how frames were estimated, to what the model was fitted, and its error in held-out data."""
    sentences = _fitted(content)
    if content.ingest is not None and content.ingest.registration is not None:
        sentences.insert(0, _registration_sentence(content.ingest.registration))
    if content.readings_alone and content.validate is not None:
        return sentences + _heldout_readings(content.validate)
    return sentences + _heldout_sentences(content)


def _registration_sentence(registration: RegistrationSummary) -> str:
    """Return how well the kinematics meets the places by which frames were estimated."""
    return f"{wording.capital(remainder_in_words(registration))}." + (
        "".join(
            f" {convention_in_words(name, frame)}."
            for name, frame in registration.frames.items()
            if frame.by_convention
        )
    )


def _fitted(content: ReportContent) -> list[str]:
    if content.identify is None:
        return ["No model has been fitted yet; this report shows the measurements."]
    fit = content.identify
    if content.readings_alone:
        return [_readings_sentence(content, fit)]
    states = f"{wording.count(fit.n_states, 'load state')} in {wording.count(fit.n_runs, 'run')}"
    if content.absolute_alone:
        states = wording.count(fit.n_states, "pose")
    model, robot = model_words(fit.model), the_robot(content.provenance.robot)
    text = f"The model, {model}, was fitted to {states} of {robot}"
    return [f"{text}; residual of the fit: {wording.measure_text(fit.rms)} rms."]


def the_robot(name: str) -> str:
    """Return a robot's name in a sentence, with one article.

    Examples
    --------
    >>> the_robot("KUKA KR 125"), the_robot("a six-axis robot"), the_robot("The arm")
    ('the KUKA KR 125', 'the six-axis robot', 'the arm')
    """
    article, _, rest = name.partition(" ")
    return f"the {rest if rest and article.lower() in ('a', 'an', 'the') else name}"


def _readings_sentence(content: ReportContent, fit: IdentifyResult) -> str:
    model = f"The model, {model_words(fit.model)},"
    fitted_model = (content.readings_alone[0].fitted if len(content.readings_alone) == 1 else "") or model
    readings = wording.count(fit.n_readings, "reading") if fit.n_readings else wording.count(fit.n_states, "state")
    return (
        f"{fitted_model} of {the_robot(content.provenance.robot)} was fitted to {readings} in "
        f"{wording.count(fit.n_runs, 'run')}; residual of the fit: {wording.measure_text(fit.rms)} rms."
    )


def _heldout_readings(validation: ValidateResult) -> list[str]:
    measured = {"torque": "torque", "motor_angle": "motor's angle"}
    measure = next((name for name in measured if wording.part(validation.rms, name) is not None), None)
    if measure is None:
        return ["It cannot be validated: each joint was driven in only one usable pose."]
    of_states = (kind.left_out for kind in state_kinds().values() if kind.measure == measure)
    where = next(of_states, f"data ({validation.scheme})")
    sentences = [f"Error in held-out {where}: {wording.measure_text(validation.rms)} rms"]
    sentences[0] += f", without a model {wording.measure_text(validation.zero_model)}"
    left = wording.part(validation.relative, measure)
    predicted = "." if left is None else f": {wording.share(1.0 - left)} of the {measured[measure]} is predicted."
    sentences[0] += predicted
    if validation.noise is not None:
        sentences.append(f"The noise is {wording.measure_text(validation.noise)} rms.")
    else:
        sentences.append("The noise is unknown: too few repeats.")
    return sentences


def _heldout_sentences(content: ReportContent) -> list[str]:
    """Give the error to expect in new poses, with the deflection itself and the noise."""
    validation = content.validate
    if validation is None:
        return ["The error in new poses is not known yet (no validation)."]
    whole = "an error of the nominal robot" if content.absolute_alone else "a deflection"
    error = (
        f"Error in {content.held_out}: {wording.measure_text(validation.rms)} rms at {whole} of "
        f"{wording.measure_text(validation.zero_model)}"
    )
    left = validation.relative.translation
    if left is not None:
        what = "that error" if content.absolute_alone else "the deflection"
        error += f": {wording.share(1.0 - left)} of {what} is predicted"
    sentences = [f"{error}."]
    if content.known_noise == validation.noise:  # else the answer above states the noise
        sentences.append(noise_sentence(validation))
    if not validation.passed:
        sentences.append("The thresholds of the campaign are exceeded.")
    return sentences


def noise_sentence(validation: ValidateResult) -> str:
    """Return what the instruments scatter, or that this cannot be judged."""
    if wording.part(validation.noise, "translation") is not None:
        return f"Noise of instruments and load application: {wording.measure_text(validation.noise)} rms."
    return "The noise is unknown: nothing was repeated, and campaign.toml states no uncertainty of the instruments."
