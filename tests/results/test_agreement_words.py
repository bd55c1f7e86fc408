"""How two kinds of experiment are called where a fit says whether they agree."""

from __future__ import annotations

from stiffcal.identification.answers.agreement_results import Agreement
from stiffcal.results.agreement_words import runs_of_kinds


def agreement(first: str, second: str) -> Agreement:
    return Agreement(
        first=first,
        second=second,
        parameters=[],
        statistic=1.0,
        dof=1,
        p_value=0.3,
        agree=True,
        reduced_chi2=[1.0, 1.0],
    )


def test_kinds_are_called_as_their_folders_say() -> None:
    assert runs_of_kinds(agreement("loads", "absolute")) == ("load runs", "absolute poses")


def test_a_kind_that_is_not_installed_is_called_by_its_name() -> None:
    """A store that another installation wrote may hold one."""
    assert runs_of_kinds(agreement("clamped", "hanging")) == ("clamped runs", "hanging")
