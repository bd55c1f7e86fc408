"""MCAP files outside a bag, parsed as a bag is."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from stiffcal.log_columns import Options
from stiffcal.parsers.rosbag2 import LIBRARIES, OpenBag, open_bag, tables

__all__ = ["LIBRARIES", "open_log", "tables"]


def open_log(path: Path, options: Options, display_name: str) -> AbstractContextManager[OpenBag]:
    """Open a topic of a file; the parameters and errors are those of `open_bag`."""
    return open_bag(path, options, display_name, "mcap")
