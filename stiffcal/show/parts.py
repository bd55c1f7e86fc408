"""What several answers show: registration, suspects, the course of clocks, as sentences of their pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import sqrt
from typing import TYPE_CHECKING

from stiffcal.presentation.values import Sentence
from stiffcal.quantity import RATE
from stiffcal.results.registration_words import convention_in_words, remainder_in_words
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import place, probability_in_words

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect
    from stiffcal.reduction.clocks.offsets import SourceClockOffset
    from stiffcal.reduction.registration.frames import RegistrationSummary


def registration(summary: RegistrationSummary | None) -> list[Sentence]:
    """Return what is left between the kinematics and the measured places; nothing where no frame was estimated."""
    if summary is None:
        return []
    texts = [remainder_in_words(summary)]
    texts += [convention_in_words(name, frame) for name, frame in summary.frames.items() if frame.by_convention]
    return [Sentence((text,), "registration") for text in texts]


def suspects(
    found: Sequence[Suspect] | None, not_checked: RunsNotChecked | None = None, searched: bool = False
) -> list[Sentence]:
    """Return each suspect: why, the likely cause and cure, and the lines to copy; and what was not checked.

    Parameters
    ----------
    found, not_checked : of the answer. searched : whether it is of a search for missing effects, which leaves them out.
    """
    texts = []
    for suspect in found or ():
        row = "" if suspect.row is None else f", row {suspect.row}"
        p = suspect.probability
        sure = "" if p is None else f" ({probability_in_words(p)})"
        texts.append(f"suspect: run {suspect.run}{row}{sure}: {suspect.kind}: {suspect.why}")
        texts.append(f"  likely: {suspect.likely}")
        if suspect.explained_by:
            effects = " and ".join(f"{effect.effect} ({place(effect.where)})" for effect in suspect.explained_by)
            texts.append(f"  equally well explained by an effect: {effects}")
    if found:
        left_out = searched and any(suspect.is_left_out for suspect in found)
        out = "left out of the search for missing effects, and " if left_out else ""
        texts.append(f"suspects are {out}included in the fit; to exclude them, copy these lines into campaign.toml:")
        texts += [f"  {line}" for suspect in found for line in suspect.exclude]
    sentences = [Sentence((text,), "suspect") for text in texts]
    return sentences + ([] if not_checked is None else [Sentence((not_checked.sentence,), "runs-not-checked")])


def clock_rates(runs: Iterable[Mapping[str, SourceClockOffset]]) -> list[Sentence]:
    """Return a sentence for every two clocks whose rates were compared: the weighted mean over the runs.

    Examples
    --------
    >>> from stiffcal.reduction.clocks.offsets import SourceClockOffset
    >>> clock_rates([{"tracker": SourceClockOffset(0.2, 1e-3, "", 3e-5, 1e-5, "ft")}])[0].words
    ('the clock of tracker gains +30 ± 20 ppm on that of ft',)
    """
    sums: dict[tuple[str, str], list[float]] = {}
    for clocks in runs:
        for source, clock in clocks.items():
            if clock.rate is None or not clock.rate_std:
                continue
            weight = clock.rate_std**-2
            total = sums.setdefault((source, clock.rate_against), [0.0, 0.0, 0.0])
            for k, value in enumerate((1.0, weight, weight * clock.rate)):
                total[k] += value
    texts = [
        f"the clock of {source} gains {RATE.usual.factor * product / weight:+.0f} ± "
        f"{RATE.usual.factor * NORMAL_95 / sqrt(weight):.0f} {RATE.usual.name} on "
        f"that of {against}" + (f", mean of {count:.0f} runs" if count > 1 else "")
        for (source, against), (count, weight, product) in sums.items()
    ]
    return [Sentence((text,), "clock-rate") for text in texts]
