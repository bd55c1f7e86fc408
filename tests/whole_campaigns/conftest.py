from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stiffcal.cli.app import main
from tests.laboratory import hidden_campaigns
from tests.laboratory.hidden_campaigns import copied

SHARED = Path(__file__).parents[3] / "shared"
CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


Command = Callable[..., dict[str, Any]]


@pytest.fixture
def practice(tmp_path: Path) -> Callable[[str], Path]:
    """Copy a campaign whose truth is known to where it may be written."""
    return lambda name: copied(name, tmp_path)


@pytest.fixture
def truth() -> dict[str, dict[str, Any]]:
    """What was hidden in these campaigns, by folder."""
    return hidden_campaigns.truth()


@pytest.fixture
def fanuc(tmp_path: Path) -> Path:
    """The FANUC campaign with the real measurements put in."""
    data = SHARED / "data" / "fanuc-r2000ic"
    if not data.is_dir():
        pytest.skip("the real measurements (../shared/data) are not here")
    target = Path(
        shutil.copytree(CAMPAIGNS / "fanuc-r2000ic", tmp_path / "fanuc", ignore=shutil.ignore_patterns("store"))
    )
    (target / "raw").mkdir(exist_ok=True)
    for name in ("joint_angles.csv", "forces.csv", "deltaX.csv"):
        shutil.copyfile(data / name, target / "raw" / name)
    return target


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    """Run a command with --json; return its document. ``codes`` are the exit codes allowed."""

    def run(*words: str | Path, codes: tuple[int, ...] = (0,)) -> dict[str, Any]:
        with pytest.raises(SystemExit) as end:
            main([*map(str, words), "--json"])
        reported = capsys.readouterr()
        assert end.value.code in codes, reported.out[-2000:] + reported.err
        document: dict[str, Any] = json.loads(reported.out)
        return document

    return run
