"""An answer is one function: dropped in as a file, it stands in terminal, PDF, browser and notebook."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from pypdf import PdfReader

from stiffcal.cli.answers import Answer
from stiffcal.cli.option_names import OPTIONS
from stiffcal.documents import CommandResult
from stiffcal.errors import no_progress
from stiffcal.presentation.values import NextStep
from stiffcal.python.campaign_answer import CampaignAnswer
from stiffcal.python.notebook import html_of
from stiffcal.report.blocks import ReportSection
from stiffcal.report.building import PagesHeading, write_pages
from stiffcal.report.page_blocks import section_of
from stiffcal.schemas.documents import DOCUMENTS
from stiffcal.show import answers
from stiffcal.show.ladder import ladder
from stiffcal.show.pages import has_page, page_of
from stiffcal.view.packing import unpacked
from stiffcal.view.page import pack
from tests.cli.test_ladder_bars import NOISE, STEPS
from tests.laboratory.dropped_in import dropped_in
from tests.report.test_diagnosis_pages import diagnosed


@pytest.fixture
def result() -> Iterator[CommandResult]:
    with dropped_in("answers"):
        made: CommandResult = import_module("stiffcal.show.answers.hottest_motor").HottestMotorResult(
            warnings=["motor 3 was not read"], celsius=[41.25, 55.0]
        )
        yield made


TEXTS = ("motor 2 became <hottest>", "temperature [°C]", "41.2", "55.0")


def terminal(result: CommandResult, capsys: pytest.CaptureFixture[str], folder: Path) -> str:
    Answer(as_json=False).show(result)
    shown = capsys.readouterr()
    assert "motor 3 was not read" in shown.err
    return shown.out


def notebook(result: CommandResult, capsys: pytest.CaptureFixture[str], folder: Path) -> str:
    shown = CampaignAnswer(result)._repr_html_()
    assert "motor 3 was not read" in shown
    assert "<hottest>" not in shown
    assert "<svg" in shown
    return html.unescape(shown)


def pdf(result: CommandResult, capsys: pytest.CaptureFixture[str], folder: Path) -> str:
    section = section_of(page_of(result))
    assert isinstance(section, ReportSection)
    heading = PagesHeading("Motors", "", "lab", "2026-11-30", "stiffcal", has_contents=False)
    write_pages(heading, (section,), folder / "pages.pdf", no_progress)
    return " ".join("".join(sheet.extract_text() for sheet in PdfReader(folder / "pages.pdf").pages).split())


def browser(result: CommandResult, capsys: pytest.CaptureFixture[str], folder: Path) -> str:
    page: Any = page_of(result)
    document, _ = unpacked(pack(page))
    assert [block["kind_"] for block in document["blocks"]] == ["Sentence", "Table", "Picture"]
    return json.dumps(document, ensure_ascii=False)


@pytest.mark.parametrize("medium", [terminal, notebook, pdf, browser])
def test_a_dropped_in_answer_stands_in_every_medium(
    medium: Any, result: CommandResult, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert has_page(result)
    shown = medium(result, capsys, tmp_path)
    for text in TEXTS:
        # the report begins its sentences with a capital letter
        assert text in shown or text[:1].upper() + text[1:] in shown, text


def test_without_its_file_there_is_no_page() -> None:
    assert not has_page(CommandResult(schema="stiffcal/hottest-motor/1", warnings=[]))


def test_every_answer_has_a_page() -> None:
    schemas = {
        name: str(field.default) for name, kind in DOCUMENTS.items() for field in fields(kind) if field.name == "schema"
    }
    assert set(DOCUMENTS) - set(schemas) == {"error"}
    found = {name for name, schema in schemas.items() if has_page(CommandResult(schema=schema, warnings=[]))}
    assert set(schemas) == found


def test_details_are_offered_with_the_command_that_has_them() -> None:
    """`run` and a notebook show parts of other answers, and have no such option."""
    offers = {
        command
        for file in Path(answers.__file__).parents[1].rglob("*.py")
        for command in re.findall(r"(\w*|\{command\})[ (]*--details", file.read_text("utf-8"))
    }
    assert "identify" in offers
    offers = offers - {"{command}"} | {"compare", "trend"}  # which fill it in
    assert {command for command in offers if "--details" not in OPTIONS.get(command, "")} == set()


def test_a_diagnosis_and_a_ladder_are_the_same_page_in_every_medium() -> None:
    page = page_of(diagnosed())
    bars = ladder(STEPS, NOISE, None)
    page = replace(page, blocks=(*page.blocks, bars), next_step=NextStep("stiffcal improve"))
    content: Any = page
    document, _ = unpacked(pack(content))
    media = (html_of(page), json.dumps(document, ensure_ascii=False), str(section_of(page)))
    assert document["blocks"][-1]["kind_"] == "Table"  # the scripts draw it as they do all others
    rung = bars.bars[-2]
    for text in ("missing: backlash (joint 4): 99.0 %", "each effect added", rung.name, rung.text, "stiffcal improve"):
        for shown in media:
            assert text in shown or text[:1].upper() + text[1:] in shown, text
