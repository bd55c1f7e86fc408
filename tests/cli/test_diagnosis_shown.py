"""What `diagnose` prints of probabilities: bars, laws of no catalogue, loads that decide."""

from __future__ import annotations

from io import StringIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.pages import draw_blocks, draw_page
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.diagnosis.answers.heldout_results import ErrorAsValidated
from stiffcal.diagnosis.answers.results import ExcludedSizeAt, LawCurveAt, LookAlike, ProposedEffect, UnknownLaw
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where
from stiffcal.presentation.values import Listing
from stiffcal.show.answers.diagnose import _add_excluded, _add_ranking, add_in_model, law_picture
from stiffcal.show.answers.run import with_missing_in_words
from stiffcal.show.builder import PageBuilder
from stiffcal.show.options import ShowOptions
from stiffcal.show.pages import page_of
from stiffcal.validation.schemes import BY_REGION
from tests.laboratory.diagnosed_folders import WITHOUT_6, diagnosed_copy

SCREEN = 40
"""Lines."""


def finding(probability: float) -> Any:
    return SimpleNamespace(
        effect="backlash", where=Where(joints=[4]), verdict="possible", heldout_rms_after=Rms(1e-4, None), explains=0.5,
        confidence=0.5, probability=probability, size_m=1e-4, size_Nm=None,
    )  # fmt: skip


@pytest.mark.parametrize(("probability", "width", "drawn"), [(1.0, 120, True), (1.0, 60, False), (0.0, 120, False)])
def test_the_ranking_has_bars_of_probability_where_there_is_room(probability: float, width: int, drawn: bool) -> None:
    result: Any = SimpleNamespace(
        findings=[finding(probability)],
        rms=Rms(1e-4, None),
        noise=None,
        missing=[],
        unexplained=False,
        undecided=[],
        could_be=[],
        as_validated=ErrorAsValidated(scheme=BY_REGION, rms=Rms(2e-4, None), with_missing=None),
        explained_by=lambda one: one.explains,
    )
    with StringIO() as text:
        made = PageBuilder("")
        _add_ranking(made, result, details=False)
        draw_blocks(AnswerConsole(file=text, width=width), made.page().blocks)
        assert ("█" * 10 in text.getvalue()) is drawn
        # what validate leaves out has another error: which one stands where is stated
        assert "held-out" in {
            one.code for block in made.page().blocks if isinstance(block, Listing) for one in block.sentences
        }


def test_a_law_of_its_own_is_drawn_where_part_is_unexplained() -> None:
    at = np.linspace(-1.0, 1.0, 9)
    curve = LawCurveAt(over="torque:2", unit="N*m", value_unit="rad", at=at.tolist(), value=(1e-3 * at).tolist())
    law = UnknownLaw(follows="its own torque", where=Where(joints=[2]), of="joint 2", probability=0.9, curve=curve)
    for unexplained in (True, False):
        result: Any = SimpleNamespace(unknown=[law], unexplained=unexplained)
        with StringIO() as text:
            picture = law_picture(result)
            draw_blocks(AnswerConsole(file=text, width=100, markup=False), [picture] if picture else [])
            assert ("torque of joint 2 [N·m]" in text.getvalue()) is unexplained
            assert ("[mrad]" in text.getvalue()) is unexplained


def test_once_in_the_model_an_effect_keeps_its_probability_and_its_look_alikes() -> None:
    where = Where(joints=[4])
    alike = LookAlike(effect="two-slope", where=where, probability=0.2)
    held = ProposedEffect(
        effect="backlash", where=where, alternatives=[alike], probability=0.98, member_probability=0.8
    )
    with StringIO() as text:
        made = PageBuilder("")
        add_in_model(made, SimpleNamespace(in_model=[held]))  # type: ignore[arg-type]
        draw_blocks(AnswerConsole(file=text, width=200), made.page().blocks)
        assert "backlash (joint 4): 98.0 %; cannot be distinguished from: two-slope (joint 4) 20 %" in text.getvalue()


def test_the_plan_that_decides_is_a_line_to_copy() -> None:
    sizes = [
        ExcludedSizeAt(where=Where(joints=[k]), of=f"joint {k}", size_m=1e-4, effect="creep", deciding_force_N=force)
        for k, force in ((2, 640.2), (3, None))
    ]
    result: Any = SimpleNamespace(missing=[], unexplained=False, excluded_sizes=sizes)
    with StringIO() as text:
        made = PageBuilder("")
        _add_excluded(made, result, ShowOptions(folder=Path("cell")))
        draw_blocks(AnswerConsole(file=text, width=200), made.page().blocks)
        assert "stiffcal plan cell --force 641" in text.getvalue()


@pytest.mark.long
def test_a_verdict_fits_a_screen_and_details_show_the_rest(tmp_path: Path) -> None:
    folder = diagnosed_copy(WITHOUT_6, tmp_path / "small")
    result = diagnose_campaign(folder)
    printed = []
    for details in (False, True):
        with StringIO() as text:
            console = AnswerConsole(file=text, width=80, force_terminal=True, color_system=None, markup=False)
            draw_page(console, page_of(result, ShowOptions(details, folder)))
            printed.append(text.getvalue().splitlines())
    short, whole = printed
    assert result.missing
    assert "joint-compliance (joint 6)" in with_missing_in_words(result)
    assert len(short) <= SCREEN < len(whole)
