"""MATLAB's MAT files: version 5 to 7 (`save`), and 7.3 (``save -v7.3``), which is HDF5 inside.

Options of the manifest (``mat = {…}``), all optional:

variable : the struct whose fields are the columns, or the matrix that holds them; members by points: ``log.ft``.
    Absent: the file's own variables are the columns, or the fields of its only struct.
columns : the names of a matrix's columns, in order.

A column is a vector, or one column of a matrix; words are a cell array of character vectors. What MATLAB stores in a
form of its own (table, timetable, datetime, string) is not readable outside it and is refused by name.

Version 7.3 is read in pieces. Version 5 packs each variable whole, so that the wanted ones are held in memory (MATLAB
itself bounds each to 2 GB).
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.readers import FuzzInput, ParsedReader


class MatOptions(TomlTable):
    """Where in a MAT file the columns lie.

    Attributes
    ----------
    variable : the struct whose fields they are, or the matrix that holds them (``log.ft``); absent: the file itself.
    columns : the names of a matrix's columns.
    """

    variable: Name | None = None
    columns: Annotated[list[Name] | None, Field(min_length=1)] = None


def _write_fuzz_input(path: Path) -> None:
    import numpy as np
    from scipy.io import savemat

    savemat(path, {"t": np.linspace(0.0, 0.6, 60), "Fx": np.arange(-30.5, 29.0)}, oned_as="column")


def _write_fuzz_input_73(path: Path) -> None:
    import h5py
    import numpy as np

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("t", np.linspace(0.0, 0.6, 60)), ("Fx", np.arange(-30.5, 29.0))):
            file.create_dataset(name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")


class MatReader(ParsedReader):
    """Reads MAT files in batches of rows."""

    name = "mat"
    endings = (".mat",)
    first_bytes = b"MATLAB "
    options = MatOptions
    holds_tables = True
    fuzz_inputs = (
        FuzzInput(".mat", _write_fuzz_input, ("t", "Fx")),
        FuzzInput(".mat", _write_fuzz_input_73, ("t", "Fx")),
    )


READER = MatReader()
