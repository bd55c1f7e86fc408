"""Workbooks of Excel (``.xlsx``, ``.xlsm``), read without Excel. Macros are not run.

Options of the manifest (``xlsx = {…}``), all optional:

sheet : its name; may be left out where one visible sheet alone holds numbers.
skip_rows : rows before the one with the names; found where left out: titles and blank rows may stand above.
unit_row : True where the row after the names holds units; recognised where left out.
decimal : the decimal mark of numbers that are stored as text.

Numbers are those in the file, however many digits a cell shows. Of a formula the value is read that it had when the
file was saved; a cell that holds a formula without a value, or an error, is refused by its name. Dates are read as
times without a zone, by the calendar of the workbook (1900 or 1904); times of day and durations as seconds. A word in
merged cells, as a name above several columns, holds for each of them; a number is refused, as one reading does not
count for several rows. Hidden rows and columns are read like all others, and said; hidden sheets only by their name.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.readers import FuzzInput, Options, ParsedReader


class SheetOptions(TomlTable):
    """Where in a workbook the table stands.

    Attributes
    ----------
    sheet : its name; the only visible one with numbers where left out. skip_rows : rows before the names.
    unit_row : True where the row after the names holds units. decimal : of numbers that are stored as text.
    """

    sheet: Name | None = None
    skip_rows: Annotated[int, Field(ge=0)] | None = None
    unit_row: bool | None = None
    decimal: Literal[".", ","] | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "sheet_name": "sheet", "worksheet": "sheet", "table": "sheet", "skiprows": "skip_rows", "header": "skip_rows",
        "units_row": "unit_row",
    }  # fmt: skip


def _write_fuzz_input(path: Path) -> None:
    import xlsxwriter

    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet("log")
        sheet.write_row(0, 0, ["t", "Fx", "run"])
        for k in range(60):
            sheet.write_row(k + 1, 0, [0.01 * k, k - 30.5, f"pose{k // 20}"])


class XlsxReader(ParsedReader):
    """Reads a sheet in batches of rows."""

    name = "xlsx"
    endings: ClassVar[tuple[str, ...]] = (".xlsx", ".xlsm", ".xlsb")
    first_bytes = b"\xd0\xcf\x11\xe0"  # Excel 97 to 2003, which is refused by its name
    options = SheetOptions
    holds_tables = True
    has_remarks = True
    fuzz_inputs = (FuzzInput(".xlsx", _write_fuzz_input, ("t", "Fx"), ("run",)),)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``data row n``: blank rows between are not counted."""
        return f"data row {row}"


READER = XlsxReader()
