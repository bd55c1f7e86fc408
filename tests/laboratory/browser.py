"""Debian's chromium for the tests that look at pages."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

SOFTWARE = ["--no-sandbox", "--disable-gpu"]
MISSING = "no browser: apt-get install chromium, and make .venv/browser.stamp"


@contextmanager
def chromium() -> Iterator[Any]:
    """Start a browser; where CI is set it must be there, elsewhere the tests are skipped."""
    path = os.environ.get("CHROMIUM") or shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        path = None
    if path is None:
        if os.environ.get("CI"):
            pytest.fail(MISSING)
        pytest.skip(MISSING)
    with sync_playwright() as play:
        started = play.chromium.launch(executable_path=path, args=SOFTWARE)
        yield started
        started.close()


def opened(browser: Any, file: Path, **options: Any) -> tuple[Any, list[str]]:
    """Open the page with the network off; return it with what it complained of."""
    page = browser.new_context(offline=True, **options).new_page()
    complaints: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-ready], body[data-failed]")
    return page, complaints


def colours_of(page: Any, panel: str) -> int:
    """Return how many colours a canvas shows."""
    return int(
        page.evaluate(
            """(id) => { const c = document.getElementById(id + "-canvas");
            const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data, seen = new Set();
            for (let i = 0; i < d.length; i += 4) seen.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]);
            return seen.size; }""",
            panel,
        )
    )


def axe_findings(page: Any) -> list[tuple[str, str]]:
    """Return what axe-core finds against WCAG 2.2 AA; the page was opened with ``bypass_csp``."""
    from axe_playwright_python.sync_playwright import Axe

    results = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]})
    return [(found["id"], found["nodes"][0]["html"][:200]) for found in results.response["violations"]]


def becomes(page: Any, condition: str) -> bool:
    """Return whether an expression of the page is true within ten seconds, however busy the machine is."""
    return bool(
        page.evaluate(
            f"""async () => {{ for (let k = 0; k < 1000; k++) {{
            if ({condition}) return true;
            await new Promise((done) => setTimeout(done, 10)); }}
            return false; }}"""
        )
    )


def settled(page: Any) -> None:
    page.evaluate(
        """async () => { for (let k = 0; k < 500 && stiffcal.pending; k++)
        await new Promise((done) => setTimeout(done, 10)); }"""
    )
    assert not page.evaluate("stiffcal.pending")
