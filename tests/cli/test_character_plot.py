"""Points in characters: where they lie, how large the picture is, and what its axes say."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.cli.character_plot import HEIGHT, WIDTH, plot_points

LABELS = ("torque on joint 4 [N·m]", "residual [mm]")


def drawn(lines: list[str]) -> list[str]:
    """Return the rows of the picture, without numbers and axis."""
    return [line.split("┤" if "┤" in line else "│")[1] for line in lines[1 : HEIGHT + 1]]


def dots(text: str) -> int:
    return sum((ord(sign) - 0x2800).bit_count() for sign in text if 0x2800 <= ord(sign) < 0x2900)


@pytest.mark.parametrize("width", [40, 60, 80, 200])
def test_the_picture_fits_and_names_its_axes_with_units(width: int) -> None:
    x = np.linspace(-103.0, 99.5, 500)
    lines = plot_points(x, 0.3 * np.sign(x), LABELS, width)
    assert len(lines) <= 12
    assert all(len(line) <= max(width, len(lines[0])) for line in lines)
    assert lines[0] == "residual [mm] over torque on joint 4 [N·m]"
    assert lines[-1].split() == ["−103", "0", "99.5"]
    assert [line.split()[0] for line in lines if "┤" in line] == ["0.300", "0", "−0.300"]


def test_points_lie_where_they_are() -> None:
    corners = plot_points(np.array([0.0, 1.0, 0.0]), np.array([1.0, -1.0, -1.0]), LABELS)
    rows = drawn(corners)
    assert dots(rows[0][0]) == 1
    assert dots(rows[-1][0]) == 1
    assert dots(rows[-1][WIDTH - 1]) == 1
    assert dots("".join(rows)) == 3


def test_a_jump_at_zero_is_a_jump() -> None:
    x = np.linspace(-1.0, 1.0, 400)
    rows = drawn(plot_points(x, np.sign(x), LABELS))
    assert dots(rows[0][: WIDTH // 2]) == 0
    assert dots(rows[-1][WIDTH // 2 :]) == 0
    assert all(dots(row) == 0 for row in rows[1:-1])
    assert set(rows[round((HEIGHT - 1) / 2)]) == {"·"}


def test_what_is_not_known_is_left_out_and_one_value_has_room() -> None:
    rows = drawn(plot_points(np.array([1.0, np.nan, 1.0]), np.array([2.0, 1.0, np.inf]), LABELS))
    assert dots("".join(rows)) == 1
