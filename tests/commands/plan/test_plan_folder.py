"""The folder that `plan --campaign` makes of a campaign with one table and rods."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import tomlkit

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.plan_file import load_plan
from stiffcal.commands.plan import plan_campaign
from stiffcal.planning.campaign.request import PlanRequest

KR240 = Path(__file__).parents[3] / "campaigns" / "kr240"
SPRINGS = """schema = "stiffcal/model/1"
[[effects]]
type = "joint-compliance"
joints = [1, 2, 3, 4, 5, 6]
"""
PLAN = """schema = "stiffcal/plan-input/1"
candidates = 20
runs = 3
[load]
point = "hook"
steps = [0.5, 1.0]
"""


def test_the_planned_folder_is_about_itself_and_can_be_planned_further(tmp_path: Path) -> None:
    source, out = tmp_path / "source", tmp_path / "out"
    source.mkdir()
    for name in ("campaign.toml", "robot.toml"):
        shutil.copy(KR240 / name, source)
    written = (source / "campaign.toml").read_text(encoding="utf-8")
    tabbed = written.replace('sampling = "states"', 'sampling = "states"\ncsv = { delimiter = "tab" }', 1)
    (source / "campaign.toml").write_text(tabbed, encoding="utf-8")
    (source / "model.toml").write_text(SPRINGS, encoding="utf-8")
    (source / "plan.toml").write_text(PLAN, encoding="utf-8")
    plan = plan_campaign(source, request=PlanRequest(force=800.0, campaign=out))
    # the lengths of rods are in no expected uncertainty
    assert sum("rods" in warning for warning in plan.warnings) == 1
    manifest = (out / "campaign.toml").read_text(encoding="utf-8")
    assert "stiffcal simulate" not in manifest
    assert tomlkit.parse(manifest).unwrap()["frames"] == tomlkit.parse((source / "campaign.toml").read_text())["frames"]
    made = load_plan(out)
    assert (made.load.force_N, made.load.point, made.runs) == (800.0, "hook", 3)
    rows = list(csv.DictReader((out / "runs.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["log"] for row in rows if row["log"]} == {"raw/table.csv"}
    # the header waits next to the table, which is not there yet
    assert "raw/table_empty.csv" in (plan.files or [])
    assert not (out / "raw" / "table.csv").exists()
    header = (out / "raw" / "table_empty.csv").read_text(encoding="utf-8").strip().split("\t")
    assert tuple(header) == load_campaign(out, check_files=False).manifest.sources["table"].columns()
    further = plan_campaign(out)
    assert [run.id for run in further.runs] == ["run04", "run05", "run06"]
