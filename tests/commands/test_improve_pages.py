"""Page and report after `improve`: written anew where the model was changed, never in place of somebody else's file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from stiffcal.commands.improve import improve_campaign
from stiffcal.commands.improve_pages import check_pages, with_pages
from stiffcal.errors import InputError, Progress
from stiffcal.report.content import ReportContent
from stiffcal.results.improve_results import ImproveResult
from stiffcal.stages.steps import RunContext
from tests.laboratory.small_campaign import write_small_campaign

COUPLED = """
[[effects]]
type = "axis-coupling"
pairs = [[5, 6]]
[effects.parameters]
"axis-coupling.j5-j6.c" = { value = 1.5e-5 }
"""
pytestmark = pytest.mark.usefixtures("few_known_effects")


@pytest.fixture(scope="module")
def improved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ImproveResult]:
    """A campaign whose model lacked the coupling of two axes."""
    folder = write_small_campaign(tmp_path_factory.mktemp("pages") / "small", hidden=COUPLED)
    return folder, improve_campaign(folder)


@pytest.fixture(autouse=True)
def quick_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave typesetting out."""

    def touch(content: ReportContent, output: Path, progress: Progress, is_short: bool) -> None:
        output.write_bytes(b"pages")

    monkeypatch.setattr("stiffcal.report.building.build_report", touch)


@pytest.mark.long
def test_both_are_written_of_the_changed_model(improved: tuple[Path, ImproveResult]) -> None:
    folder, result = improved
    assert result.changed
    written = with_pages(result, folder, RunContext())
    assert (written.view, written.report) == (str(folder / "view.html"), str(folder / "report.pdf"))
    assert (folder / "report.pdf").read_bytes() == b"pages"
    assert written.warnings == result.warnings
    check_pages(folder, RunContext())


def test_where_nothing_was_changed_nothing_is_written(improved: tuple[Path, ImproveResult], tmp_path: Path) -> None:
    result = replace(improved[1], steps=improved[1].steps[:1])
    assert with_pages(result, tmp_path, RunContext()) is result


def test_what_stiffcal_did_not_write_stays(improved: tuple[Path, ImproveResult]) -> None:
    folder, result = improved
    (folder / "report.pdf").write_text("somebody's notes", encoding="utf-8")
    written = with_pages(result, folder, RunContext())
    assert written.report is None
    assert written.view is not None
    assert len(written.warnings) == len(result.warnings) + 1
    assert (folder / "report.pdf").read_text(encoding="utf-8") == "somebody's notes"
    with pytest.raises(InputError) as refused:
        check_pages(folder, RunContext())
    assert refused.value.code == "file-exists"
    assert with_pages(result, folder, RunContext(overwrite=True)).report is not None


def test_what_is_wrong_with_the_page_is_a_warning(
    improved: tuple[Path, ImproveResult], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, result = improved
    monkeypatch.setattr("stiffcal.view.gathering.content.view_bodies", lambda campaign: ([], "part.stl: damaged"))
    written = with_pages(result, folder, RunContext(overwrite=True))
    assert [warning for warning in written.warnings if "part.stl: damaged" in warning]
    assert len(written.warnings) == len(result.warnings) + 1
