"""HDF5 logs in the three layouts that are common.

Options of the manifest (``hdf5 = {…}``), all optional:

group : the group that holds the columns; absent: the top, or the one group that leads to datasets.
dataset : a dataset in it that holds all columns; absent: the only one with two dimensions or with fields, if there is
    no dataset per column.

Layouts: one dataset of one dimension per column; one dataset of two dimensions whose attribute ``columns`` (or
``column_names``, ``names``, ``fields``, ``labels``) names its columns; one dataset of records with named fields. Units
are taken from an attribute ``unit`` or ``units``.

A writer that died leaves parts of a dataset unwritten, which HDF5 reads as zeros: such a dataset is refused.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.parsers.signatures import begins_like_hdf5
from stiffcal.readers import FuzzInput, ParsedReader


class Hdf5Options(TomlTable):
    """Where in an HDF5 file the columns lie.

    Attributes
    ----------
    group : the group that holds them; left out, the top, or the only group below it. dataset : one dataset in it that
        holds all columns; recognised where left out.
    """

    group: Name | None = None
    dataset: Name | None = None


def _write_fuzz_input(path: Path) -> None:
    import h5py
    import numpy as np

    with h5py.File(path, "w") as file:
        for name, values in (("t", np.linspace(0.0, 0.6, 60)), ("Fx", np.arange(-30.5, 29.0))):
            file.create_dataset(name, data=values)
        file.create_dataset("run", data=[f"pose{k // 20}" for k in range(60)])


class Hdf5Reader(ParsedReader):
    """Reads HDF5 files in batches of rows."""

    name = "hdf5"
    endings = (".h5", ".hdf5", ".hdf")
    options = Hdf5Options
    holds_tables = True
    fuzz_inputs = (FuzzInput(".h5", _write_fuzz_input, ("t", "Fx"), ("run",)),)

    def recognises(self, path: Path) -> bool:
        """Return True for a file that begins like HDF5, or is named so."""
        return path.suffix.lower() in (*self.endings, ".he5") or begins_like_hdf5(path)


READER = Hdf5Reader()
