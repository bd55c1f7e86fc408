"""Debian's chromium for the tests that look at pages."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

SOFTWARE = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
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
