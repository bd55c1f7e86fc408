"""Twelve poses for 31 parameters fit to the noise and say nothing of the model: nothing is claimed."""

from __future__ import annotations

import shutil
from pathlib import Path

from stiffcal.commands.diagnose import diagnose_campaign

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"


def test_poses_that_leave_nothing_to_validate_make_no_model_adequate(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(CAMPAIGN, tmp_path / "few", ignore=shutil.ignore_patterns("store")))
    file = folder / "raw" / "poses.csv"
    file.write_text("".join(file.read_text(encoding="utf-8").splitlines(keepends=True)[:13]), encoding="utf-8")
    diagnosis = diagnose_campaign(folder)
    assert diagnosis.adequate is None
    assert diagnosis.missing == []
    assert "cannot be judged" in diagnosis.summary
    assert "measure more poses" in diagnosis.summary
