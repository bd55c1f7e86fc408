"""The generator keeps what it promises: sizes, places, loads, offsets, and the scores count what they should."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from stiffcal.identification.derivatives.observation import observe
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.judgement.document import explaining_run
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.laboratory.few_effects import FEW
from tests.rates.__main__ import table_of
from tests.rates.intervals import clopper_pearson, highest
from tests.rates.playing import CLASSES, Hidden, Ruler, simulate_runs
from tests.rates.scoring import judge_campaign, name_of


def drawn(kind: str, number: int = 0, only: str = "") -> Hidden:
    return simulate_runs(kind, np.random.default_rng([11, CLASSES.index(kind), number]), only)


def springs_of(campaign: Hidden) -> CompliantRobot:
    """Return the truth without what is hidden."""
    kept = tuple(one for one in campaign.truth.placed if one.effect.name == "joint-compliance")
    return CompliantRobot(campaign.truth.chain, kept)


@pytest.mark.parametrize("kind", ["one 4x", "one 0.5x", "outside 1x"])
def test_effects_have_their_size(kind: str) -> None:
    campaign = drawn(kind)
    data = observe(campaign.states, campaign.truth.chain)
    ruler = Ruler.of(springs_of(campaign), data, campaign.noise)
    for one, size in zip(campaign.hidden, campaign.sizes, strict=True):
        # The ruler of the draw has no wrench noise, and bumped readings in it.
        assert ruler.size(one) == pytest.approx(size, rel=0.05)


def test_loads_are_never_hit_exactly() -> None:
    states = drawn("none").states
    size = np.linalg.norm(states.wrench[:, :3], axis=1)
    assert len(np.unique(np.round(size, 6))) == len(size)
    assert 8 <= len(states.runs) <= 14


def test_draws_differ_by_seed_and_repeat() -> None:
    first, again, other = drawn("one 1x"), drawn("one 1x"), drawn("one 1x", 1)
    assert np.array_equal(first.states.position, again.states.position)
    assert len(first.states) != len(other.states) or not np.array_equal(first.states.wrench, other.states.wrench)


def test_outside_is_outside() -> None:
    for number in range(6):
        (hidden,) = drawn("outside 4x", number).hidden
        assert hidden.effect.name not in built_in_effects()


def test_a_slip_is_found_where_it_was() -> None:
    """A force sensor that is zeroed anew in one pose does what a slip does: the run is named, and the slip with it."""
    campaign = drawn("seat-shift")
    search = diagnose_states(campaign.states, campaign.model, built_in_effects())
    run = int(campaign.states.run[round(campaign.hidden[0].values["state"]) - 1])
    as_slip = [one.candidate.name for one in search.found] == ["seat-shift setup"]
    as_run = "seat-shift" in [effect.effect for effect in explaining_run(search, run)]
    assert as_slip or ({off.run for off in search.doubted} == {run} and as_run)


@pytest.mark.practice
def test_a_slip_is_found_where_the_first_reading_of_a_run_was_set_aside() -> None:
    """A step before all readings in use is the run's offset, whose rounding must not come before true steps."""
    kind = "seat-shift"
    campaign = simulate_runs(kind, np.random.default_rng([20261123, CLASSES.index(kind), 11]))
    firsts = {int(np.flatnonzero(campaign.states.run == run)[0]) for run in np.unique(campaign.states.run)}
    assert firsts & set(np.flatnonzero(~campaign.states.used).tolist())
    assert judge_campaign(campaign).outcome == "right"


def test_a_motor_that_is_pushed_off_is_named() -> None:
    """The joint's own log says by how much: an effect without a parameter, judged as the others are."""
    campaign = drawn("servo")
    search = diagnose_states(campaign.states, campaign.model, built_in_effects())
    assert [one.candidate.name for one in search.found] == [name_of(campaign.hidden[0])]
    trial = search.trial_of(search.found[0].candidate)
    assert trial is not None
    # What a right candidate predicts is what the error falls by: |e|² − |e − d|² is |d|² on average.
    fall = float(np.sum(search.first.base.heldout - trial.score.heldout))
    assert float(np.sum(trial.score.prediction_change)) == pytest.approx(fall, rel=0.1)


@pytest.mark.practice
def test_a_wandering_target_is_not_noise() -> None:
    """Repeats lie a cycle apart: a random walk in between looks like their noise, and hides the lack of fit."""
    campaign = next(
        one for one in map(partial(drawn, "outside 4x"), range(100)) if one.hidden[0].effect.name == "wander"
    )
    search = diagnose_states(campaign.states, campaign.model, built_in_effects())
    assert search.unexplained
    assert not any(one.group.firm for one in search.found)


def test_the_score_counts() -> None:
    others = built_in_effects().keys() - {*FEW, "base-compliance", "tool-compliance"}
    campaign = drawn("one 4x", only="base-compliance")
    verdict = judge_campaign(campaign, without=others)
    assert verdict.outcome in ("right", "look-alike")
    assert verdict.good
    assert verdict.hidden.startswith("base-compliance setup")
    assert "one 4x" in table_of([verdict])
    assert name_of(campaign.hidden[0]) == "base-compliance setup"


def test_exact_intervals() -> None:
    """The closed form where all or none are good, and 8 of 20 by tables: 19.1 to 63.9 %."""
    assert clopper_pearson(10, 10) == pytest.approx((0.025 ** (1 / 10), 1.0))
    assert clopper_pearson(0, 50) == pytest.approx((0.0, 1.0 - 0.025 ** (1 / 50)))
    assert clopper_pearson(8, 20) == pytest.approx((0.191, 0.639), abs=1e-3)
    assert clopper_pearson(0, 0) == (0.0, 1.0)
    assert highest(0, 148) == pytest.approx(1.0 - 0.05 ** (1 / 148))
