"""ROS 1 bags (``.bag``), read without any ROS, with the columns of ROS 2 bags. Needs the extra ``ros`` (rosbags).

Options of the manifest (``rosbag1 = {…}``), all optional:

topic : the topic that is read; may be left out where the bag has only one.
child_frame : of transforms (``tf2_msgs/TFMessage``, ``tf/tfMessage``): the frame whose transforms are the rows.

A recording that was interrupted has no index (``.bag.active``) and is refused; ``rosbag reindex`` makes one.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.readers import Options, ParsedReader
from stiffcal.readers.rosbag2.fuzz_inputs import fuzz_input_ros1


class Ros1Options(TomlTable):
    """Which messages of a ROS 1 bag are read; its columns are fields: ``wrench.force.x``, ``position.A1``.

    Attributes
    ----------
    topic : may be left out where the bag has only one. child_frame : of transforms, the frame that was tracked.
    """

    topic: Name | None = None
    child_frame: Name | None = None


class Ros1Reader(ParsedReader):
    """Reads one topic of a bag in batches of messages."""

    name = "rosbag1"
    endings = (".bag",)
    first_bytes = b"#ROSBAG V2.0\n"
    options = Ros1Options
    holds_tables = True
    fuzz_inputs = (fuzz_input_ros1(),)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``message n``."""
        return f"message {row}"


READER = Ros1Reader()
