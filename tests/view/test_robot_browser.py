"""The picture of the robot in a real browser: as large as there is room, from every side, and clear of its words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.laboratory.browser import opened, settled

pytestmark = pytest.mark.browser


def test_the_robot_fills_its_picture_from_every_side(page: Any) -> None:
    # the lowest and highest place of a body's colour, as a share of the picture below its words
    reach = """() => { const c = document.getElementById("robot-canvas"), { width, height } = c, g = c.getContext("2d");
        const d = g.getImageData(0, 0, width, height).data, ground = d.slice(0, 3).join();
        const rows = new Set(), columns = new Set();
        for (let y = 60; y < height; y++) for (let x = 60; x < width; x++) {
          const at = 4 * (y * width + x);
          if (d.slice(at, at + 3).join() !== ground) { rows.add(y); columns.add(x); }
        }
        return [rows.size / height, columns.size / width]; }"""
    pictures = set()
    for camera in ("oblique", "front", "side", "top"):
        page.locator("#robot").get_by_role("button", name=camera, exact=True).click()
        settled(page)
        assert max(page.evaluate(reach)) > 0.6, camera
        pictures.add(page.locator("#robot-canvas").screenshot())
    assert len(pictures) == 4


@pytest.mark.parametrize("size", [(800, 600), (1400, 900)], ids=["small", "usual"])
def test_the_robot_is_not_drawn_under_its_words(browser: Any, file: Path, size: tuple[int, int]) -> None:
    page, complaints = opened(browser, file, viewport={"width": size[0], "height": size[1]})
    words = """() => { const c = document.getElementById("robot-canvas"), high = 20;
        return c.getContext("2d").getImageData(0, 0, c.width, high).data.join(); }"""
    strips = set()
    for camera in ("oblique", "front", "side", "top"):
        page.locator("#robot").get_by_role("button", name=camera, exact=True).click()
        for zoom in (1, 4):
            page.evaluate("(zoom) => stiffcal.set({ zoom })", zoom)
            settled(page)
            strips.add(page.evaluate(words))
    assert complaints == []
    assert len(strips) == 1
    page.context.close()
