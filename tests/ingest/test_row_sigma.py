"""Uncertainties that stand in columns: rows that are known less count less, in the fit and after the store."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.errors import InputError
from stiffcal.reduction.registration.registering import in_instrument_axes
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.small_campaign import NOISE_M, STIFFNESS, write_small_campaign

POOR = 40.0
"""How much less every third row is known than the others."""
X, RX = 10, 13  # the columns of the small campaign's table: X, Y, Z, then the rotation vector


def with_poor_rows(folder: Path, columns: str, cells: tuple[str, str] = ("", "")) -> Path:
    """Make every third row of a small campaign poor, and state each row's uncertainty in mm and rad."""
    write_small_campaign(folder)
    table = folder / "raw" / "states.csv"
    header, *lines = table.read_text(encoding="utf-8").splitlines()
    rng = np.random.default_rng(3)
    rows = [f"{header},sx,sy,sz,sr"]
    for k, line in enumerate(lines):
        values, poor = line.split(","), POOR if k % 3 == 2 else 1.0
        if poor > 1.0:
            for column, size in [(X + a, 1e3 * NOISE_M) for a in range(3)] + [(RX + a, 2e-5) for a in range(3)]:
                values[column] = f"{float(values[column]) + poor * size * rng.standard_normal():.9g}"
        sigma = [f"{1e3 * NOISE_M * poor:.6g}"] * 3 + [f"{2e-5 * poor:.6g}"]
        if k == 7 and cells[0]:
            sigma[["sx", "sy", "sz", "sr"].index(cells[0])] = cells[1]
        rows.append(",".join([*values, *sigma]))
    table.write_text("\n".join(rows) + "\n", encoding="utf-8")
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8").replace(
        'rotvec = ["rx", "ry", "rz"]', f'rotvec = ["rx", "ry", "rz"]{columns}'
    )
    manifest.write_text(text, encoding="utf-8")
    return folder


COLUMNS = '\nsigma = { position = ["sx", "sy", "sz"], rotation = "sr" }'
ALIKE = "\nsigma = { position = 0.23, rotation = 4.6e-4 }"


def worst_error(folder: Path) -> tuple[float, float]:
    """Return the largest relative error of a joint's stiffness, and the largest relative standard uncertainty."""
    fit = identify_campaign(folder)
    pairs = [(fit.parameter(f"joint-compliance.j{k + 1}.c"), 1.0 / truth) for k, truth in enumerate(STIFFNESS)]
    errors = [abs((one.value or np.inf) / truth - 1.0) for one, truth in pairs]
    return max(errors), max((one.std or np.inf) / truth for one, truth in pairs)


def test_rows_that_are_known_less_count_less(tmp_path: Path) -> None:
    error, std = worst_error(with_poor_rows(tmp_path / "columns", COLUMNS))
    error_alike, std_alike = worst_error(with_poor_rows(tmp_path / "alike", ALIKE))
    assert std < 0.2 * std_alike
    assert error < 4.0 * std < error_alike


def test_the_store_keeps_them(tmp_path: Path) -> None:
    folder = with_poor_rows(tmp_path / "c", COLUMNS)
    up_to_date_states(folder, RunContext())
    states = up_to_date_states(folder, RunContext(update=False)).states
    np.testing.assert_allclose(states.sigma[1, 0], [NOISE_M] * 3 + [2e-5] * 3, rtol=1e-5)
    np.testing.assert_allclose(states.sigma[2, 0], [POOR * NOISE_M] * 3 + [POOR * 2e-5] * 3, rtol=1e-5)
    assert states.setup.sigma.translation == pytest.approx(np.sqrt(np.nanmean(states.sigma[:, :, :3] ** 2)))


def test_a_tracker_s_uncertainty_grows_with_distance(tmp_path: Path) -> None:
    folder = with_poor_rows(tmp_path / "c", "\nsigma = { position = 0.02, per_metre = 0.006, rotation = 4.6e-4 }")
    states = up_to_date_states(folder, RunContext()).states
    distance = np.linalg.norm(in_instrument_axes(states).position, axis=2)
    assert np.ptp(distance) > 0.1
    np.testing.assert_allclose(states.sigma[:, :, :3], (2e-5 + 6e-6 * distance[..., None]).repeat(3, axis=2), rtol=1e-9)
    assert np.isnan(states.sigma[:, :, 3:]).all()
    assert states.setup.sigma.rotation == pytest.approx(4.6e-4)


@pytest.mark.parametrize("cell", ["0", "-0.01", "nan"])
def test_an_uncertainty_that_is_none_is_refused_with_its_row(tmp_path: Path, cell: str) -> None:
    folder = with_poor_rows(tmp_path / "c", COLUMNS, ("sy", cell))
    with pytest.raises(InputError, match="row 8: the uncertainty of position of target"):
        up_to_date_states(folder, RunContext())


@pytest.mark.parametrize("sigma", ["0.0", '["sx", "sy"]', "true"])
def test_what_is_neither_a_number_nor_columns_is_refused(tmp_path: Path, sigma: str) -> None:
    folder = with_poor_rows(tmp_path / "c", f"\nsigma = {{ position = {sigma} }}")
    with pytest.raises(InputError, match="sigma"):
        up_to_date_states(folder, RunContext())
