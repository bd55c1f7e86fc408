"""Tables as files for other programs: CSV, workbook, Parquet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffcal.store.workbook import ENDING, check_size, write_workbook
from stiffcal.trust.output_kinds import OutputKind
from stiffcal.trust.outputs import written

if TYPE_CHECKING:
    import pyarrow as pa


def write_table(
    table: pa.Table | Mapping[str, Any],
    output: Path,
    kind: OutputKind,
    *,
    raw_text: bool = False,
    overwrite: bool = False,
) -> None:
    """Write a table as CSV, workbook or Parquet, by the file's ending.

    Parameters
    ----------
    table : columns by name. output : the file. kind : of what it is.
    raw_text : CSV only: leave texts as they are, also those that a spreadsheet takes for formulas.
    overwrite : also a file that holds something stiffcal did not write.

    Raises
    ------
    InputError : the file cannot be written, or holds something else.
    """
    import pyarrow as pa

    from stiffcal.measurements.columns import table_of

    whole = table if isinstance(table, pa.Table) else table_of(dict(table))
    if output.suffix.lower() == ENDING:
        check_size(str(output), whole.num_rows, whole.num_columns)
    with written(output, kind, overwrite) as temporary:
        if output.suffix.lower() == ".parquet":
            import pyarrow.parquet as parquet

            with temporary.open("wb") as file:  # as a path pyarrow takes no name that is not UTF-8
                parquet.write_table(whole, file)
        elif output.suffix.lower() == ENDING:
            rows = (row for batch in whole.to_batches() for row in zip(*(c.to_pylist() for c in batch), strict=True))
            write_workbook(temporary, whole.column_names, rows, "stiffcal")
        else:
            from pyarrow import csv

            cells = whole if raw_text else _for_spreadsheets(whole)
            with temporary.open("wb") as file:
                csv.write_csv(cells, file, csv.WriteOptions(quoting_style="needed"))


def _for_spreadsheets(table: pa.Table) -> pa.Table:
    """Return a table whose texts, names of columns included, are no formulas of a spreadsheet."""
    import pyarrow as pa

    from stiffcal.escapes import csv_cell

    for number, name in enumerate(table.column_names):
        column = table.column(number)
        if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
            words = column.to_pylist()
            cells = {word: csv_cell.escaped(word) for word in set(words) if word is not None}
            if any(word != cell for word, cell in cells.items()):
                table = table.set_column(number, name, pa.array([cells.get(word) for word in words], column.type))
    return table.rename_columns([csv_cell.escaped(name) for name in table.column_names])
