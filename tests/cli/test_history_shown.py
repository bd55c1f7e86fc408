"""The table of `history` in a terminal."""

from __future__ import annotations

from io import StringIO

from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.pages import draw_page
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectInModel, ModelSummary
from stiffcal.results.history_results import HistoryEntry, HistoryResult
from stiffcal.show.answers.history import page
from stiffcal.show.options import PLAIN

DRIVES = EffectInModel("joint-compliance", joints=[1, 2, 3, 4, 5, 6])


def fit(number: int, *more: EffectInModel) -> HistoryEntry:
    return HistoryEntry(
        id=str(number),
        time=f"2026-11-30T15:2{number}:00+00:00",
        model=ModelSummary("deformed", [DRIVES, *more]),
        heldout_rms=Rms(2.8e-5 * number, None) if number > 1 else None,
        scheme="leave-one-pose-out",
        fit_rms=Rms(2.7e-5, None),
        noise=Rms(2.7e-5, None),
    )


def test_each_fit_is_a_row_of_eighty_columns_with_what_it_changed() -> None:
    play, twice = EffectInModel("backlash", joints=[1]), EffectInModel("backlash", joints=[1, 4])
    result = HistoryResult(warnings=[], fits=[fit(1), fit(2, play), fit(3, twice)], not_fitted_yet=fit(4).model)
    stream = StringIO()
    draw_page(AnswerConsole(file=stream, width=80, force_terminal=True, color_system=None), page(result, PLAIN))
    rows = stream.getvalue().splitlines()[-4:]
    assert max(map(len, rows)) <= 80
    expected = (
        "joint-compliance (joints 1–6)",
        "+ backlash (joint 1)",
        "+ backlash (joint 4)",
        "− backlash",
    )
    for row, number, words in zip(rows, ("1", "2", "3", "now"), expected, strict=True):
        assert row.startswith(number)
        assert words in row
