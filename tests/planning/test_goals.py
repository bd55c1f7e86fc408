"""Designs for several goals in a mix."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.campaign.plan_file import PlanFile
from stiffcal.planning.campaign.choice import named_parameters
from stiffcal.planning.criterion import Criterion
from stiffcal.planning.design import VAGUE, best_design, information, loss_of
from stiffcal.planning.goals import Goal, mixed_design
from stiffcal.planning.information import RunInformation

FACTORS = np.random.default_rng(3).normal(size=(60, 3, 4)) * np.array([1.0, 2.0, 0.5, 1.0])
ROWS = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 0.2, 0.0, 0.0]])


def losses(chosen: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> tuple[float, float]:
    covariance = np.linalg.inv(information(FACTORS[chosen]).sum(axis=0) + np.eye(4) / VAGUE**2)
    return loss_of(covariance, Criterion.DETERMINANT), loss_of(covariance, Criterion.PREDICTION, ROWS)


def goals(share: float) -> list[Goal]:
    return [
        Goal(FACTORS, Criterion.DETERMINANT, None, None, share),
        Goal(FACTORS, Criterion.PREDICTION, None, ROWS, 1.0 - share),
    ]


def test_a_single_goal_is_its_own_design() -> None:
    alone = best_design(FACTORS, 8, Criterion.DETERMINANT, limit=2)
    mixed = mixed_design(goals(0.5)[:1], 8, limit=2)
    assert mixed.design.loss == pytest.approx(alone.loss, rel=1e-3)
    assert mixed.efficiencies[0] == pytest.approx(alone.efficiency, rel=2e-3)


def test_weights_decide_which_goal_is_served() -> None:
    mostly_first, mostly_second = (mixed_design(goals(share), 8, limit=2) for share in (0.9, 0.1))
    first, second = losses(mostly_first.design.chosen), losses(mostly_second.design.chosen)
    assert first[0] < second[0]
    assert first[1] > second[1]
    assert mostly_first.efficiencies[0] > mostly_second.efficiencies[0]
    # what is printed is what the design has: a bound of each goal over its loss
    for mixed, found in ((mostly_first, first), (mostly_second, second)):
        assert mixed.design.loss == pytest.approx(
            np.exp(np.array([0.9, 0.1] if mixed is mostly_first else [0.1, 0.9]) @ np.log(found))
        )
        assert (np.array(mixed.efficiencies) <= 1.0).all()


def test_a_nonlinear_parameter_is_a_goal_only_where_plan_toml_names_it() -> None:
    none = np.zeros((1, 1, 2))
    names, scale, nonlinear = ("backlash.j4.width", "backlash.j4.band"), np.ones(2), np.array([False, True])
    information = RunInformation(names, scale, none, scale, scale, nonlinear, none[:, :, :0])
    assert named_parameters(PlanFile.model_validate({}), information).tolist() == [True, False]
    named = PlanFile.model_validate({"parameters": ("backlash.j4.band",)})
    assert named_parameters(named, information).tolist() == [False, True]
