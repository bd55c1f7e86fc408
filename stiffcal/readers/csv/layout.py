"""How a text log is laid out: where its header stands, what separates its cells, which units it states."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from stiffcal.campaign.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell, toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import COLUMNS
from stiffcal.log_columns import single_character
from stiffcal.measurements.scope_export import NAME, PROPERTIES, is_scope_header, scope_columns, scope_units
from stiffcal.readers import Options, WantedColumns, check_columns, check_options
from stiffcal.readers.csv.lines import LogText, find_codec

DELIMITERS = ",;\t|"
# In how many lines from the start the column names are looked for, to say what skip_rows should be.
HEADER_SEARCH = 60
LONGEST_HEADER = 100_000  # bytes: a thousand columns of long names; csv itself stops at 131072 a cell
UNIT_WORDS = (
    "s sec ms us µs μs ns min h n kn mn nm knm nmm ncm m mm cm um µm μm deg ° rad mrad urad µrad μrad rev turn a ma v"
    " mv degc °c c k kg g hz khz rpm pa bar lbf - % iso8601"
)
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


class CsvOptions(TomlTable):
    """How a text file is written.

    Attributes
    ----------
    delimiter : a single character or "tab"; recognised where left out. decimal : "." where left out.
    encoding : Python's name of it; UTF-8 where left out. skip_rows : lines before the header.
    unit_row : True where the line after the header holds units; recognised where left out.
    """

    delimiter: Name | None = None
    decimal: Literal[".", ","] | None = None
    encoding: Name | None = None
    skip_rows: Annotated[int, Field(ge=0)] | None = None
    unit_row: bool | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "sep": "delimiter", "separator": "delimiter", "skiprows": "skip_rows", "header": "skip_rows",
        "header_lines": "skip_rows", "units_row": "unit_row",
    }  # fmt: skip


@dataclass(frozen=True)
class LogLayout:
    """How a text log is to be read."""

    columns: tuple[str, ...]
    """The names in the header line."""
    units: dict[str, str]
    """Column name to unit where there is a unit row."""
    delimiter: str
    """The character between columns."""
    decimal: str
    """The decimal mark."""
    encoding: str
    """The file's encoding."""
    header_line: int
    """Number of the line with the names, from 1."""
    has_unit_row: bool
    """True where the line after the names holds units."""
    properties: int = 0
    """Number of further lines between the names and the data."""

    @property
    def first_data_line(self) -> int:
        """Number of the first line that can hold data."""
        return self.header_line + 1 + self.has_unit_row + self.properties

    def split(self, line: str, strict: bool = False) -> list[str]:
        """Return the cells of one line, without the blanks around them; `strict`: `csv.Error` for stray quotation."""
        for row in csv.reader([line], delimiter=self.delimiter, strict=strict):
            # Blanks as the parser defines them: no-break spaces and the like belong to the cell.
            return [cell.strip(" \t") for cell in row]
        return [""]

    def is_number(self, cell: str) -> bool:
        """Return True for a decimal number with this file's decimal mark."""
        if self.decimal != ".":
            if "." in cell:
                return False
            cell = cell.replace(self.decimal, ".")
        return NUMBER.fullmatch(cell) is not None


def stray_quote(delimiter: str) -> re.Pattern[bytes]:
    """Return the pattern of a quotation mark that stands neither at the start nor at the end of a cell.

    Examples
    --------
    >>> [bool(stray_quote(",").search(line)) for line in (b'"1","2"', b'1,"a ""b"" c"', b'1,"2"3')]
    [False, False, True]
    """
    border = re.escape(delimiter.encode()) + rb'"\n'
    return re.compile(rb"[^" + border + rb'][ \t]*"[ \t]*[^' + border + rb" \t]")


