"""Pictures of a fit: what they draw is what they say."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.identification.profiles import REACH, Profile
from stiffcal.model.parameters import ParameterSpec
from stiffcal.presentation.pictures import Band, Marks
from stiffcal.results.fit_pictures import (
    MOST_PARAMETERS,
    correlation_picture,
    history_picture,
    influence_picture,
    normal_picture,
    profile_picture,
)


def marks_of(picture_panel: object) -> list[Marks]:
    return [one for one in picture_panel.series if isinstance(one, Marks)]  # type: ignore[attr-defined]


def outside(values: np.ndarray) -> float:
    """Return the share of drawn residuals outside the band of chance."""
    panel = normal_picture({"displacements": values}).panels[0]
    band = next(one for one in panel.series if isinstance(one, Band))
    (drawn,) = marks_of(panel)
    assert drawn.x.size <= 300
    return float(np.mean((drawn.y < band.low) | (drawn.y > band.high)))


def test_a_normal_sample_lies_in_the_band_and_heavy_tails_do_not() -> None:
    draw = np.random.default_rng(5)
    shares = [outside(draw.normal(size=60)) for _ in range(600)]
    # each point lies outside in 5 of 100; neighbours move together, so that samples scatter by more than their points
    assert np.mean(shares) == pytest.approx(0.05, abs=4.0 * float(np.std(shares)) / 600**0.5)
    assert np.std(shares) < 0.12
    assert np.mean([outside(1.3 * draw.normal(size=3000)) for _ in range(3)]) > 0.5
    assert np.mean([outside(draw.standard_t(2, size=3000)) for _ in range(3)]) > 0.1


def test_each_run_has_its_change_of_each_parameter() -> None:
    changes = np.random.default_rng(1).normal(size=(5, MOST_PARAMETERS + 2))
    changes[2, 3] = -40.0
    changes[4, 0] = np.nan
    names = [f"p{k}" for k in range(changes.shape[1])]
    panel = influence_picture(names, [f"run{k}" for k in range(5)], changes).panels[0]
    labels = {one.label: one for one in marks_of(panel) if one.label}
    assert labels.pop("determines a value alone").x.tolist() == [4.0]
    assert labels.pop("other parameters").y.tolist() != []
    assert len(labels) == MOST_PARAMETERS
    assert next(iter(labels)) == "p3"
    assert labels["p3"].y[2] == -40.0
    assert panel.x_names[2] == "run2"


def test_squares_are_as_large_as_correlations() -> None:
    covariance = np.array([[4.0, -1.8, 0.0], [-1.8, 1.0, 0.25], [0.0, 0.25, 1.0]])
    panel = correlation_picture(["a", "b", "c"], covariance).panels[0]
    sizes = {(one.x.item(), one.y.item()): (one.colour, one.size) for one in marks_of(panel)}
    assert {place: colour for place, (colour, _) in sizes.items()} == {(0.0, 1.0): 1, (1.0, 2.0): 0}
    assert [size for _, size in sizes.values()] == pytest.approx([2.7, 8.1])


def test_a_history_without_validation_says_so() -> None:
    none = np.full(2, np.nan)
    assert history_picture(["1", "2"], none, none, "error [mm]").panels[0].empty
    assert not history_picture(["1", "2"], np.array([np.nan, 0.1]), none, "error [mm]").panels[0].empty


@pytest.mark.parametrize(
    ("reach", "value", "low", "high", "interval"),
    [
        (REACH, 2.0, 1.0, 3.0, "2.0 ± 1.0"),
        (REACH, 2.0, 1.0, None, "2.00 (1.00 … beyond 5.60)"),
        (REACH, 2.0, None, None, "2.00 (beyond −1.60 … beyond 5.60)"),
        (1.0, 2.0, 1.5, None, "2.00 (above 1.50)"),
        (1.0, np.inf, 1.5, None, "above 1.50"),
    ],
)
def test_an_end_beyond_what_was_computed_is_no_open_end(
    reach: float, value: float, low: float | None, high: float | None, interval: str
) -> None:
    """A profile that ends at a bound, nearer than its reach, has an end that is open."""
    away = np.linspace(-reach, reach, 5)
    profile = Profile(
        "a.j1.x",
        ParameterSpec("x", "1", "", -9.0, 9.0, 1.0, ""),
        True,
        2.0 + away,
        0.2 * away**2,
        away**2,
        3.84,
        value,
        low,
        high,
    )
    (panel,) = profile_picture([profile], {}).panels
    assert panel.title == f"a.j1.x\nby the profile: {interval}"
