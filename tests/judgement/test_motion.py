"""What is assumed of moving joints before any reading, and laws that nobody has written down."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.judgement.motion_sizes import MotionSizes
from stiffcal.judgement.rows import RowsOfCampaign
from stiffcal.judgement.unlisted_motion import FUNCTIONS, _left_of, unlisted_motion_laws
from stiffcal.kinds.row_search import UsualMotion
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.hidden_friction import nothing, problem_of

JOINT = Place("joints", (1,))


def typical(name: str, symbol: str, torque: float, speed: float, **shape: float) -> float:
    sizes = MotionSizes({1: UsualMotion(torque, speed)})
    return sizes.typical(built_in_effects()[name], JOINT, symbol, shape)


@pytest.mark.parametrize(
    "name", ["stribeck", "friction-temperature", "friction-load", "torque-ripple", "joint-friction"]
)
def test_sizes_of_a_typical_drive_are_the_catalogues(name: str) -> None:
    effect = built_in_effects()[name]
    for spec in effect.parameters:
        assert typical(name, spec.symbol, 50.0, 0.5) == pytest.approx(abs(spec.typical)), spec.symbol


def test_sizes_grow_with_the_friction_and_make_the_same_share_of_it_at_any_speed() -> None:
    assert typical("stribeck", "stribeck", 5.0, 0.1) == pytest.approx(0.1 * typical("stribeck", "stribeck", 50.0, 0.5))
    assert 0.1 * typical("joint-friction", "viscous", 50.0, 0.1) == pytest.approx(50.0)
    shares = [typical("viscous-power", "factor", 50.0, v, power=p) * v**p for v in (0.05, 0.5) for p in (0.3, 2.0)]
    assert shares == pytest.approx([shares[0]] * 4)


def test_laws_follow_what_was_logged() -> None:
    """Of a joint without weight, and once without a temperature."""
    for temperature in (True, False):
        problem = problem_of(nothing, temperature=temperature)
        laws = list(unlisted_motion_laws(problem.fit(problem.robot).maker, (1,)))
        absent = {"the torque of its weight"} if temperature else {"the torque of its weight", "its temperature"}
        assert {law.follows for law in laws} == set(FUNCTIONS) - absent
        for law in laws:
            assert law.place == "joint 1"
            assert len(law.columns) <= 30
            assert np.isfinite(law.columns).all()


def test_the_speed_before_is_forgotten_and_a_slower_one_does_not_hide_it() -> None:
    time, speed = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.1, 2.0, 0.5, 0.1])
    left = _left_of(time, speed, np.arange(4), 2.0)
    decay = np.exp(-0.5)
    assert left == pytest.approx([0.0, 0.1 * decay, 2.0 * decay, 2.0 * decay**2])


def test_what_is_missing_in_all_is_shared_by_all_joints_that_moved() -> None:
    problem = problem_of(nothing)
    alone, of_six = (RowsOfCampaign.of(problem, built_in_effects(), joints) for joints in (1, 6))
    odds, shares = [], list[float | None]()
    for rows in (alone, of_six):
        shares.clear()
        judged = rows.judged(problem.fit(problem.robot), frozenset(), 1, lambda _, share: shares.append(share))
        odds.append({one.name: one.log_prior for one in judged.members if one.name == "friction-asymmetry j1"})
    expected = [np.exp(one["friction-asymmetry j1"]) / (1.0 + np.exp(one["friction-asymmetry j1"])) for one in odds]
    assert expected[0] == pytest.approx(6.0 * expected[1])
    # each candidate and each member is a step of the progress, which never goes back
    assert len(shares) > len(of_six.candidates) + len(judged.members)
    assert [share for share in shares if share is not None] == sorted(share or 0.0 for share in shares)
