"""Each stress class draws what it says, and a class is judged, kept and counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Place
from tests.calibration.__main__ import main
from tests.calibration.answers import Answer, Named, is_good
from tests.calibration.field_mix import SIZES
from tests.calibration.stress.assumptions import common_noise, heavy_tails
from tests.calibration.stress.classes import CLASSES, RECIPES, draw_stress
from tests.calibration.stress.laws import HertzContact
from tests.laboratory.random_robots import draw_robot
from tests.rates.hiding import with_effects
from tests.rates.measuring import Player, move
from tests.rates.mujoco_player import can_be_played
from tests.rates.plans import spreadsheet
from tests.rates.playing import joint_springs

NAN = float("nan")
BY_SIZE = [name for name in CLASSES if name.startswith(("robot-", "law-")) or RECIPES[name].scaled]
"""Classes in which what is wrong is made as large as drawn."""


@pytest.mark.parametrize("name", list(CLASSES))
def test_a_class_is_drawn(name: str) -> None:
    campaign = draw_stress(name, 1, 0)
    assert np.isfinite(campaign.sizes).all()
    assert campaign.n_readings > 0
    if name.startswith("law-"):
        assert [one.effect.name for one in campaign.hidden] == [name.removeprefix("law-")]
    if name.startswith("mistake-"):
        assert campaign.category == "mistake"
        assert set(campaign.runs) <= set(campaign.states.run.tolist())
        assert campaign.runs
    if name in BY_SIZE:
        assert all(0.95 * SIZES[0] <= size <= 1.05 * SIZES[1] for size in campaign.sizes)


def test_a_campaign_follows_from_class_and_number() -> None:
    one, again, other = (draw_stress(name, 1, 0) for name in ("robot-wall", "robot-wall", "robot-ceiling"))
    np.testing.assert_array_equal(one.states.position, again.states.position)
    assert not np.array_equal(one.model.chain.link_mass, other.model.chain.link_mass)


@pytest.mark.parametrize("scatter", [heavy_tails, common_noise])
def test_broken_noise_has_the_same_size(scatter: Callable[[np.random.Generator], np.random.Generator]) -> None:
    drawn = scatter(np.random.default_rng(3)).normal(size=(200_000, 3))
    assert np.quantile(np.abs(drawn), 0.5) < 0.68
    assert np.std(drawn) == pytest.approx(1.0, abs=0.05)


def test_common_noise_moves_the_axes_together() -> None:
    drawn = common_noise(np.random.default_rng(3)).normal(size=(20_000, 3))
    np.testing.assert_allclose(np.asarray(np.corrcoef(drawn.T))[np.triu_indices(3, 1)], 0.8, atol=0.02)


def test_mujoco_and_the_balance_agree_on_a_law_outside() -> None:
    """Hertz contact in both: the laws are written twice."""
    number = next(k for k in range(20) if draw_stress("law-hertz-contact", 1, k).player == "balance")
    campaign = draw_stress("law-hertz-contact", 1, number)
    assert isinstance(campaign.hidden[0].effect, HertzContact)
    assert can_be_played(campaign.hidden[0])
    robot = draw_robot(np.random.default_rng(5))
    plan = spreadsheet(np.random.default_rng(5), robot, True, False)
    springs = joint_springs(robot)
    place = Place("joints", (2,))
    whole = with_effects(springs, PlacedEffect(HertzContact(), place, {"c": 1e-6}))
    players: tuple[Player, ...] = ("balance", "mujoco")
    by_balance, by_mujoco = (move(player, plan, springs, whole).moved for player in players)
    np.testing.assert_allclose(by_mujoco, by_balance, atol=2e-6)


def test_what_can_be_seen_to_be_broken_may_be_unexplained() -> None:
    number = next(k for k in range(20) if draw_stress("broken-gravity", 1, k).category == "nothing")
    campaign = draw_stress("broken-gravity", 1, number)
    unexplained = Answer((), True, (), NAN, NAN, 0.0)
    assert is_good(campaign, unexplained)
    assert not is_good(replace(campaign, visible=False), unexplained)
    assert not is_good(campaign, replace(unexplained, named=(Named(("creep j1",), NAN, (), False),)))


@pytest.mark.long
def test_a_class_is_judged_kept_and_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["evidence", "--stress", "robot-scara", "--count", "1", "--workers", "1", "--to", str(tmp_path)]
    assert main(asked) == 0
    first = capsys.readouterr().out
    kept = tmp_path / "evidence-robot-scara-1.jsonl"
    before = kept.read_text(encoding="utf-8")
    assert before.count("\n") == 1
    assert main(asked) == 0
    assert capsys.readouterr().out == first
    assert kept.read_text(encoding="utf-8") == before
