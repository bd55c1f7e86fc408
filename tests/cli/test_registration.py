"""Where frames are estimated, what is left between kinematics and readings stands first in every answer."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from stiffcal.cli.app import main
from stiffcal.report.blocks import Paragraph, ReportSection
from stiffcal.report.gathering.content import report_content
from stiffcal.report.sections.summary import section
from stiffcal.results.history_results import HistoryResult
from stiffcal.stages.steps import RunContext, stored_fit, stored_validation, up_to_date_states
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.usefixtures("few_known_effects")
COMMANDS = ("check", "ingest", "identify", "validate", "diagnose", "improve --dry-run", "run")


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign whose tracker has to be found: its axes are those of the base."""
    folder = write_small_campaign(tmp_path_factory.mktemp("registered") / "c")
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8").replace('frame = "base"', 'frame = "tracker"')
    frame = '[frames.tracker]\nparent = "base"\nestimate = true\n\n[frames.target]'
    manifest.write_text(text.replace("[frames.target]", frame), encoding="utf-8")
    return folder


@pytest.mark.parametrize("command", COMMANDS)
def test_the_registration_stands_first_after_the_verdict(
    campaign: Path, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *options = command.split()
    with pytest.raises(SystemExit):
        main([name, str(campaign), *options])
    lines = capsys.readouterr().out.splitlines()
    line = lines[lines[0].startswith(("PASS  ", "WARN  ", "FAIL  "))]
    assert line.startswith("registration of tracker in 4 poses: ")


@pytest.mark.parametrize("command", ["ingest", "identify", "validate", "diagnose", "improve --dry-run"])
def test_json_has_it(campaign: Path, command: str, capsys: pytest.CaptureFixture[str]) -> None:
    name, *options = command.split()
    with pytest.raises(SystemExit):
        main([name, str(campaign), *options, "--json"])
    registration = json.loads(capsys.readouterr().out)["registration"]
    assert registration["n_poses"] == 4
    assert 1e-4 < registration["rms_m"] < 1e-2  # the arm sags under its weight, the kinematics does not


def test_the_report_begins_with_it(campaign: Path) -> None:
    with pytest.raises(SystemExit):
        main(["validate", str(campaign)])
    data = up_to_date_states(campaign, RunContext())
    fit, validation = stored_fit(data.store), stored_validation(data.store)
    assert fit is not None
    assert validation is not None
    page = section(report_content(data, fit, validation, HistoryResult(warnings=[], fits=[])))
    assert isinstance(page, ReportSection)
    texts = [block.text for block in page.blocks if isinstance(block, Paragraph)]
    assert texts[0].startswith("Registration of tracker in 4 poses")
