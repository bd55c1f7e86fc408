"""A stranger's campaign folder, identified and validated on another machine."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stiffcal.commands.validate import validate_campaign
from tests.laboratory.delivered_store import STRICT
from tests.laboratory.small_campaign import write_small_campaign


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign that somebody else has identified and validated, with a threshold that it does not hold."""
    root = tmp_path_factory.mktemp("stranger")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STIFFCAL_STATE", str(root / "state"))
        folder = write_small_campaign(root / "small", poses=2)
        with (folder / "campaign.toml").open("a", encoding="utf-8") as file:
            file.write(STRICT)
        assert validate_campaign(folder).passed is False
    return folder


@pytest.fixture
def delivered(made: Path, tmp_path: Path, state: Path) -> Path:
    """The stranger's folder on this user's machine, where nothing is recorded of it."""
    shutil.copytree(made, tmp_path / "small", symlinks=True)
    return tmp_path / "small"
