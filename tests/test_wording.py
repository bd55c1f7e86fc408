"""Estimates and units as people read them, the same in terminal, report, view and Python."""

from __future__ import annotations

import re

import pytest

from stiffcal.quantity import quantity_of
from stiffcal.wording import estimate


def _read(text: str) -> list[float]:
    """Return the numbers of an estimate as printed, the common power of ten applied."""
    body, _, power = text.replace("−", "-").partition("·10")
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    scale = 10.0 ** int(power.translate(digits)) if power else 1.0
    return [scale * float(number) for number in re.findall(r"-?\d+\.?\d*", body)]


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 1.0, 999.7, 2.7e6, 9.996e11])
@pytest.mark.parametrize(("low", "high"), [(0.76, 1.48), (0.99996, 1.0002), (-0.3, 9.0), (1.0, 1.4), (0.2, 60.0)])
def test_a_lopsided_interval_keeps_both_distances(scale: float, low: float, high: float) -> None:
    """Printed ends lie off the value by the true distances, to a twentieth of the nearer one, and never coincide."""
    value, first, last = _read(estimate(scale, (low * scale, high * scale)))
    nearest = scale * min(side for side in (1.0 - low, high - 1.0) if side > 0.0)
    assert value - first == pytest.approx((1.0 - low) * scale, abs=0.101 * nearest)
    assert last - value == pytest.approx((high - 1.0) * scale, abs=0.101 * nearest)
    assert first < last


@pytest.mark.parametrize("half", [0.0995, 0.02, 3e-5])
def test_a_symmetric_interval_is_one_half_width_of_two_digits(half: float) -> None:
    text = estimate(2.7e6, (2.7e6 * (1.0 - half), 2.7e6 * (1.0 + half)))
    assert "±" in text
    assert _read(text)[1] == pytest.approx(2.7e6 * half, rel=0.06)


def test_an_open_end_is_named_and_no_interval_prints_the_value_alone() -> None:
    assert estimate(2.06e5, (1.06e5, None)) == "2.06 (above 1.06)·10⁵"
    assert estimate(2.06e5, (None, 3.1e5)) == "2.06 (below 3.10)·10⁵"
    assert estimate(2.06e5, (None, None)) == "2.06·10⁵"
    # what is zero has no digits, however small the end is
    assert estimate(0.0, (None, 3.1e-4)) == "0 (below 0.000310)"
    assert estimate(0.5, (None, 12.0)) == "0.500 (below 12.0)"


@pytest.mark.parametrize(
    ("unit", "follows", "printed", "value"),
    [
        ("rad", None, "mrad", 2.0e-3), ("m", None, "mm", 2.0e-3), ("rad/(N*m)", None, "µrad/(N·m)", 2.0e-6),
        ("m/N", None, "µm/N", 2.0e-6), ("N/m", None, "N/µm", 2.0e6), ("m/s or m/K", "time", "µm/h", 2.0e-6 / 3600.0),
        ("rad/s or rad/K", "temperature", "mrad/K", 2.0e-3), ("N*m", None, "N·m", 2.0), ("1", None, "", 2.0),
    ],
)  # fmt: skip
def test_a_printed_value_is_the_si_value_times_the_factor(
    unit: str, follows: str | None, printed: str, value: float
) -> None:
    shown = quantity_of(unit, follows).unit_for([value])
    assert shown.name == printed
    assert shown.factor * value == pytest.approx(2.0)
