"""Advice on rods: what they see, what not, and that the advised rod does what it promises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.links.rods import RodDesign, estimate_link, rod_design
from stiffcal.measurements.rods import BeamProperties, Rods, rods_between
from stiffcal.planning import rods as planning_rods
from stiffcal.planning.rods import rod_observability
from tests.links.test_rods import SHAPE, paper_rods, seven_rods


def with_advised(rods: Rods) -> Rods:
    best = rod_observability(rods, SHAPE).advice[0]
    return Rods(
        rods.link, (*rods.names, "new"), np.vstack([rods.start, best.start]), np.vstack([rods.end, best.end]),
        np.vstack([rods.warping, [[np.nan, np.nan]]]), np.append(rods.sigma, 1e-6),
    )  # fmt: skip


def test_the_papers_pattern_is_blind_to_torsion_and_an_oblique_rod_is_advised() -> None:
    rods = paper_rods(1e-6)
    view = rod_observability(rods, SHAPE)
    assert view.blind == ("torsion",)
    assert view.spare == 0
    assert np.isnan(view.std[3])
    best = view.advice[0]
    assert "torsion" in best.determines
    assert not np.allclose(best.start[1:], best.end[1:])
    assert estimate_link(with_advised(rods), SHAPE, np.zeros((1, 6))).torsion.identifiable
    assert any("no rod on swing measures its twist" in sentence for sentence in view.sentences)
    assert "would determine torsion" in view.sentences[-1]


def test_stated_uncertainty_is_that_of_the_estimate() -> None:
    rods = seven_rods(2e-6)
    view = rod_observability(rods, SHAPE)
    covariance = estimate_link(rods, SHAPE, np.zeros((1, 7))).covariance
    np.testing.assert_allclose(view.std, np.sqrt(np.diag(covariance)), rtol=1e-9)
    assert view.stated


def test_rods_of_one_length_lack_the_moments() -> None:
    rods = paper_rods().pick([0, 1, 2])
    view = rod_observability(rods, SHAPE)
    assert set(view.taken_as_absent) == {"tip moment 2", "tip moment 3"}
    assert any("interpreted as a force" in sentence for sentence in view.sentences)
    assert not view.stated
    assert "(assumed)" in view.sentences[1]


def test_no_rod_is_tried_through_the_hollow(monkeypatch: pytest.MonkeyPatch) -> None:
    outline = [np.array(corner) for corner in ((-0.12, -0.05), (0.12, -0.05), (0.12, 0.05), (-0.12, 0.05))]
    tried, try_it = [], planning_rods._try_extra_rod

    def noted(
        rods: Rods, shape: BeamProperties, design: RodDesign, start: Floats, end: Floats
    ) -> planning_rods.ExtraRod:
        tried.append((start, end))
        return try_it(rods, shape, design, start, end)

    monkeypatch.setattr(planning_rods, "_try_extra_rod", noted)
    rod_observability(paper_rods(), SHAPE, outline)
    assert len(tried) == 4 * 3 * 3
    for start, end in tried:
        assert np.count_nonzero(start[1:] != end[1:]) <= 1


def test_more_rods_steady() -> None:
    rods = seven_rods(1e-6)
    best = rod_observability(rods, SHAPE).advice[0]
    assert best.gain_after < best.gain_before
    assert rod_design(with_advised(rods), SHAPE).gain == best.gain_after


def box_rods(n: int, sigma: float = 1e-6) -> Rods:
    """Return rods all around a box, along it and across its sides, by turns."""
    turn = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    start = np.stack([np.full(n, 0.05), 0.12 * np.cos(turn), 0.1 * np.sin(turn)], axis=1)
    end = np.stack([np.full(n, 0.95), 0.12 * np.cos(turn + 0.8), 0.1 * np.sin(turn + 0.8)], axis=1)
    ends = np.where((np.arange(n) % 2 == 0)[:, None], end, np.column_stack([end[:, 0], start[:, 1:]]))
    return replace(rods_between("swing", start, ends), sigma=np.full(n, sigma))


@pytest.mark.parametrize("n", [12, 24])
def test_what_helps_by_less_than_a_tenth_is_not_advised(n: int) -> None:
    """Of a dozen rods all around, one more would make the end known a little better: nobody would mount it."""
    view = rod_observability(box_rods(n), SHAPE)
    assert view.blind == view.taken_as_absent == ()
    assert view.advice == ()
    assert len(view.sentences) == 2


@pytest.mark.parametrize("n", [7, 8, 9, 10])
def test_each_rod_advised_shows_something_or_steadies_by_a_tenth(n: int) -> None:
    advice = rod_observability(box_rods(n), SHAPE).advice
    assert len(advice) == 3
    for rod in advice:
        assert rod.determines or rod.gain_after < 0.9 * rod.gain_before
    # all carried unknowns: the best steadies most
    gains = [rod.gain_after for rod in advice if not rod.determines]
    assert gains == sorted(gains)


def test_a_rod_that_shows_is_advised_though_it_steadies_nothing() -> None:
    """An oblique rod shows the twist; what the corner rods carry, it makes no better by a tenth."""
    best = rod_observability(paper_rods(1e-6), SHAPE).advice[0]
    assert "torsion" in best.determines
    assert best.gain_after >= 0.9 * best.gain_before


def test_three_rods_are_advised_and_those_that_show_most_come_first() -> None:
    advice = rod_observability(paper_rods(1e-6).pick([0, 1, 2]), SHAPE).advice
    assert len(advice) == 3
    counts = [len(rod.determines) for rod in advice]
    assert counts == sorted(counts, reverse=True)
    same = [rod.gain for rod in advice if rod.determines == advice[0].determines]
    assert same == sorted(same)


def test_a_steadying_rod_is_advised_with_how_much_it_steadies() -> None:
    view = rod_observability(seven_rods(1e-6), SHAPE)
    best = view.advice[0]
    assert best.determines == ()
    times = best.gain_before / best.gain_after
    assert view.sentences[-1].endswith(f"would reduce the uncertainty of the end of swing by a factor of {times:.2g}")
    start = ", ".join(f"{1e3 * value:.0f}" for value in best.start)
    assert f"one more rod from [{start}] to [" in view.sentences[-1]
