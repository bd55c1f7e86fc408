"""The progress bar: nothing for what is quick or without a terminal, a bar for what takes longer."""

from __future__ import annotations

import pytest

from stiffcal.cli import progress
from stiffcal.cli.progress import ProgressBar
from stiffcal.presentation.time_left import TimeLeft


def test_quick_things_draw_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    bar = ProgressBar(terminal=True)
    bar("reading", 0.5)
    bar.stop()
    assert "reading" not in capsys.readouterr().err


def test_slow_things_draw_a_bar(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "BAR_AFTER_S", 0.01)
    monkeypatch.setenv("FORCE_COLOR", "1")
    bar = ProgressBar(terminal=True)
    now = 0.0
    bar._time_left = TimeLeft(clock=lambda: now)
    bar("reading the force log", 0.0)
    assert bar._timer is not None
    bar._timer.join()  # it ends when the bar is on the screen
    now = 60.0
    bar("reading the force log", 0.5)
    bar.stop()
    reported = capsys.readouterr()
    assert "reading the force log" in reported.err
    assert "60 s" in reported.err
    assert reported.out == ""


def test_without_a_terminal_nothing_is_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    bar = ProgressBar(terminal=False)
    bar("reading", None)
    bar.stop()
    assert capsys.readouterr().err == ""
