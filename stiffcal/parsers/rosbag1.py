"""Bags of ROS 1, parsed as those of ROS 2 are."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from stiffcal.log_columns import Options
from stiffcal.parsers.rosbag2 import LIBRARIES, OpenBag, open_ros1_bag
from stiffcal.parsers.rosbag2 import ros1_tables as tables

__all__ = ["LIBRARIES", "open_log", "tables"]


def open_log(path: Path, options: Options, display_name: str) -> AbstractContextManager[OpenBag]:
    """Open a topic of a bag; the parameters and errors are those of `open_ros1_bag`."""
    return open_ros1_bag(path, options, display_name, "rosbag1")
