"""Sheets of OpenDocument (``.ods``), as LibreOffice writes them, read as workbooks of Excel are.

Options of the manifest (``ods = {…}``), all optional:

sheet : its name; may be left out where one visible sheet alone holds numbers.
skip_rows : rows before the one with the names; found where left out: titles and blank rows may stand above.
unit_row : True where the row after the names holds units; recognised where left out.
decimal : the decimal mark of numbers that are stored as text.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.sax.saxutils import escape

from stiffcal.readers import FuzzInput
from stiffcal.readers.xlsx import XlsxReader

KIND = "application/vnd.oasis.opendocument.spreadsheet"
MANIFEST = (
    '<?xml version="1.0" encoding="UTF-8"?>'
    '<manifest:manifest xmlns:manifest="urn:oasis:names:tc:opendocument:xmlns:manifest:1.0">'
    f'<manifest:file-entry manifest:full-path="/" manifest:media-type="{KIND}"/></manifest:manifest>'
)
_SPACES = " ".join(
    f'xmlns:{name}="urn:oasis:names:tc:opendocument:xmlns:{name}:1.0"' for name in ("office", "table", "text")
)


def _write_fuzz_input(path: Path) -> None:
    rows: list[list[str | float]] = [["t", "Fx", "run"]]
    rows += [[0.01 * k, k - 30.5, f"pose{k // 20}"] for k in range(60)]
    write_ods(path, rows)


def write_ods(path: Path, rows: list[list[str | float]]) -> None:
    """Write a document with one sheet, called "log"."""
    lines = "".join(f"<table:table-row>{''.join(map(_cell, row))}</table:table-row>" for row in rows)
    body = f'<office:spreadsheet><table:table table:name="log">{lines}</table:table></office:spreadsheet>'
    content = (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f"<office:document-content {_SPACES}><office:body>{body}</office:body></office:document-content>"
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("mimetype", KIND)
        archive.writestr("META-INF/manifest.xml", MANIFEST)
        archive.writestr("content.xml", content, zipfile.ZIP_DEFLATED)


def _cell(value: str | float) -> str:
    if isinstance(value, str):
        return f'<table:table-cell office:value-type="string"><text:p>{escape(value)}</text:p></table:table-cell>'
    return f'<table:table-cell office:value-type="float" office:value="{value!r}"/>'


class OdsReader(XlsxReader):
    """Reads a sheet in batches of rows."""

    name = "ods"
    endings = (".ods",)
    first_bytes = b""
    fuzz_inputs = (FuzzInput(".ods", _write_fuzz_input, ("t", "Fx"), ("run",)),)


READER = OdsReader()
