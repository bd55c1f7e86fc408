"""Rows that are left out are not judged, targets may be missing in tables, and conditions may stand at the source."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.reduction.logs.coarse_clock import coarse_clock
from stiffcal.reduction.logs.plausibility import LogQuality
from stiffcal.reduction.states.load_states import _anything_measured
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.small_campaign import write_small_campaign

EXCLUDE = '\n[[exclude]]\nsource = "table"\nrows = [{}]\nwhy = "the tracker lost it"\n'
COLUMNS = ["run", "A1", "A2", "A3", "A4", "A5", "A6", "Fx", "Fy", "Fz", "X", "Y", "Z", "rx", "ry", "rz"]


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    return write_small_campaign(tmp_path / "c")


def write_cells(folder: Path, row: int, cells: dict[str, str]) -> None:
    """Overwrite cells of a data row, from 1."""
    path = folder / "raw" / "states.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    values = lines[row].split(",")
    for column, cell in cells.items():
        values[COLUMNS.index(column)] = cell
    lines[row] = ",".join(values)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def add_to_manifest(folder: Path, text: str) -> None:
    path = folder / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8") + text, encoding="utf-8")


def states_of(folder: Path) -> LoadStates:
    return up_to_date_states(folder, RunContext()).states


def without_target(cell: str) -> dict[str, str]:
    return dict.fromkeys(("X", "Y", "Z", "rx", "ry", "rz"), cell)


@pytest.mark.parametrize("cell", ["nan", "", "NaN", "1e300"])
def test_rows_left_out_may_hold_anything(campaign: Path, cell: str) -> None:
    whole = states_of(campaign)
    write_cells(campaign, 7, {"Fx": cell, "A2": cell, **without_target(cell)})
    with pytest.raises(InputError):
        load_and_ingest(campaign)
    add_to_manifest(campaign, EXCLUDE.format(7))
    states = states_of(campaign)
    assert 7 not in states.row.tolist()
    assert len(states) == len(whole) - 1
    assert np.isfinite(states.wrench).all()


def load_and_ingest(folder: Path) -> LoadStates:
    load_campaign(folder)
    return states_of(folder)


def test_a_row_left_out_with_a_load_stays_as_set_aside(campaign: Path) -> None:
    write_cells(campaign, 7, without_target("nan"))
    add_to_manifest(campaign, EXCLUDE.format(7))
    states = states_of(campaign)
    assert states.set_aside_code[states.row.tolist().index(7)] == SetAsideCode.EXCLUDED


@pytest.mark.parametrize("cell", ["nan", ""])
def test_a_missing_target_sets_its_row_aside(campaign: Path, cell: str) -> None:
    write_cells(campaign, 7, without_target(cell))
    states = states_of(campaign)
    aside = [(int(row), str(code)) for row, code in zip(states.row, states.set_aside_code, strict=True) if code]
    assert aside == [(7, SetAsideCode.NOT_MEASURED.value)]


def test_a_missing_reference_is_replaced_by_the_next_state(campaign: Path) -> None:
    write_cells(campaign, 1, without_target("nan"))
    states = states_of(campaign)
    assert states.row[states.reference].tolist()[0] == 2


def test_a_missing_force_is_refused_with_the_lines_that_leave_it_out(campaign: Path) -> None:
    write_cells(campaign, 7, {"Fx": "nan"})
    with pytest.raises(InputError, match=r"line 8, column Fx.*\[\[exclude\]\]"):
        states_of(campaign)
    add_to_manifest(campaign, EXCLUDE.format(3))  # other rows are judged as before
    with pytest.raises(InputError, match=r"line 8, column Fx: the reading is missing.*rows = \[7\]"):
        states_of(campaign)


@pytest.mark.parametrize("cell", ["-9999", "nan"])
def test_a_condition_at_the_source_leaves_rows_out(campaign: Path, cell: str) -> None:
    write_cells(campaign, 7, {"X": cell})
    edit(campaign, lambda text: text.replace('sampling = "states"', 'sampling = "states"\nrows = "X > -5000"'))
    states = states_of(campaign)
    assert 7 not in states.row.tolist()
    assert states.used.all()


def edit(folder: Path, change: Callable[[str], str]) -> None:
    path = folder / "campaign.toml"
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")


def test_a_condition_at_a_source_of_several_files_is_refused_with_its_place(campaign: Path) -> None:
    files = 'files = { joints = "raw/states.csv", wrench = "raw/states.csv", pose = "raw/states.csv" }'
    edit(campaign, lambda text: text.replace('file = "raw/states.csv"', f'{files}\nrows = "X > -5000"'))
    with pytest.raises(InputError, match="write rows at the signal"):
        load_campaign(campaign)


def test_a_condition_outside_the_sources_is_refused_with_its_place(campaign: Path) -> None:
    edit(campaign, lambda text: f'rows = "X > -5000"\n{text}')
    with pytest.raises(InputError, match="sources.NAME.rows"):
        load_campaign(campaign)


# Seven rows to a tick of 16 ms.
TICKS = np.repeat(np.linspace(0.0, 0.016 * 99, 100), 7)


def test_a_coarse_clock_is_recognised_and_an_irregular_one_is_not() -> None:
    ticks = coarse_clock(TICKS)
    assert ticks is not None
    assert ticks.rate_hz == pytest.approx(437.5)
    uneven = np.repeat(TICKS[::7], np.random.default_rng(1).integers(1, 14, 100))
    assert coarse_clock(uneven) is None
    assert coarse_clock(np.linspace(0.0, 0.99, 100)) is None


def test_a_coarse_clock_is_refused_with_the_rate_to_write() -> None:
    quality = LogQuality("ft.csv", lambda row: f"line {row + 1}", sampled=True)
    with pytest.raises(
        InputError, match=r"the time resolution is 16.0 ms, with 7 rows per step; .*time = \{ rate_hz = 437.5 \}"
    ):
        quality.update(np.arange(1, 701), TICKS, {})


def test_a_campaign_without_load_states_has_nothing_to_set_aside() -> None:
    """Clamped and friction runs make none: arrays of no rows."""
    shapes = ((0, 1, 3), (0, 0, 3, 3), (0, 0), (0, 2))
    assert _anything_measured(*(np.zeros(shape) for shape in shapes)).tolist() == []
