"""What data do not identify is put together by its typed cause, whatever the sentences are."""

from __future__ import annotations

from stiffcal.estimation.undetermined import Undetermined
from stiffcal.identification.answers.fit_results import UnidentifiedParameters
from stiffcal.results.unidentified_words import unidentified_in_words


def group(name: str, reason: str, cause: Undetermined | None) -> UnidentifiedParameters:
    return UnidentifiedParameters(parameters=[name], known=None, reason=reason, cause=cause)


def test_one_cause_is_one_sentence_and_like_words_of_two_causes_are_two() -> None:
    groups = [
        group("e.j1.c", "nothing moves it", Undetermined.NO_LOAD),
        group("e.j2.c", "nothing moves it", Undetermined.UNDRIVEN),
        group("e.j3.c", "nothing moves it at all", Undetermined.NO_LOAD),
        group("f.j1.c", "nothing moves it", Undetermined.NO_LOAD),
        group("e.j4.c", "nothing moves it", None),
    ]
    assert unidentified_in_words(groups) == [
        "each of e.j1.c and e.j3.c: nothing moves it",
        "e.j2.c: nothing moves it",
        "f.j1.c: nothing moves it",
        "e.j4.c: nothing moves it",
    ]


def test_every_cause_has_its_own_sentence() -> None:
    assert len({cause.sentence for cause in Undetermined}) == len(Undetermined)
