"""How pages are filled: none is more than a third empty."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import typst
from PIL import Image

from stiffcal.report import building
from stiffcal.report.content import ReportContent
from stiffcal.report.page_filling import FOOT_MM, SMALLEST, TOP_MM, PageLayout, Setting, filled
from stiffcal.report.typesetting import set_pages
from tests.laboratory.report_content import made_up_content

# Header and footer of an A4 page, mm.
_TOP, _BOTTOM, _HEIGHT = 24.0, 21.0, 297.0


def fills_of(content: ReportContent, folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return how far down each page is filled, as a share of the room between header and footer."""
    drawn: list[bytes] = []

    def also_draw(pages: dict[str, Any], place: Path, day: str) -> bytes:
        pdf = set_pages(pages, place, day)
        fonts = typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(place / "fonts")])
        pictures = typst.compile(str(place / "report.typ"), root=str(place), font_paths=fonts, format="png", ppi=24.0)
        drawn.extend(cast("list[bytes]", pictures))
        return pdf

    monkeypatch.setattr(building, "set_pages", also_draw)
    building.build_report(content, folder / "report.pdf")
    return list(map(_fill, drawn))


def _fill(page: bytes) -> float:
    ink = np.asarray(Image.open(io.BytesIO(page)).convert("L")) < 235
    low, high = (int(ink.shape[0] * share) for share in (_TOP / _HEIGHT, 1.0 - _BOTTOM / _HEIGHT))
    rows = np.flatnonzero(ink[low:high].any(axis=1))
    return float(rows.max(initial=0)) / (high - low)


def contents() -> Iterator[ReportContent]:
    """Yield a campaign with few runs, and one with many in poses of their own."""
    yield made_up_content()
    content = made_up_content(n_runs=60, per_run=4)
    runs = tuple(replace(run, joints=run.joints + 0.01 * number) for number, run in enumerate(content.runs))
    yield replace(content, runs=runs)


FEW, MANY = contents()


@pytest.mark.parametrize("content", [FEW, pytest.param(MANY, marks=pytest.mark.long)], ids=["few runs", "many runs"])
def test_no_page_is_more_than_a_third_empty(
    content: ReportContent, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fills = fills_of(content, tmp_path, monkeypatch)
    assert len(fills) >= 4
    assert min(fills) > 0.65, fills


def flowed(heights: Sequence[float], texts: Sequence[float], setting: Setting) -> PageLayout:
    """Set one picture after each text, as pages are filled: what does not fit is on the next one."""
    page, y = 1, TOP_MM
    begins, ends, pictures = [], [], []
    scaled = [height * size for height, size in zip(heights, setting.sizes, strict=True)]
    for text, picture in zip(texts, scaled, strict=True):
        for height, is_picture in ((text * setting.looseness, False), (picture, True)):
            if y + height > FOOT_MM:
                page, y = page + 1, TOP_MM
            begins.append((page, y))
            if is_picture:
                pictures.append((page, y))
            y += height
            ends.append((page, y))
    return PageLayout(page, tuple(begins), tuple(ends), tuple(pictures), tuple(scaled))


@pytest.mark.parametrize(
    ("heights", "texts"),
    [
        pytest.param((100.0, 100.0), (20.0, 40.0), id="a picture does not fit"),
        pytest.param((80.0, 80.0, 20.0), (30.0, 50.0, 10.0), id="a few lines on the last page"),
        pytest.param((90.0, 90.0, 90.0), (30.0, 40.0, 40.0), id="a last page that is half empty"),
    ],
)
def test_pictures_and_spaces_are_sized_so_that_pages_are_full(
    heights: tuple[float, ...], texts: tuple[float, ...]
) -> None:
    def laid_out(setting: Setting) -> PageLayout:
        return flowed(heights, texts, setting)

    usual = Setting((1.0,) * len(heights))
    chosen = filled(len(heights), laid_out)
    assert laid_out(usual).n_empty > 0 == laid_out(chosen).n_empty
    assert min(chosen.sizes) >= SMALLEST


def test_a_block_over_the_whole_of_a_page_leaves_sizes_as_they_are() -> None:
    """No block ends on the page after the empty one: it had no picture to begin with."""
    layout = PageLayout(4, ((1, TOP_MM), (2, TOP_MM)), ((1, TOP_MM + 40.0), (4, TOP_MM + 200.0)), (), ())
    assert filled(0, lambda setting: layout).sizes == ()
