"""What was set aside is asked again about the last model, without the searches that say nothing of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.states import StatesOfCampaign
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.states.mistake import StateMistake
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
    assert campaign.asked_again(WITHOUT_MEMBERS, fit, frozenset({Off(4)})).keys() == {Off(4)}
    assert asked == {mistake.name for mistake in mistakes_of(StateMistake) if mistake.inside_a_run}