@contextmanager
def open_log(
    path: Path, options: Options, display_name: str, wanted: WantedColumns
) -> Iterator[tuple[LogText, LogLayout]]:
    """Open a log and read its header; the text stands at the first data line.

    Raises
    ------
    InputError
        For an unknown option, an unreadable or empty file, a wrong encoding, a missing or repeated wanted column.
    """
    check_options(options, CsvOptions, "csv", display_name)
    encoding = str(options.get("encoding") or "utf-8")
    find_codec(encoding, display_name)
    # Only words need decoding; for numbers the bytes are enough, where the encoding agrees with ASCII.
    text = LogText(path, encoding, display_name, decode=bool(wanted.texts or wanted.times))
    try:
        layout = _read_layout(text, path, options, display_name, wanted)
        text.keep_empty_lines = len(layout.columns) == 1
        text.stray_quote = stray_quote(layout.delimiter)
        yield text, layout
    finally:
        text.close()


def _read_layout(text: LogText, path: Path, options: Options, display_name: str, wanted: WantedColumns) -> LogLayout:
    skip = options.get("skip_rows") or 0
    assert isinstance(skip, int)
    decimal = single_character(options, "decimal", display_name) or "."
    if decimal not in ".,":
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            display_name,
            "csv.decimal",
            f"{decimal!r} is not a decimal mark",
            'give "." or ","',
        )
    for _ in range(skip):
        if text.next_line() is None:
            break
    line = text.next_line()
    while line is not None and not line.strip():
        line = text.next_line()
    if line is None:
        empty = path.stat().st_size == 0
        reason = "the file is empty" if empty else f"the file ends before its header (csv.skip_rows is {skip})"
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            display_name,
            "",
            reason,
            "log again" if empty else "correct csv.skip_rows or log again",
        )
    if len(line) > LONGEST_HEADER:
        reason = f"a line of {len(line)} characters in place of the column names"
        raise InputError.at(
            FaultCode.HEADER_MISSING,
            display_name,
            f"line {text.line_number}",
            reason,
            "name a log of text lines, or its format",
        )
    header = decode_line(text, line, display_name)
    delimiter = single_character(options, "delimiter", display_name) or _find_delimiter(header, wanted, decimal)
    header_line = text.line_number
    cells = LogLayout((), {}, delimiter, decimal, "", 0, False).split(header)
    COLUMNS.check(len(cells), display_name, f"line {header_line}")
    requested = set(wanted.names)
    columns = tuple(cell if cell in requested else csv_cell.original(cell) for cell in cells)
    scope = _read_scope(text, columns, delimiter, decimal) if columns[:1] == (NAME,) else None
    if scope is not None:
        check_columns(wanted, scope.columns, display_name, f"line {header_line}")
        return scope
    delimiter_given = options.get("delimiter") is not None
    hint = (
        ""
        if set(wanted.names) <= set(columns)
        else _header_hint(path, text, display_name, wanted, delimiter, delimiter_given, skip)
    )
    check_columns(wanted, columns, display_name, f"line {header_line}", hint)
    layout = LogLayout(columns, {}, delimiter, decimal, text.encoding, header_line, False)
    units = _read_units(text, layout, options.get("unit_row"), wanted)
    if units is None:
        return layout
    return LogLayout(columns, units, delimiter, decimal, text.encoding, header_line, True)


def _read_scope(text: LogText, names: tuple[str, ...], delimiter: str, decimal: str) -> LogLayout | None:
    """Take the rows of properties of a scope's export; None and nothing taken where it is none."""
    line, header_line = text.next_line(), text.line_number
    plain = LogLayout((), {}, delimiter, decimal, text.encoding, header_line - 1, False)
    units: list[str] = []
    columns: tuple[str, ...] = ()
    while line is not None and len(line) <= LONGEST_HEADER:
        cells = plain.split(line.decode(text.encoding if text.not_yet_decoded else "utf-8", "replace"))
        if not columns:
            if not is_scope_header(names, cells):
                break
            columns = scope_columns(names)
        if any(cells) and cells[0] not in PROPERTIES:
            break
        units = cells if any(cells) and cells[0] == "Unit" else units
        line = text.next_line()
    if line is not None:
        text.give_back(line)
    if not columns:
        return None
    return replace(
        plain,
        columns=columns,
        units=scope_units(names, columns, units),
        properties=text.line_number - plain.header_line,
    )


