"""Profiles: a linear parameter has the parabola of its uncertainty, near a bound what is left of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.profiles import MOST_PROFILES, profiled, profiles
from stiffcal.measurements.load_states import Sigma
from stiffcal.uncertainty import NORMAL_95
from tests.laboratory.simulated_states import medium_robot, played


def test_a_compliance_of_nothing_has_an_interval_that_begins_at_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = medium_robot()
    (name, *_) = [placed.parameter_name("c") for placed in truth.placed]
    stiff = truth.with_values({name: 1e-12})
    fit = identify_parameters(played(stiff, noise=Sigma(15e-6, 2e-5), seed=3), truth)
    about, linearised = LoadRows.about, [0]

    def counted(*given: Any) -> LoadRows:
        linearised[0] += 1
        return about(*given)

    monkeypatch.setattr(LoadRows, "about", counted)
    (found,) = [one for one in profiles(fit) if one.name == name]
    # the fit itself, and three values to the side that is possible
    assert linearised[0] == 1 + 3
    assert not found.bends
    assert found.level == pytest.approx(NORMAL_95**2)
    assert found.low is None
    assert found.values[0] == 0.0
    std = float(np.sqrt(fit.covariance[0, 0]))
    # the law is linear: a parabola, whose least lies beyond the bound
    curvature, slope = np.polyfit(found.values[1:], found.rise[1:] / found.values[1:], 1)
    assert curvature == pytest.approx(std**-2, rel=0.2)
    assert slope > 0.0
    assert found.high is not None
    assert curvature * found.high**2 + slope * found.high == pytest.approx(found.level, rel=0.02)
    assert np.all(np.diff(found.rise) >= 0.0)


def test_parameters_far_from_bounds_have_no_profile() -> None:
    truth = medium_robot()
    fit = identify_parameters(played(truth, noise=Sigma(15e-6, 2e-5), seed=3), truth)
    assert profiles(fit) == []
    spread = dict(zip(fit.free_names, np.sqrt(np.diag(fit.covariance)).tolist(), strict=True))
    # a thousand times as uncertain, all reach the bound of 0
    assert len(profiled(fit.robot, {name: 1e3 * std for name, std in spread.items()})) == MOST_PROFILES
