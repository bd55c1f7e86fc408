"""Arrays of NumPy: ``.npz`` (`numpy.savez`) and ``.npy`` (`numpy.save`). Nothing that is pickled is loaded.

Options of the manifest (``npz = {…}``), all optional:

array : of an ``.npz`` the array that holds all columns; absent: every array is a column, or the only one holds them.
columns : the names of a matrix's columns, in order; absent: column1, column2, …

Rows are the first axis. An array of one dimension is a column; one of two gives columns named by its own name and their
number from 0, ``q[0]``, or by `columns`; one of records its fields. Single values are left out. Arrays of Python
objects (``dtype=object``) are programs, and refused.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.readers import FuzzInput, ParsedReader


class NpzOptions(TomlTable):
    """Where in a file of NumPy the columns are.

    Attributes
    ----------
    array : the one that holds all columns; recognised where left out. columns : the names of a matrix's columns.
    """

    array: Name | None = None
    columns: Annotated[list[Name] | None, Field(min_length=1)] = None


def _write_npz(path: Path) -> None:
    import numpy as np

    runs = np.array([f"pose{k // 20}" for k in range(60)])
    with path.open("wb") as file:
        np.savez(file, t=np.linspace(0.0, 0.6, 60), Fx=np.arange(-30.5, 29.0), run=runs)


def _write_npy(path: Path) -> None:
    import numpy as np

    records = np.zeros(60, dtype=[("t", "f8"), ("Fx", "f4")])
    records["Fx"] = np.arange(-30.5, 29.0)
    with path.open("wb") as file:
        np.save(file, records)


class NpzReader(ParsedReader):
    """Reads arrays in batches of rows."""

    name = "npz"
    endings = (".npz", ".npy")
    first_bytes = b"\x93NUMPY"
    options = NpzOptions
    fuzz_inputs = (
        FuzzInput(".npz", _write_npz, ("t", "Fx"), ("run",)),
        FuzzInput(".npy", _write_npy, ("t", "Fx")),
    )


READER = NpzReader()
