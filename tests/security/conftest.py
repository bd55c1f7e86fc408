from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.trust import notices


@pytest.fixture
def state(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty state folder of this test alone; every notice is given anew."""
    folder = tmp_path_factory.mktemp("state") / "stiffcal"
    monkeypatch.setenv("STIFFCAL_STATE", str(folder))
    monkeypatch.delenv("STIFFCAL_TRUST", raising=False)
    monkeypatch.setattr(notices, "_given", set())
    return folder
