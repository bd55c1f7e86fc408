"""Runs that disagree with all others are named by the commands, and none is left out without a line that says so."""

from __future__ import annotations

import shutil
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from stiffcal.batch.summary import junit_text, markdown_text
from stiffcal.batch.task import run_task
from stiffcal.campaign.loading import load_campaign
from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.pages import draw_page
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.improve import improve_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.diagnosis.answers.suspect_results import NotCheckedReason
from stiffcal.diagnosis.suspects import find
from stiffcal.documents import document_of
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.judgement.suspects import suspicion_of
from stiffcal.report.blocks import Facts, ReportSection, TableBlock
from stiffcal.report.sections import suspects
from stiffcal.results.batch_results import BatchCounts, BatchResult, BatchTask, BatchWorkers
from stiffcal.show.pages import page_of
from tests.laboratory import small_campaign
from tests.laboratory.few_effects import few_effects
from tests.laboratory.report_content import made_up_content
from tests.laboratory.small_campaign import write_small_campaign

LBF = 4.4482216152605
STATES_KEPT = (0, 2, 10, 18)
"""Of the campaign's states: unloaded, and the largest load along each direction."""


def _random_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the small campaign have nine poses."""
    rng = np.random.default_rng(3)
    middle, width = np.array((0, -75, 15, 0, 0, 0)), np.array((65, 38, 40, 110, 95, 140))
    poses = tuple(tuple((middle + width * rng.uniform(-1.0, 1.0, 6)).tolist()) for _ in range(9))
    monkeypatch.setattr(small_campaign, "POSES_DEG", poses)


@pytest.fixture
def folder(diagnosed: Path, tmp_path: Path) -> Path:
    """A copy that a test may change; its store holds the diagnosis."""
    return Path(shutil.copytree(diagnosed, tmp_path / "lbf", symlinks=True))


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine poses with four states each; in the third one the forces are in lbf. Diagnosed, and not to be changed."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        _random_poses(monkeypatch)
        folder = small_campaign.write_small_campaign(tmp_path_factory.mktemp("suspects") / "lbf", poses=9)
    table = folder / "raw" / "states.csv"
    header, *lines = table.read_text(encoding="utf-8").splitlines()
    per_run = len(lines) // 9
    kept = [header]
    for line in (lines[run * per_run + state] for run in range(9) for state in STATES_KEPT):
        cells = line.split(",")
        if cells[0] == "pose3":
            cells[7:10] = [f"{float(cell) / LBF:.9g}" for cell in cells[7:10]]
        kept.append(",".join(cells))
    table.write_text("\n".join(kept) + "\n", encoding="utf-8")
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8")
    sigma = 'units = { position = "mm", rotation = "rad" }\nsigma = { position = 0.01, rotation = 0.00002 }'
    manifest.write_text(text.replace('units = { position = "mm", rotation = "rad" }', sigma), encoding="utf-8")
    with few_effects():
        diagnose_campaign(folder)
    return folder


def test_check_names_the_run_and_the_lines_to_copy_leave_it_out(folder: Path) -> None:
    (suspect,) = check_campaign(folder).suspects or []
    assert (suspect.run, suspect.kind, suspect.row) == ("pose3", "unit", None)
    assert suspect.factor == pytest.approx(LBF)
    assert "rows = [9, 10, 11, 12]" in suspect.exclude
    manifest = folder / "campaign.toml"
    lines = "\n".join(suspect.exclude)
    manifest.write_text(f"{manifest.read_text(encoding='utf-8')}\n{lines}\n", encoding="utf-8")
    assert check_campaign(folder).suspects == []


def test_batch_lists_the_run(folder: Path) -> None:
    outcome = run_task(BatchTask(folder=str(folder), campaign="cell", report=False))
    (suspect,) = outcome.suspects or []
    assert (suspect.run, suspect.kind) == ("pose3", "unit")
    result = BatchResult(
        passed=True,
        campaigns=[outcome, replace(outcome, campaign="none", suspects=[]), replace(outcome, suspects=None)],
        counts=BatchCounts(campaigns=3, held=3, not_held=0, broken=0, unchanged=0),
        workers=BatchWorkers(kind="processes", count=1),
        seconds=1.0,
        peak_memory_bytes=None,
        warnings=[],
    )
    head, *rows = (line for line in markdown_text(result).splitlines() if line.startswith("| "))
    column = head.split(" | ").index("suspects")
    assert [row.split(" | ")[column] for row in rows] == ["1", "0", "–"]
    assert suspect.likely in (junit_text(result).split("<system-out>")[1])
    with StringIO() as text:
        draw_page(AnswerConsole(file=text, width=120), page_of(result))
        assert "suspect run pose3 (unit)" in text.getvalue()


def test_a_quick_look_judges_no_run(folder: Path) -> None:
    assert check_campaign(folder, quick=True).suspects is None


def test_identify_and_validate_name_the_run_and_fit_it_all_the_same(folder: Path) -> None:
    identified = document_of(identify_campaign(folder))
    assert [(suspect["run"], suspect["kind"]) for suspect in identified["suspects"]] == [("pose3", "unit")]
    assert identified["n_runs"] == 9
    without = {entry["name"]: entry["value"] for entry in identified["suspects"][0]["without"]["parameters"]}
    for number, stiffness in enumerate(small_campaign.STIFFNESS[:3], start=1):
        assert 1.0 / without[f"joint-compliance.j{number}.c"] == pytest.approx(stiffness, rel=0.05)
    assert document_of(validate_campaign(folder))["suspects"] == identified["suspects"]


def test_diagnose_answers_without_the_suspect_and_with_it(folder: Path) -> None:
    with few_effects():
        result = diagnose_campaign(folder)
    assert [suspect.run for suspect in result.suspects or []] == ["pose3"]
    assert not result.missing
    assert not result.unexplained
    assert result.with_suspects is not None
    assert result.with_suspects.missing or result.with_suspects.unexplained
    assert 'run "pose3"' in result.summary
    assert all(suspect.is_left_out for suspect in result.suspects or [])
    with few_effects():
        assert diagnose_campaign(folder) == result


def test_improve_and_the_report_show_the_run_and_the_lines_that_leave_it_out(folder: Path) -> None:
    with few_effects():
        result = improve_campaign(folder, dry_run=True)
    assert [suspect.run for suspect in result.suspects or []] == ["pose3"]
    text = StringIO()
    draw_page(AnswerConsole(file=text, width=200), page_of(result))
    assert "suspect: run pose3" in text.getvalue()
    content = made_up_content()
    section = suspects.section(replace(content, diagnose=None, identify=identify_campaign(folder)))
    assert isinstance(section, ReportSection)
    (lines,) = (block for block in section.blocks if isinstance(block, TableBlock))
    assert ("rows = [9, 10, 11, 12]",) in lines.rows
    facts = next(block for block in section.blocks if isinstance(block, Facts))
    assert "multiply by 4.4482" in dict(facts.rows)["likely"]
    assert suspects.section(replace(content, diagnose=None)) is None


def test_a_step_inside_a_run_is_a_suspect_that_names_the_effect_which_explains_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _random_poses(monkeypatch)
    folder = write_small_campaign(tmp_path / "step", poses=7)
    table = folder / "raw" / "states.csv"
    header, *lines = table.read_text(encoding="utf-8").splitlines()
    per_run = len(lines) // 7
    place = header.split(",").index("X")
    for number in range(3 * per_run + per_run // 2, 4 * per_run):
        cells = lines[number].split(",")
        cells[place] = f"{float(cells[place]) + 0.5:.9g}"
        lines[number] = ",".join(cells)
    table.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    result = diagnose_campaign(folder)
    if not result.missing:
        # in one pose a sensor zeroed anew does the same
        (suspect,) = result.suspects or []
        assert suspect.run == "pose4"
        assert "seat-shift" in [effect.effect for effect in suspect.explained_by or []]
        assert result.with_suspects is not None
        assert [effect.effect for effect in result.with_suspects.missing] == ["seat-shift"]
    else:
        assert [effect.effect for effect in result.missing] == ["seat-shift"]


def test_only_what_keeps_a_model_from_being_fitted_is_no_fault_of_the_comparison(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever else goes wrong in it is reported, and not called a model that cannot be fitted."""
    folder = write_small_campaign(tmp_path / "runs", poses=4)
    campaign = load_campaign(folder)
    states = reduce_campaign(campaign, no_progress).states

    def fails_with(code: FaultCode) -> None:
        def fail(*_: object) -> None:
            raise InputError.at(code, "model.toml", "effects", "the reason", "the mend")

        monkeypatch.setattr(find, "find_suspects", fail)

    for code in (FaultCode.NO_CONVERGENCE, FaultCode.NO_BALANCE, FaultCode.MODEL_UNSUITABLE):
        fails_with(code)
        found = suspicion_of(campaign, states)
        assert found.not_checked is not None
        assert found.not_checked.code is NotCheckedReason.NO_FIT
        assert "the reason" in found.not_checked.sentence
    fails_with(FaultCode.PLUGIN_FAILED)
    with pytest.raises(InputError) as caught:
        suspicion_of(campaign, states)
    assert caught.value.code is FaultCode.PLUGIN_FAILED
