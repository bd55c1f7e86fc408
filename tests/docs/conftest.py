"""Where the runs of the pages' commands are kept: each session of tests runs them anew, once."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from docs.page_runs import PLACE


@pytest.fixture(scope="session", autouse=True)
def runs_of_this_session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """One folder for all processes of this session; the build of the pages takes their pictures from it."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    before = os.environ.get(PLACE)
    os.environ[PLACE] = str(shared / "page-runs")
    yield
    del os.environ[PLACE]
    if before is not None:
        os.environ[PLACE] = before
