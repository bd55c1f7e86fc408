"""How a text log is laid out: what the manifest states, and what its first lines show where it states nothing."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.escapes import csv_cell, toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import COLUMNS
from stiffcal.log_columns import nearest_name, single_character
from stiffcal.readers import Options, WantedColumns, check_columns, check_is_log, check_options
from stiffcal.readers.csv.lines import LogText, find_codec
from stiffcal.readers.csv.rewriting import rewriting_of
from stiffcal.table_layout.sections import first_table, title_line, titles_of_sections
from stiffcal.table_layout.text import FIRST_BYTES, TextLayout, text_layout

LONGEST_HEADER = 100_000  # bytes: a thousand columns of long names; csv itself stops at 131072 a cell


class CsvOptions(TomlTable):
    """How a text file is written; what is left out is recognised by its first lines.

    Attributes
    ----------
    delimiter : a single character, "tab", or " " for one blank or several. decimal : "." or ",".
    encoding : Python's name of it. skip_rows : lines before the header.
    unit_row : True where the line after the header holds units.
    section : the name of one of several tables in the file, in the line above it.
    """

    delimiter: Name | None = None
    decimal: Literal[".", ","] | None = None
    encoding: Name | None = None
    skip_rows: Annotated[int, Field(ge=0)] | None = None
    unit_row: bool | None = None
    section: Name | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "sep": "delimiter", "separator": "delimiter", "skiprows": "skip_rows", "header": "skip_rows",
        "header_lines": "skip_rows", "units_row": "unit_row",
        "table": "section", "part": "section",
    }  # fmt: skip


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
) -> Iterator[tuple[LogText, TextLayout]]:
    """Open a log and read its header; the text stands at the first data line.

    Raises
    ------
    InputError
        For an unknown option, an unreadable or empty file, a wrong encoding, a missing or repeated wanted column.
    """
    check_options(options, CsvOptions, "csv", display_name)
    encoding = options.get("encoding")
    if encoding is not None:
        find_codec(str(encoding), display_name)
    # Only words need decoding; for numbers the bytes are enough, where the encoding agrees with ASCII.
    text = LogText(path, None if encoding is None else str(encoding), display_name, bool(wanted.texts or wanted.times))
    try:
        layout = _read_layout(text, path, options, display_name, wanted)
        text.keep_empty_lines = len(layout.columns) == 1
        text.stray_quote = stray_quote(layout.delimiter)
        rewriting = rewriting_of(layout)
        text.ends_at_gap = bool(layout.section)
        if rewriting is not None or text.ends_at_gap:
            text.rewrite_lines(rewriting or _as_they_are)
        yield text, layout
    finally:
        text.close()


def _as_they_are(lines: bytes) -> bytes:
    return lines


def section_titles(path: Path, options: Options, display_name: str) -> list[str]:
    """Return the names of the tables in a file that holds several; empty where it is one table.

    Raises
    ------
    InputError
        The file is unreadable, or not of the encoding that the options state.
    """
    encoding = options.get("encoding")
    with LogText(path, None if encoding is None else str(encoding), display_name) as text:
        titles = titles_of_sections(line.decode("utf-8", "replace") for line in text.lines())
    return titles if len(titles) > 1 else []


def _at_section(text: LogText, path: Path, options: Options, display_name: str) -> int:
    """Go to the table that the options name; return the number of lines before it.

    Raises
    ------
    InputError
        There is none of the name.
    """
    section = options.get("section")
    if section is None:
        return 0
    encoding = text.encoding if text.not_yet_decoded else "utf-8"
    if not text.find_line(title_line(str(section), encoding)):
        titles = section_titles(path, options, display_name)
        raise InputError.at(
            FaultCode.LOG_PART_MISSING,
            display_name,
            "csv.section",
            f"no line that holds {section!r} alone",
            nearest_name(str(section), titles),
        )
    return text.line_number


def _read_layout(text: LogText, path: Path, options: Options, display_name: str, wanted: WantedColumns) -> TextLayout:
    skip = options.get("skip_rows")
    assert skip is None or isinstance(skip, int)
    decimal, delimiter, unit_row = (
        single_character(options, "decimal", display_name),
        single_character(options, "delimiter", display_name),
        options.get("unit_row"),
    )
    if decimal is not None and decimal not in ".,":
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            display_name,
            "csv.decimal",
            f"{decimal!r} is not a decimal mark",
            'give "." or ","',
        )
    before = _at_section(text, path, options, display_name)
    first = _first_lines(text, skip or 0, display_name)
    section = str(options.get("section") or "")
    first = first_table(first) if section else first
    if not any(line.strip() for line in first.split("\n")[skip or 0 :]):
        empty = path.stat().st_size == 0
        skipped = f"before its header (csv.skip_rows is {skip})" if skip else "without a line that holds anything"
        reason = "the file is empty" if empty else f"the file ends {skipped}"
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            display_name,
            "",
            reason,
            "correct csv.skip_rows or log again" if skip and not empty else "log again",
        )
    layout = text_layout(
        first,
        text.encoding,
        delimiter=delimiter,
        decimal=decimal,
        skip_rows=skip,
        unit_row=unit_row if isinstance(unit_row, bool) else None,
        wanted=wanted.names,
    )
    requested = set(wanted.names)
    columns = tuple(name if name in requested else csv_cell.original(name) for name in layout.columns)
    COLUMNS.check(len(columns), display_name, layout.header_place)
    layout = replace(layout, rows=replace(layout.rows, columns=columns))
    hint = "" if requested <= set(columns) else _settings_hint(first, layout, options, wanted)
    check_columns(wanted, columns, display_name, layout.header_place, hint)
    for name in wanted.names:
        if columns.index(name) >= layout.rows.shortest:
            raise InputError.at(
                FaultCode.COLUMN_MISSING,
                display_name,
                layout.header_place,
                f"below the name {name!r} no row has a cell",
                "name another column, or export this one",
            )
    for _ in range(layout.first_data_line - 1):
        text.next_line()
    return replace(
        layout,
        header_line=layout.header_line + before if layout.header_line else 0,
        first_data_line=layout.first_data_line + before,
        section=section,
    )


def _first_lines(text: LogText, skip: int, display_name: str) -> str:
    """Return the log's first whole lines, which the text still holds, as words.

    Raises
    ------
    InputError
        They hold bytes of another encoding than it was given, or a line too long for a header.
    """
    content = text.peek(FIRST_BYTES, skip)
    check_is_log(Path(display_name), display_name, content)
    lines = content.split(b"\n")
    header = next((k for k, line in enumerate(lines) if k >= skip and line.strip()), 0)
    if len(lines[header]) > LONGEST_HEADER:
        reason = f"a line of {len(lines[header])} characters in place of the column names"
        raise InputError.at(
            FaultCode.HEADER_MISSING,
            display_name,
            f"line {header + 1}",
            reason,
            "name a log of text lines, or its format",
        )
    if b"\0" in lines[header]:
        mend = 'set csv.encoding = "utf-16" if it is, else copy the file again from its origin'
        raise InputError.at(
            FaultCode.ENCODING_WRONG,
            display_name,
            f"line {header + 1}",
            "the line contains bytes that are not text (NUL)",
            mend,
        )
    encoding = text.encoding if text.not_yet_decoded else "utf-8"
    try:
        lines[header].decode(encoding)
    except UnicodeDecodeError as error:
        reason = f"byte 0x{lines[header][error.start]:02x} is not {encoding}"
        raise InputError.at(
            FaultCode.ENCODING_WRONG,
            display_name,
            f"line {header + 1}",
            reason,
            'set csv.encoding, e.g. "latin-1" or "cp1252", or leave it out',
        ) from None
    return content.decode(encoding, "replace")


def _settings_hint(first: str, layout: TextLayout, options: Options, wanted: WantedColumns) -> str:
    """Return the settings to write where the log's lines show the wanted columns without those of the manifest."""
    found = text_layout(first, layout.encoding, wanted=wanted.names)
    if not set(wanted.names) <= set(found.columns):
        return ""
    settings = []
    if options.get("skip_rows") is not None and found.header_line != layout.header_line:
        settings.append(f"csv.skip_rows = {max(found.header_line - 1, 0)}")
    if options.get("delimiter") is not None and found.delimiter != layout.delimiter:
        settings.append(f"csv.{toml_text.pair('delimiter', found.delimiter)}")
    return f"the names are in {found.header_place}: set " + " and ".join(settings) if settings else ""