def decode_line(text: LogText, line: bytes, display_name: str) -> str:
    """Return a line as text; raises `InputError` where its bytes are of another encoding.

    Lines come undecoded where the encoding agrees with ASCII (`LogText.not_yet_decoded`), else as UTF-8.
    """
    encoding = text.encoding if text.not_yet_decoded else "utf-8"
    place = f"line {text.line_number}"
    if line.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in line:
        mend = 'set csv.encoding = "utf-16" if it is, else copy the file again from its origin'
        raise InputError.at(
            FaultCode.ENCODING_WRONG, display_name, place, "the line contains bytes that are not text (NUL)", mend
        )
    try:
        return line.decode(encoding)
    except UnicodeDecodeError as error:
        reason = f"byte 0x{line[error.start]:02x} is not {encoding}"
        raise InputError.at(
            FaultCode.ENCODING_WRONG, display_name, place, reason, 'set csv.encoding, e.g. "latin-1" or "cp1252"'
        ) from None


def _find_delimiter(header: str, wanted: WantedColumns, decimal: str) -> str:
    """Return the delimiter under which the wanted columns are found; else the one that gives most columns."""

    def merit(delimiter: str) -> tuple[int, int, bool]:
        names = next(csv.reader([header], delimiter=delimiter), [])
        n_wanted = len({name.strip() for name in names} & set(wanted.names))
        return n_wanted, len(names), delimiter != decimal

    # A log of one column has no delimiter; then any that is not the decimal mark will do.
    candidates: tuple[str, ...] = (*DELIMITERS, " ")
    return max(candidates, key=merit)


def _header_hint(
    path: Path,
    text: LogText,
    display_name: str,
    wanted: WantedColumns,
    delimiter: str,
    delimiter_given: bool,
    skip: int,
) -> str:
    """Return the settings to write if the names stand in another line or with another delimiter; "" if nowhere."""
    with LogText(path, text.encoding, display_name) as search:
        for _ in range(HEADER_SEARCH):
            line = search.next_line()
            if line is None:
                break
            for candidate in dict.fromkeys((delimiter, *DELIMITERS, " ")) if len(line) <= LONGEST_HEADER else ():
                cells = next(csv.reader([line.decode("utf-8", "replace")], delimiter=candidate), [])
                if not set(wanted.names) <= {cell.strip() for cell in cells}:
                    continue
                settings = []
                if search.line_number != text.line_number and search.line_number != skip + 1:
                    settings.append(f"csv.skip_rows = {search.line_number - 1}")
                if candidate != delimiter and delimiter_given:
                    settings.append(f"csv.{toml_text.pair('delimiter', candidate)}")
                if settings:
                    return f"the names are in line {search.line_number}: set " + " and ".join(settings)
    return ""


def _read_units(text: LogText, layout: LogLayout, asked: object, wanted: WantedColumns) -> dict[str, str] | None:
    """Take the line after the names if it holds units; None and nothing taken where it does not."""
    if asked is False:
        return None
    line = text.next_line()
    if line is None:
        return None
    if len(line) > LONGEST_HEADER:
        text.give_back(line)
        return None
    cells = layout.split(line.decode(text.encoding if text.not_yet_decoded else "utf-8", "replace"))
    units = {name: cell.strip("[]() ") for name, cell in zip(layout.columns, cells, strict=False) if cell}
    if asked is True or (
        _all_units(list(units.values()))
        and len(cells) == len(layout.columns)
        and any(units.get(name) for name in wanted.numbers or layout.columns)
    ):
        return {name: unit for name, unit in units.items() if unit}
    text.give_back(line)
    return None


def _all_units(words: Sequence[str]) -> bool:
    """Return True where every word is a unit known to this program, and none is a number."""

    def parts(word: str) -> list[str]:
        return (
            [factor.rstrip("²³23^-") for factor in re.split(r"[*·./ ]", word.lower()) if factor]
            if word != "-"
            else ["-"]
        )

    unit_words = set(UNIT_WORDS.split())
    return bool(words) and all(parts(word) and all(factor in unit_words for factor in parts(word)) for word in words)
