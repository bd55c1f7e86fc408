"""`campaign.improve()` and `campaign.view()`: the steps of the command one by one, the page inside a notebook."""

from __future__ import annotations

import html
import json
import re
import shutil
from pathlib import Path

import pytest

import stiffcal
from stiffcal.cli.app import main
from stiffcal.commands.diagnose import diagnose_campaign
from tests.laboratory.browser import chromium
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.usefixtures("few_known_effects")
PLAY = """
[[effects]]
type = "backlash"
joints = [4]
parameters = { "backlash.j4.width" = { value = 1.5e-3 }, "backlash.j4.band" = { value = 2.0 } }
"""


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot with play in joint 4, which its model does not hold."""
    folder = write_small_campaign(tmp_path_factory.mktemp("improvement") / "play", hidden=PLAY)
    diagnose_campaign(folder)
    return folder


def copied(folder: Path, place: Path) -> Path:
    return Path(shutil.copytree(folder, place, symlinks=True))


@pytest.mark.long
def test_the_steps_are_those_of_the_command(
    diagnosed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["improve", str(copied(diagnosed, tmp_path / "command")), "--yes", "--json"])
    document = json.loads(capsys.readouterr().out)
    folder = copied(diagnosed, tmp_path / "python")
    improvement = stiffcal.open(folder).improve()
    steps = list(improvement)
    assert improvement.to_dict() == document
    assert (folder / "model.toml").read_text() == (tmp_path / "command" / "model.toml").read_text()
    start, added = steps
    assert (start.action, start.effect, start.place, start.error_before) == ("start", None, "", None)
    assert [(effect.effect, effect.where.joints) for effect in start.missing] == [("backlash", [4])]
    assert (added.action, added.effect, added.place) == ("add", "backlash", "j4")
    assert added.error_before == start.error
    assert added.error is not None
    assert added.error.translation == document["steps"][1]["heldout_rms"]["translation"]
    assert [step.verdict for step in steps] == ["missing", "adequate"]
    shown = improvement._repr_html_()
    assert "present model" in shown
    assert "add backlash (joint 4)" in shown
    assert "noise" in shown
    assert "backlash j4" in added._repr_html_()


def test_who_stops_leaves_the_model_as_the_last_step_made_it(diagnosed: Path, tmp_path: Path) -> None:
    folder = copied(diagnosed, tmp_path / "stopped")
    before = (folder / "model.toml").read_text()
    for step in stiffcal.open(folder).improve():
        assert step.action == "start"
        break
    assert (folder / "model.toml").read_text() == before


def test_a_dry_run_changes_nothing_and_a_trial_is_not_written(diagnosed: Path, tmp_path: Path) -> None:
    folder = copied(diagnosed, tmp_path / "dry")
    before = (folder / "model.toml").read_text()
    campaign = stiffcal.open(folder)
    improvement = campaign.improve(dry_run=True)
    assert not improvement.steps
    assert improvement.result.steps[-1].action == "would add"
    assert [step.action for step in improvement.steps] == ["start", "would add"]
    assert (folder / "model.toml").read_text() == before
    with pytest.raises(stiffcal.InputError) as refused:
        campaign.with_effect("backlash", joints=[4]).improve()
    assert refused.value.code == "option-invalid"


def test_the_page_is_that_of_the_command(diagnosed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written = tmp_path / "view.html"
    with pytest.raises(SystemExit):
        main(["view", str(diagnosed), "-o", str(written)])
    page = stiffcal.open(diagnosed).view()
    assert page.html == written.read_text(encoding="utf-8")
    frame = page._repr_html_()
    found = re.fullmatch(r'<iframe [^>]*sandbox="([^"]*)" srcdoc="([^"]*)" [^>]*></iframe>', frame)
    assert found is not None
    assert html.unescape(found[2]) == page.html
    assert "allow-same-origin" not in found[1]  # a stranger's campaign reaches nothing of the notebook
    page.save(tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text(encoding="utf-8") == page.html
    (tmp_path / "mine.html").write_text("mine")
    with pytest.raises(stiffcal.InputError):
        page.save(tmp_path / "mine.html")


@pytest.mark.browser
def test_the_page_runs_inside_a_notebook_s_output(diagnosed: Path) -> None:
    frame = stiffcal.open(diagnosed).view(height=700)._repr_html_()
    with chromium() as browser:
        outer = browser.new_context(offline=True).new_page()
        complaints: list[str] = []
        outer.on("pageerror", lambda error: complaints.append(str(error)))
        outer.set_content(f"<!DOCTYPE html><title>notebook</title><body>{frame}</body>")
        inner = outer.frame_locator("iframe")
        inner.locator("body[data-ready]").wait_for(timeout=30_000)
        assert inner.locator("canvas").count() > 3
        assert outer.locator("iframe").bounding_box()["height"] == 700
    assert complaints == []
