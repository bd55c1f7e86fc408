"""How pages are filled: none more than half empty before the last."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import typst
from matplotlib.figure import Figure
from PIL import Image

from stiffcal.errors import no_progress
from stiffcal.report import building
from stiffcal.report.blocks import Paragraph, PictureBlock, ReportSection, SubheadingBlock
from stiffcal.report.content import ReportContent
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
def test_no_page_is_more_than_half_empty_before_the_last(
    content: ReportContent, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fills = fills_of(content, tmp_path, monkeypatch)
    assert len(fills) >= 4
    assert min(fills[:-1]) > 0.5, fills


def test_what_opens_a_section_stays_with_its_first_subheading(tmp_path: Path) -> None:
    picture = PictureBlock(lambda: Figure(), "A picture.")
    blocks = (
        Paragraph("What it is about."),
        SubheadingBlock("First"),
        Paragraph("Text."),
        SubheadingBlock("Second"),
        picture,
    )
    (section,) = building._as_data([ReportSection("Section", blocks)], tmp_path, no_progress)
    assert [block.get("before_picture") for block in section["blocks"]] == [True, False, False, True, None]
