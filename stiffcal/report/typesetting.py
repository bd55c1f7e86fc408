"""Setting pages with typst: offline, with matplotlib's own DejaVu fonts and no others, so that bytes repeat."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from typing import Any

from stiffcal.report.drawing_library import drawing_library

_TEMPLATE = "report.typ"
_FONT_FILES = (
    "DejaVuSans.ttf",
    "DejaVuSans-Bold.ttf",
    "DejaVuSans-Oblique.ttf",
    "DejaVuSans-BoldOblique.ttf",
    "DejaVuSansMono.ttf",
)


def set_pages(pages: dict[str, Any], folder: Path, day: str) -> bytes:
    """Compile the template with the data and pictures in `folder`.

    Parameters
    ----------
    pages : what the template reads as ``content.json``.
    folder : holds the pictures; the template and the fonts are put beside them.
    day : ISO date (or date and time, UTC) that the PDF carries as its own.

    Returns
    -------
    The PDF.
    """
    import typst

    matplotlib = drawing_library()
    moment = _moment(day)
    stamped = pages | {"day": [moment.year, moment.month, moment.day] if moment else None}
    (folder / "content.json").write_text(json.dumps(stamped, ensure_ascii=False), encoding="utf-8")
    template = resources.files("stiffcal.report").joinpath("pages", _TEMPLATE).read_text(encoding="utf-8")
    (folder / _TEMPLATE).write_text(template, encoding="utf-8")
    fonts = folder / "fonts"
    fonts.mkdir()
    for name in _FONT_FILES:
        shutil.copyfile(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name, fonts / name)
    only_these = typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[str(fonts)])
    timestamp = moment or datetime(1970, 1, 1, tzinfo=UTC)
    return typst.compile(str(folder / _TEMPLATE), root=str(folder), font_paths=only_these, timestamp=timestamp)


def _moment(day: str) -> datetime | None:
    """Read an ISO date or date and time; None where it is neither (it is then only printed)."""
    try:
        moment = datetime.fromisoformat(day)
    except ValueError:
        return None
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)
