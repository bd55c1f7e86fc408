"""What the tests of the pages share in one session: the runs of their commands, and the built pages."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from docs.page_runs import AS_SHOWN, PLACE, ROOT


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for all processes of this session."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session", autouse=True)
def runs_of_this_session(shared: Path) -> Iterator[None]:
    """Each session runs the commands of the pages anew, once; the build takes its pictures from these runs."""
    before = os.environ.get(PLACE)
    os.environ[PLACE] = str(shared / "page-runs")
    yield
    del os.environ[PLACE]
    if before is not None:
        os.environ[PLACE] = before


@pytest.fixture(scope="session")
def built(request: pytest.FixtureRequest, shared: Path, runs_of_this_session: None) -> Path:
    """The pages, built once without a warning; with the pictures of their commands where the session runs them all."""
    whole = any("practice" in item.keywords for item in request.session.items)
    settings = {} if whole else {AS_SHOWN: "1"}
    html = shared / "html"
    with (shared / "html.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (html / "index.html").exists():
            words = [sys.executable, "-P", "-m", "sphinx", "-W", "--keep-going", "-q", "-d", str(shared / "trees")]
            done = subprocess.run(
                [*words, "docs", str(html)], cwd=ROOT, env={**os.environ, **settings}, capture_output=True, text=True
            )
            assert done.returncode == 0, done.stdout + done.stderr
    return html
