"""The picture of README: the page of `stiffcal view --live` for a bundled campaign, an effect ticked.

`make readme-picture` writes docs/view.png. It needs Debian's chromium, or CHROMIUM=/path/to/chromium.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from docs.page_runs import MADE_BY_STIFFCAL, ROOT

PICTURE = ROOT / "docs" / "view.png"
CAMPAIGN = ROOT / "campaigns" / "hidden" / "03"
WIDTH, HEIGHT = 1360, 940
COLOURS = 128
MOST_BYTES = 150_000
SOFTWARE = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def write_picture() -> None:
    """Run the campaign as a user would, open its page, and write what the window shows.

    Raises
    ------
    SystemExit : there is no browser, or the picture is too large.
    """
    browser = os.environ.get("CHROMIUM") or shutil.which("chromium")
    if browser is None:
        raise SystemExit("no browser: apt-get install chromium, or say CHROMIUM=/path/to/chromium")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "my-03"
        shutil.copytree(CAMPAIGN, folder, ignore=MADE_BY_STIFFCAL)
        environment = {**os.environ, "STIFFCAL_STATE": str(Path(name) / "state")}
        words = [sys.executable, "-P", "-m", "stiffcal"]
        subprocess.run([*words, "diagnose", str(folder)], check=True, env=environment, stdout=subprocess.DEVNULL)
        serve = [*words, "view", str(folder), "--live", "--json"]
        with subprocess.Popen(serve, env=environment, stdout=subprocess.PIPE, text=True) as server:
            data = _compressed(_window(_address(server), browser))
            server.terminate()
    if len(data) > MOST_BYTES:
        raise SystemExit(f"the picture has {len(data)} bytes, more than {MOST_BYTES}")
    PICTURE.write_bytes(data)
    sys.stdout.write(f"{PICTURE.relative_to(ROOT)}: {len(data)} bytes\n")


def _address(server: subprocess.Popen[str]) -> str:
    """Return the address of a live page from what the command prints of it."""
    printed = ""
    for line in server.stdout or ():
        printed += line
        with contextlib.suppress(json.JSONDecodeError):
            return str(json.loads(printed)["address"])
    raise SystemExit("the page is not served")


def _window(address: str, browser: str) -> bytes:
    """Return what a window shows of a page whose first candidate was ticked, as PNG."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        started = play.chromium.launch(executable_path=browser, args=SOFTWARE)
        context = started.new_context(
            viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light", reduced_motion="reduce"
        )
        window = context.new_page()
        window.goto(address)
        window.wait_for_selector("body[data-ready]")
        window.locator("#candidates input").first.check()
        while window.evaluate("stiffcal.waitsFor !== '' || stiffcal.pending || stiffcal.wanted.added.length === 0"):
            window.wait_for_timeout(100)
        shown = bytes(window.screenshot(animations="disabled"))
        started.close()
    return shown


def _compressed(picture: bytes) -> bytes:
    """Return a PNG with few colours."""
    from PIL import Image

    image = Image.open(io.BytesIO(picture)).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    out = io.BytesIO()
    image.save(out, "PNG", optimize=True)
    return out.getvalue()


if __name__ == "__main__":
    write_picture()
