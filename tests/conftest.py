from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.readers.database import database

__all__ = ["database"]


@pytest.fixture(scope="session", autouse=True)
def _own_state(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep what stiffcal remembers of its user (what they trust) out of the tester's home."""
    before = {name: os.environ.get(name) for name in ("STIFFCAL_STATE", "XDG_STATE_HOME", "LOCALAPPDATA")}
    place: Path = tmp_path_factory.mktemp("state")
    os.environ.update(dict.fromkeys(before, str(place)))
    yield
    for name, value in before.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
