from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.workflow.small_campaign import write_small_campaign


@pytest.fixture(scope="session")
def validated_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign that is ingested, identified and validated; not to be changed."""
    from stiffcal.workflow.validate import validate_campaign

    folder = write_small_campaign(tmp_path_factory.mktemp("campaigns") / "small")
    validate_campaign(folder)
    return folder


@pytest.fixture
def campaign(validated_folder: Path, tmp_path: Path) -> Path:
    """A copy of it that a test may change."""
    return Path(shutil.copytree(validated_folder, tmp_path / "small", symlinks=True))
