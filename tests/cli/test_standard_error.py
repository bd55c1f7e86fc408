"""Sentences on standard error at a terminal, and in a pipe."""

from __future__ import annotations

import sys

import pytest

from stiffcal.cli.answers import Answer


@pytest.mark.parametrize("is_terminal", [True, False])
def test_a_warning_wraps_between_words_only_at_a_terminal(
    is_terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "30")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: is_terminal)
    Answer(as_json=False).notify("warning: residuals are four times the noise of the instruments")
    lines = capsys.readouterr().err.splitlines()
    assert " ".join(lines) == "warning: residuals are four times the noise of the instruments"
    assert (len(lines) > 1) is is_terminal
    assert not is_terminal or max(map(len, lines)) <= 30
