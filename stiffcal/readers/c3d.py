"""C3D, as systems of motion capture write it (Vicon, Qualisys, OptiTrack). Needs the extra ``c3d`` (ezc3d).

Options of the manifest (``c3d = {…}``), all optional:

data : "points" (the markers, when absent) or "analog" (force plates and other channels, at a rate of their own).

Columns of points are ``probe X``, ``probe Y``, ``probe Z`` by the markers' labels, in the file's unit; of analog data
the channels' labels. ``time`` is in seconds from the first frame, by the rate in the file. A marker out of sight (a
residual below zero) is an empty cell. The format holds seven digits of a number.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.readers import FuzzInput, Options, ParsedReader


class C3dOptions(TomlTable):
    """Which data of a C3D file are read.

    Attributes
    ----------
    data : "points", the markers, or "analog", the channels.
    """

    data: Literal["points", "analog"] = "points"


def _write_fuzz_input(path: Path) -> None:
    import ezc3d
    import numpy as np

    log = ezc3d.c3d()
    points = np.ones((4, 1, 60))
    points[0, 0] = np.arange(-30.5, 29.0)
    for name, value in (("RATE", [100.0]), ("LABELS", ("probe",)), ("UNITS", ("mm",))):
        log["parameters"]["POINT"][name]["value"] = value
    log["data"]["points"] = points
    log.write(str(path))


class C3dReader(ParsedReader):
    """Reads markers or channels in batches of frames."""

    name = "c3d"
    endings = (".c3d",)
    options = C3dOptions
    holds_tables = True
    fuzz_inputs = (FuzzInput(".c3d", _write_fuzz_input, ("time", "probe X")),)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``frame n``, counted from 1."""
        return f"frame {row}"


READER = C3dReader()
