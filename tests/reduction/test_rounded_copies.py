"""A table that was pasted twice, rounded the second time, is noticed; repeats of one load are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.reduction.copies.rounded import RoundedCopies
from tests.laboratory.displacement_table import (
    DISPLACEMENTS,
    FORCES,
    JOINTS,
    Columns,
    displacement_columns,
    write_displacement_campaign,
)

FACTORS = dict.fromkeys(JOINTS, np.pi / 180.0) | dict.fromkeys(FORCES, 1.0) | dict.fromkeys(DISPLACEMENTS, 1e-3)
NAMES = {"joints": JOINTS, "wrench": FORCES, "translation": DISPLACEMENTS}


def printed(columns: Columns, digits: tuple[int, int, int]) -> Columns:
    """Return the numbers as they read where angles, forces, displacements are printed with so many decimals."""
    of = dict.fromkeys(JOINTS, digits[0]) | dict.fromkeys(FORCES, digits[1]) | dict.fromkeys(DISPLACEMENTS, digits[2])
    return {name: np.array([float(f"{value:.{of[name]}f}") for value in values]) for name, values in columns.items()}


def pasted(*tables: Columns) -> Columns:
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def warned(columns: Columns) -> list[str]:
    found = RoundedCopies()
    signals = {signal: np.stack([FACTORS[name] * columns[name] for name in names]) for signal, names in NAMES.items()}
    n = len(columns["dx"])
    found.update("raw/table.csv", np.arange(1, n + 1), signals, NAMES, FACTORS)
    return found.warnings()


@pytest.mark.parametrize("fine", [(4, 3, 4), (3, 1, 3), (15, 15, 15)])
@pytest.mark.parametrize("coarse", [(2, 0, 3), (2, 0, 2), (1, 0, 1)])
@pytest.mark.parametrize("order", [1, -1])
def test_a_rounded_copy_is_named_with_its_rows(
    fine: tuple[int, int, int], coarse: tuple[int, int, int], order: int
) -> None:
    columns = displacement_columns()
    tables = [printed(columns, fine), printed(columns, coarse)]
    (warning,) = warned(pasted(*tables[::order]))
    assert "raw/table.csv rows" in warning
    rows = ("rows 25 to 48", "rows 1 to 24")[::order]
    assert warning.index(rows[0]) < warning.index(rows[1])


def test_only_displacements_rounded() -> None:
    columns = printed(displacement_columns(), (2, 1, 4))
    (warning,) = warned(pasted(columns, printed(columns, (2, 1, 2))))
    assert "rows 25 to 48 repeat" in warning


def test_a_few_rows_between_others() -> None:
    columns = printed(displacement_columns(), (3, 2, 3))
    some = {name: values[[3, 7, 8, 20]] for name, values in columns.items()}
    (warning,) = warned(pasted(columns, printed(some, (2, 1, 2))))
    assert "row 25 repeats raw/table.csv row 4" in warning
    assert "rows 26 to 27 repeat raw/table.csv rows 8 to 9" in warning


@pytest.mark.parametrize("coarse", [(2, 1, 2), (1, 0, 2)])
def test_few_rows_of_a_long_table(coarse: tuple[int, int, int]) -> None:
    """Copies that are two of a hundred rows."""
    columns = printed(displacement_columns(rows=600), (4, 3, 4))
    some = {name: values[100:112] for name, values in columns.items()}
    (warning,) = warned(pasted(columns, printed(some, coarse)))
    assert "raw/table.csv rows 601 to 612 repeat raw/table.csv rows 101 to 112" in warning


def test_three_digits_of_each_number() -> None:
    columns = printed(displacement_columns(rows=100), (3, 2, 3))
    for name in FORCES:
        columns[name] = columns[name] * 8.0  # up to 6 kN, of which three digits are tens
    short = {name: np.array([float(f"{value:.3g}") for value in values]) for name, values in columns.items()}
    (warning,) = warned(pasted(columns, short))
    assert "raw/table.csv rows 101 to 200" in warning


def test_rows_in_which_a_marker_is_hidden() -> None:
    columns = printed(displacement_columns(), (3, 2, 3))
    columns["dy"][::2] = np.nan
    (warning,) = warned(pasted(columns, printed(columns, (2, 1, 2))))
    assert "raw/table.csv rows 25 to 48 repeat raw/table.csv rows 1 to 24" in warning


@pytest.mark.parametrize("every", [2, 3])
def test_copies_with_gaps_are_one_entry(every: int) -> None:
    """Rows that were changed after the pasting stand between the copies."""
    columns = printed(displacement_columns(), (3, 2, 3))
    second = printed(columns, (2, 1, 2))
    changed = np.arange(len(second["dx"])) % every == 1
    second["dx"] = np.where(changed, second["dx"] + 0.5, second["dx"])
    (warning,) = warned(pasted(columns, second))
    assert warning.count("raw/table.csv") == 2
    assert f"({24 - changed.sum()} of them)" in warning


def test_of_rows_that_round_to_the_same_the_one_as_far_away_as_the_others_is_the_original() -> None:
    """A pose that was measured again at the end, under the same load: the coarse digits show no difference."""
    columns = printed(displacement_columns(), (3, 2, 3))
    for name in (*JOINTS, *FORCES):
        columns[name][-1] = columns[name][0]
    for name in DISPLACEMENTS:
        columns[name][[0, -1]] = 1.004, 1.001
    second = printed(columns, (2, 1, 2))
    (warning,) = warned(pasted(columns, second))
    assert warning.count("repeat") == 1, warning


@pytest.mark.parametrize("digits", [(2, 0, 2), (2, 1, 3), (3, 3, 4)])
@pytest.mark.parametrize("noise_mm", [1e-4, 3e-3, 3e-2])
@pytest.mark.parametrize("seed", range(4))
def test_repeats_of_one_load_are_no_copies(digits: tuple[int, int, int], noise_mm: float, seed: int) -> None:
    """Ten readings in each of twenty poses, under the same dead weight, printed alike."""
    rng = np.random.default_rng(seed)
    columns = displacement_columns(rows=20, seed=seed)
    columns = {name: np.repeat(values, 10) for name, values in columns.items()}
    for name in DISPLACEMENTS:
        columns[name] = columns[name] + noise_mm * rng.standard_normal(len(columns[name]))
    assert warned(printed(columns, digits)) == []


def test_many_repeats_end_in_zeros_by_chance() -> None:
    """Two hundred readings in each of 100 poses, under loads that differ: of some all components end in a zero."""
    rng = np.random.default_rng(5)
    columns = {name: np.repeat(values, 200) for name, values in displacement_columns(rows=100, seed=5).items()}
    for names, noise in ((DISPLACEMENTS, 3e-3), (FORCES, 0.3)):
        for name in names:
            columns[name] = columns[name] + noise * rng.standard_normal(len(columns[name]))
    columns = printed(columns, (2, 1, 3))
    assert warned(columns) == []


def test_readings_of_one_table_are_no_copies() -> None:
    assert warned(printed(displacement_columns(rows=400), (2, 1, 3))) == []


def test_a_campaign_says_so(tmp_path: Path) -> None:
    columns = displacement_columns()
    folder = write_displacement_campaign(tmp_path / "cell", pasted(columns, printed(columns, (1, 0, 2))))
    warnings = reduce_campaign(load_campaign(folder), no_progress).result.warnings
    assert sum("rounded copies" in warning for warning in warnings) == 1
