"""What is missing, in sentences that are the same whatever was measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stiffcal.diagnosis.answers.results import ResidualDependence
from stiffcal.diagnosis.share_in_words import share_in_words
from stiffcal.diagnosis.words import candidate_in_words, error_in_words, leading_measure
from stiffcal.judgement.checks import Check
from stiffcal.judgement.found import Diagnosed, FoundEffect
from stiffcal.judgement.ground import CheckKind
from stiffcal.judgement.numbers import FIRM, NAMED
from stiffcal.judgement.reading import ShownDiscrepancy
from stiffcal.measurements.rms import Rms
from stiffcal.wording import listing, probability_in_words, significant, variable

CHECKED = {
    CheckKind.TRANSLATION: "positions", CheckKind.ROTATION: "rotations", CheckKind.LENGTH: "lengths of rods",
    CheckKind.TORQUE: "torques",
}  # fmt: skip
"""What is held against the noise, in words."""


def answer_of(
    found: Diagnosed, against: str, structure: Sequence[ResidualDependence], noise: Rms | None = None
) -> Iterator[str]:
    """Give the answer, sentence by sentence.

    Parameters
    ----------
    found : what is missing. against : the present model's errors next to the noise.
    structure : what the remaining error follows. noise : of the readings; None where it is not known.
    """
    yield _named(found, against) if found.found else _nothing_named(found, against)
    if found.unexplained:
        yield from _unexplained(found, structure, noise)


def _named(found: Diagnosed, against: str) -> str:
    """Return what is missing, with how sure it is and how much of the error goes with it."""
    names = listing(_in_words(one) for one in found.found)
    sure = all(one.group.firm for one in found.found)
    start = "Missing" if sure else "Probably missing"
    if not found.found[0].decided:
        certain = found.found[0].group.probability >= FIRM
        start = f"{'Missing' if certain else 'Probably missing'}, which of them is undecided"
    explained = found.explained
    share = ""
    if explained is not None:
        share = f"; {share_in_words(explained, len(found.found), found.after is not None)}"
    return f"{start}: {names}{share} ({against})."


def _in_words(one: FoundEffect) -> str:
    """Return an effect with its probability, and with those that look the same."""
    name = candidate_in_words(one.candidate)
    group = probability_in_words(one.group.probability)
    if not one.alternatives:
        return f"{name} ({group})"
    members = [(one.candidate, one.share), *one.alternatives]
    each = [
        f"{candidate_in_words(candidate)} {probability_in_words(one.group.probability * share)}"
        for candidate, share in members
    ]
    return f"{group} one of these: {', '.join(each)}"


def _nothing_named(found: Diagnosed, against: str) -> str:
    """Return that no effect is named, and whether that is for noise."""
    if found.unexplained:
        return f"Something is missing that no effect of the catalogue explains ({against})."
    if not found.noise_known:
        return (
            "No missing effect is found; whether the model is good enough cannot be judged without a known noise "
            f"({against}): repeat some loads, or state sigma."
        )
    if found.after is not None and not found.after.adequate and found.reading.adequate:
        return (
            "No effect is missing: the remaining error depends on no variable; the noise is probably larger than "
            f"stated ({against})."
        )
    if found.reading.adequate and _left_out_is_worse(found):
        return (
            f"Nothing is missing that these {found.measured_in} show: the fit leaves no more than noise. What was left "
            f"out of it is predicted worse ({against}), as the rest determines the model too little; measure more "
            f"{found.more}."
        )
    if found.reading.adequate:
        return f"Nothing is missing: the error is that of the instruments ({against})."
    p = probability_in_words(found.reading.p_nothing)
    return (
        f"No effect is found; whether the model is good enough cannot be judged with these {found.measured_in}: that "
        f"nothing of half the noise or more is missing has a probability of {p} ({against}); measure more {found.more}."
    )


def _left_out_is_worse(found: Diagnosed) -> bool:
    """Return whether errors of what is left out of the fit add more to the noise than the noise itself."""
    return found.before is not None and found.before.ratio**2 - 1.0 > 1.0


def _unexplained(found: Diagnosed, structure: Sequence[ResidualDependence], noise: Rms | None) -> list[str]:
    """Return what is left that no effect explains: laws that nobody has written down, and checks that fail."""
    texts = []
    laws = [law for law in found.reading.unlisted if law.probability >= NAMED] or list(found.reading.unlisted[:1])
    if found.reading.p_unknown >= NAMED and laws:
        named = listing(f"{law.place}: {law.follows} ({probability_in_words(law.probability)})" for law in laws)
        texts.append(f"A law of its own that the catalogue does not hold is probable: {named}.")
    if found.reading.discrepancy is not None:
        texts.append(_of_no_law(found, found.reading.discrepancy, noise))
    texts += [_failed(found, check) for check in found.reading.failed]
    if structure:
        texts.append(f"The remaining error depends on {variable(structure[0].follows)}.")
    if found.found:
        texts.insert(0, "Something else is missing that no effect of the catalogue explains.")
    return texts


def _of_no_law(found: Diagnosed, shown: ShownDiscrepancy, noise: Rms | None) -> str:
    """Return a discrepancy that shows, with its size where the noise is known."""
    measure = None if noise is None else leading_measure(noise)
    own = None if noise is None or measure is None else dict(noise.items()).get(measure)
    size = "" if own is None or measure is None else f" by {error_in_words(shown.size * own, measure)} rms"
    p = probability_in_words(shown.probability)
    if shown.in_time:
        return f"The readings drift irregularly in the course of runs{size} ({p})."
    return f"The readings differ from {found.differ_between}{size}, and no logged variable explains how ({p})."


def _failed(found: Diagnosed, check: Check) -> str:
    """Return a check that fails, in words."""
    ratio = f"{significant(max(check.ratio, 0.0) ** 0.5)} times"
    if check.kind is CheckKind.RUN and check.run is not None:
        return f"What is left in {found.run_in_words(check.run)} is {ratio} as large as in the others."
    return f"What is left in {CHECKED[check.kind]} is {ratio} the noise."


def why_not_added(probability: float) -> str:
    """Return why an effect is not named, in words."""
    return f"probability {probability_in_words(probability)} next to all other explanations"
