"""Setting pages with typst: offline, with matplotlib's own DejaVu fonts, so that bytes repeat.

Other fonts are used only for letters that DejaVu lacks, see `stiffcal.report.fonts`.
"""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from typing import Any

from stiffcal.escapes.json_text import document_text
from stiffcal.report.fonts import drawable_data, further_fonts, own_fonts, texts_of
from stiffcal.report.page_filling import PageLayout, Setting, filled, layout_from

_TEMPLATE = "report.typ"
# typst keeps what it made of a document until so many others have been set without needing it.
_DOCUMENTS_KEPT = 10


def set_pages(pages: dict[str, Any], folder: Path, day: str) -> bytes:
    """Compile the template with the data and pictures in `folder`.

    Parameters
    ----------
    pages : what the template reads as ``content.json``.
    folder : holds the pictures; the template and the fonts are put into it.
    day : ISO date (or date and time, UTC) that the PDF carries as its own.

    Returns
    -------
    The PDF.
    """
    import typst

    date = _parse_date(day)
    stamped = drawable_data(pages | {"day": [date.year, date.month, date.day] if date else None})
    (folder / "content.json").write_text(document_text(stamped, indent=None), encoding="utf-8")
    template = resources.files("stiffcal.report").joinpath("pages", _TEMPLATE).read_text(encoding="utf-8")
    (folder / _TEMPLATE).write_text(template, encoding="utf-8")
    fonts = folder / "fonts"
    fonts.mkdir()
    for font in (*own_fonts(), *further_fonts(texts_of(pages))):
        shutil.copyfile(font, fonts / font.name)
    only_these = typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(fonts)])
    timestamp = date or datetime(1970, 1, 1, tzinfo=UTC)
    file, root = str(folder / _TEMPLATE), str(folder)

    def write(setting: Setting) -> None:
        (folder / "setting.json").write_text(document_text(asdict(setting), indent=None), encoding="utf-8")

    def laid_out(setting: Setting) -> PageLayout:
        write(setting)
        return layout_from(
            json.loads(typst.query(file, "<layout>", field="value", one=True, root=root, font_paths=only_these))
        )

    n_pictures = sum(block["kind"] == "picture" for section in pages["sections"] for block in section["blocks"])
    try:
        write(filled(n_pictures, laid_out))
        return typst.compile(file, root=root, font_paths=only_these, timestamp=timestamp)
    finally:
        _give_back_memory()


def _give_back_memory() -> None:
    """Have typst forget the pages that it has set, by setting empty ones: up to 20 MB a report.

    It has no other way to ask for that, and takes 7 ms.
    """
    import typst

    without_fonts = typst.Fonts(include_system_fonts=False, include_embedded_fonts=False)
    for _ in range(_DOCUMENTS_KEPT + 1):
        typst.compile(b"", font_paths=without_fonts)


def _parse_date(day: str) -> datetime | None:
    """Read an ISO date or date and time; None where it is neither (it is then only printed)."""
    try:
        date = datetime.fromisoformat(day)
    except ValueError:
        return None
    return date if date.tzinfo else date.replace(tzinfo=UTC)
