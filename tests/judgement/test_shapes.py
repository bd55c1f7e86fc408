"""The share that a shape stands for, of all shapes of a law."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stiffcal.effects.periodic_stiffness import PeriodicStiffness
from stiffcal.effects.stribeck import Stribeck
from stiffcal.identification.fitting.regressors import Regressor
from stiffcal.judgement.shapes import _of_grid
from stiffcal.model.effect import Effect

VALUES = np.array([2.0, 5.0, 4.6, 0.0])


def shapes(effect: Effect) -> list[Regressor]:
    return [cast("Regressor", SimpleNamespace(effect=effect, shape={"order": float(k)})) for k in range(len(VALUES))]


@pytest.mark.parametrize("own", range(len(VALUES)))
def test_the_members_of_a_law_stand_for_all_its_shapes_once(own: int) -> None:
    """Where another order is better than the model's there are two members, which share what all orders have."""
    found = _of_grid(shapes(PeriodicStiffness()), VALUES, own)
    assert [int(one.regressor.shape["order"]) for one in found] == ([1] if own == 1 else [own, 1])
    whole = np.logaddexp.reduce([one.log_share + VALUES[int(one.regressor.shape["order"])] for one in found])
    assert whole == pytest.approx(np.logaddexp.reduce(VALUES) - np.log(len(VALUES)))


def test_an_order_is_settled_as_far_as_no_other_is_probable() -> None:
    (best,) = _of_grid(shapes(PeriodicStiffness()), VALUES, 1)
    assert best.settled == pytest.approx(np.exp(VALUES[1]) / np.sum(np.exp(VALUES)))


def test_a_speed_between_those_of_the_grid_is_as_settled_as_any() -> None:
    (best,) = _of_grid(shapes(Stribeck()), VALUES, 1)
    assert best.settled == 1.0
