"""The page while logs come, in a real browser: it waits, shows the first runs, then others, and what is broken."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import pytest

from stiffcal.live.page import live_server
from stiffcal.live.watching import LogWatcher
from stiffcal.stages.steps import RunContext
from tests.laboratory.browser import chromium
from tests.live.test_watching import Measuring

pytestmark = pytest.mark.browser
PATIENCE_MS = 60_000


def until(page: Any, condition: str) -> None:
    """Wait until something holds on the page, whose policy lets playwright's own waiting evaluate nothing."""
    deadline = time.monotonic() + PATIENCE_MS / 1e3
    while not page.evaluate(condition):
        assert time.monotonic() < deadline, condition
        page.wait_for_timeout(50)


def test_runs_appear_on_the_page_by_themselves(tmp_path: Path) -> None:
    measuring = Measuring(tmp_path / "c")
    measuring.watcher.close()
    measuring.now = 0.0  # long ago: nobody writes what lies there
    server = live_server(measuring.folder, RunContext(), watch=True)
    watcher = server.background
    assert isinstance(watcher, LogWatcher)
    thread = threading.Thread(target=server._http.serve_forever)  # the test itself looks at the logs
    thread.start()
    complaints: list[str] = []

    def look(page: Any, text: str) -> None:
        watcher.look()
        page.get_by_text(text, exact=False).first.wait_for(timeout=PATIENCE_MS)

    try:
        with chromium() as browser:
            page = browser.new_context().new_page()
            page.on("pageerror", lambda error: complaints.append(str(error)))
            page.goto(server.address)
            look(page, "0 read, 0 waiting, 0 not used")
            for run in ("pose1", "pose2"):
                measuring.write(run, measuring.logs[run])
            look(page, "2 read, 0 waiting")
            page.wait_for_selector("body[data-ready]", timeout=PATIENCE_MS)
            page.get_by_text("pose1 read: 25 load states").wait_for(state="attached", timeout=PATIENCE_MS)
            measuring.write("pose3", "<script>alert(1)</script>\n")
            look(page, "1 not used")
            page.get_by_text("raw/pose3.csv").first.wait_for(timeout=PATIENCE_MS)
            # what is ticked and where the page is stay: it is not loaded anew
            page.evaluate("window.same = true")
            page.evaluate("stiffcal.want({ added: ['bearing-tilt j2'] })")
            until(page, "stiffcal.parts[0].live.added.length === 1 && !stiffcal.waitsFor")
            measuring.write("pose4", measuring.logs["pose4"])
            look(page, "3 read")
            until(page, "stiffcal.parts[0].n_states === 75 && !stiffcal.waitsFor")
            assert page.evaluate("window.same && stiffcal.parts[0].live.added[0]") == "bearing-tilt j2"
            assert page.evaluate("stiffcal.fault") == ""
            # the fit of fewer runs is no rung of the ladder until it is asked for
            rungs = "parseFloat(document.getElementById('ladder-canvas').style.height)"
            few = page.evaluate(rungs)
            page.get_by_label("all models").check()
            until(page, f"{rungs} > {few}")
    finally:
        server._http.shutdown()
        thread.join()
        server.close()
    assert complaints == []
