"""What was set aside is asked again about the last model, without the searches that say nothing of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.diagnosis.answers.suspect_results import Suspect
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.states import StatesOfCampaign
from stiffcal.judgement.suspects import _inside_a_run
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.states.mistake import StateMistake
from stiffcal.mistakes.suspect_kinds import SuspectKind
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.rates.faults import draw_faulty

WITHOUT_MEMBERS: Any = SimpleNamespace(best=())


def test_mistakes_of_whole_runs_are_not_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = draw_faulty(np.random.default_rng(20261122), "pairs", "")
    fit = fit_observations(fit_problem(sound.states, sound.model), sound.model, Settings())
    campaign = StatesOfCampaign.of(sound.states, sound.model, fit, built_in_effects(), Settings(), True)
    asked = set[str]()
    for mistake in mistakes_of(StateMistake):

        def noted(left: Any, own: StateMistake = mistake, changes: Any = mistake.ways) -> Any:
            asked.add(own.name)
            return changes(left)

        monkeypatch.setattr(mistake, "ways", noted)
    assert campaign.asked_again(WITHOUT_MEMBERS, fit, frozenset({Off(4)})).probability.keys() == {Off(4)}
    assert asked == {mistake.name for mistake in mistakes_of(StateMistake) if mistake.inside_a_run}


@pytest.mark.parametrize(
    ("kind", "named"),
    [(SuspectKind.UNKNOWN, "knocked"), (SuspectKind.BUMP, "knocked"), (SuspectKind.UNIT, "unit")],
)
def test_a_mistake_inside_a_run_is_named_where_none_of_all_of_it_is(kind: SuspectKind, named: str) -> None:
    (knocked,) = (one for one in mistakes_of(StateMistake) if one.name == "target-moved")
    runs = [SimpleNamespace(name="a"), SimpleNamespace(name="b")]
    found: Any = SimpleNamespace(states=SimpleNamespace(runs=runs), judged=SimpleNamespace(mistakes={Off(1): knocked}))
    suspect = Suspect(run="b", row=None, kind=kind, why="", likely="first", factor=None, without=None)
    assert _inside_a_run(suspect, found).kind == named
    assert (_inside_a_run(suspect, found).likely == "first") is (kind is SuspectKind.UNIT)
