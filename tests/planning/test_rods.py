"""Advice on rods: what they see, what not, and that the advised rod does what it promises."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.experiments.rods import Design, estimate_link, rod_design
from stiffcal.measurements.load_states import Floats
from stiffcal.measurements.rods import BeamShape, Rods
from stiffcal.planning import rods as planning_rods
from stiffcal.planning.rods import rods_can_see
from tests.experiments.test_rods import SHAPE, paper_rods, seven_rods


def with_advised(rods: Rods) -> Rods:
    best = rods_can_see(rods, SHAPE).advice[0]
    return Rods(
        rods.link, (*rods.names, "new"), np.vstack([rods.start, best.start]), np.vstack([rods.end, best.end]),
        np.vstack([rods.warping, [[np.nan, np.nan]]]), np.append(rods.sigma, 1e-6),
    )  # fmt: skip


def test_the_papers_pattern_is_blind_to_torsion_and_an_oblique_rod_is_advised() -> None:
    rods = paper_rods(1e-6)
    view = rods_can_see(rods, SHAPE)
    assert view.blind == ("torsion",)
    assert view.spare == 0
    assert np.isnan(view.std[3])
    best = view.advice[0]
    assert "torsion" in best.tells
    assert not np.allclose(best.start[1:], best.end[1:])
    assert estimate_link(with_advised(rods), SHAPE, np.zeros((1, 6))).torsion.identifiable
    assert any("no rod on swing sees it twist" in sentence for sentence in view.sentences)
    assert "would tell torsion" in view.sentences[-1]


def test_stated_uncertainty_is_that_of_the_estimate() -> None:
    rods = seven_rods(2e-6)
    view = rods_can_see(rods, SHAPE)
    covariance = estimate_link(rods, SHAPE, np.zeros((1, 7))).covariance
    np.testing.assert_allclose(view.std, np.sqrt(np.diag(covariance)), rtol=1e-9)
    assert view.stated


def test_rods_of_one_length_lack_the_moments() -> None:
    rods = paper_rods().pick([0, 1, 2])
    view = rods_can_see(rods, SHAPE)
    assert set(view.taken_as_absent) == {"tip moment 2", "tip moment 3"}
    assert any("taken for a force" in sentence for sentence in view.sentences)
    assert not view.stated
    assert "(assumed)" in view.sentences[1]


def test_no_rod_is_tried_through_the_hollow(monkeypatch: pytest.MonkeyPatch) -> None:
    outline = [np.array(corner) for corner in ((-0.12, -0.05), (0.12, -0.05), (0.12, 0.05), (-0.12, 0.05))]
    tried, try_it = [], planning_rods._with_one_more

    def noted(rods: Rods, shape: BeamShape, design: Design, start: Floats, end: Floats) -> planning_rods.ExtraRod:
        tried.append((start, end))
        return try_it(rods, shape, design, start, end)

    monkeypatch.setattr(planning_rods, "_with_one_more", noted)
    rods_can_see(paper_rods(), SHAPE, outline)
    assert len(tried) == 4 * 3 * 3
    for start, end in tried:
        assert np.count_nonzero(start[1:] != end[1:]) <= 1


def test_more_rods_steady() -> None:
    rods = seven_rods(1e-6)
    best = rods_can_see(rods, SHAPE).advice[0]
    assert best.gain_after < best.gain_before
    assert rod_design(with_advised(rods), SHAPE).gain == best.gain_after
