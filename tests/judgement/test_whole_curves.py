"""A curve of torque over angle holds the spring of its joint: hypotheses without the curve have that spring."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.effects.encoder_drift import EncoderDrift
from stiffcal.identification.fitting.regressors import Regressor
from stiffcal.judgement.ground import is_of
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Place
from stiffcal.model.forms import form_of
from stiffcal.stages.steps import RunContext
from tests.rates.benches import player_of, write_bench
from tests.rates.playing import CLASSES
from tests.rates.workers import BENCHES

pytestmark = pytest.mark.long


def written(folder: Path, number: int, seed: int = 8123, kind: str = "clamped two") -> set[str]:
    """Write a bench; return the names of its hidden laws."""
    rng = np.random.default_rng([seed, (*CLASSES, *BENCHES).index(kind), number])
    return {name for name, _ in write_bench(folder, kind, rng, player_of(kind, number)).hidden}


def test_a_curve_is_as_probable_in_each_form(tmp_path: Path) -> None:
    """What is of any size is so in one unit: a rigidity in place of a compliance was worth 23 nats."""
    hidden = written(tmp_path / "bench", 4)
    found = diagnose_campaign(tmp_path / "bench", RunContext())
    assert {one.effect for one in found.missing} == hidden
    assert all(one.firm for one in found.missing)


def test_what_another_shape_explains_is_not_missing(tmp_path: Path) -> None:
    """A second slope at the width of a play was certain next to it, as the play's band was sought with it alone."""
    hidden = written(tmp_path / "bench", 23)
    found = diagnose_campaign(tmp_path / "bench", RunContext())
    assert {one.effect for one in found.missing} == hidden


def test_a_refitted_rival_has_the_share_of_its_own_shape(tmp_path: Path) -> None:
    """With the share of a shape that it had left, and each shape counted, a second slope was certain for a play."""
    hidden = written(tmp_path / "bench", 0, seed=8124)
    found = diagnose_campaign(tmp_path / "bench", RunContext())
    assert {one.effect for one in found.missing if one.firm} <= hidden


def test_nothing_is_certain_next_to_as_much_that_is_not_explained(tmp_path: Path) -> None:
    """A curve of half of the noise was certain where five noises were left, as no law of the catalogue was there."""
    written(tmp_path / "bench", 2, seed=8127, kind="clamped outside")
    found = diagnose_campaign(tmp_path / "bench", RunContext())
    assert found.unexplained
    assert not any(one.firm for one in found.missing)


def test_a_curve_that_is_not_needed_leaves_its_spring(tmp_path: Path) -> None:
    """A spring was said to be missing, and certain, as the hypothesis without the curve had none."""
    folder = tmp_path / "bench"
    hidden = written(folder, 31)
    for effect in hidden:
        edit_model(folder, "add", effect, where={"joints": "1"})
    edit_model(folder, "add", "cubic-stiffness", where={"joints": "1"}, start={"p1": 184800.0, "p2": 0.0, "p3": 0.0})
    found = diagnose_campaign(folder, RunContext())
    assert found.missing == []
    assert [one.effect for one in found.superfluous] == ["cubic-stiffness"]


@pytest.mark.parametrize("symbol", ["rad_per_s", "rad_per_K"])
def test_a_law_of_the_model_is_that_of_its_own_form(symbol: str) -> None:
    drift, joint = EncoderDrift(), Place("joints", (1,))
    placed = PlacedEffect(form_of(drift, [symbol]), joint, {symbol: 1e-6})
    same = {
        other: is_of(
            Regressor(form_of(drift, [other]), joint, {}, (other,), np.zeros((1, 1, 1)), np.zeros((1, 1))), placed
        )
        for other in ("rad_per_s", "rad_per_K")
    }
    assert [other for other, one in same.items() if one] == [symbol]
