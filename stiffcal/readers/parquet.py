"""Parquet tables, as pandas, polars, DuckDB or a logger write them. No options.

Numbers of any kind are read as float64; times may be timestamps or ISO 8601 words. A column inside a group goes by its
path, ``pose.x``.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.readers import FuzzInput, ParsedReader


class ParquetOptions(TomlTable):
    """Nothing to say yet: a Parquet file carries names and types itself."""


def _write_fuzz_input(path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as parquet

    rows = range(60)
    columns = {"t": [k / 100 for k in rows], "Fx": [k - 30.5 for k in rows], "run": [f"pose{k // 20}" for k in rows]}
    parquet.write_table(pa.table(columns), path, row_group_size=20)


class ParquetReader(ParsedReader):
    """Reads Parquet files in batches of rows."""

    name = "parquet"
    endings = (".parquet", ".pq")
    first_bytes = b"PAR1"
    options = ParquetOptions
    fuzz_inputs = (FuzzInput(".parquet", _write_fuzz_input, ("t", "Fx"), ("run",)),)


READER = ParquetReader()
