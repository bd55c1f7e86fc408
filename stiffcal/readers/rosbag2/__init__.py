"""ROS 2 bags (folders, ``.db3``) and MCAP files, read without any ROS. Needs the extra ``ros`` (rosbags).

Options of the manifest (``rosbag2 = {…}``, ``mcap = {…}``), all optional:

topic : the topic that is read; may be left out where the bag has only one.
child_frame : of ``tf2_msgs/TFMessage``: the frame whose transforms are the rows.
types : where the bag holds no definitions of its messages: the ROS release whose they are, ``ros2_humble`` when absent.

Each message is a row. A column is a field, by its path: ``wrench.force.x``, ``pose.position.z``, ``header.stamp`` (in
seconds), an element of an array ``data[0]``, and where a message names its elements (``sensor_msgs/JointState``) by
that name: ``position.A1``, in whatever order the message lists them. ``time`` is when the message was recorded, in
seconds.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_options import check_options
from stiffcal.parsers.client import ParsedFile
from stiffcal.readers import Options, ParsedReader
from stiffcal.readers.rosbag2.fuzz_inputs import fuzz_input


class RosOptions(TomlTable):
    """Which messages of a ROS 2 bag or MCAP file are read; its columns are fields: ``wrench.force.x``, ``position.A1``.

    Attributes
    ----------
    topic : may be left out where the bag has only one. child_frame : of transforms, the frame that was tracked.
    types : the ROS release (``ros2_humble``) whose messages they are, where the bag does not define them itself.
    """

    topic: Name | None = None
    child_frame: Name | None = None
    types: Name | None = None


class RosReader(ParsedReader):
    """Reads one topic of a bag in batches of messages; `stiffcal.readers.mcap` reads MCAP files in the same way."""

    name = "rosbag2"
    endings = (".db3",)
    options = RosOptions
    holds_tables = True
    fuzz_inputs = (fuzz_input(".db3", "SQLITE3"),)

    def recognises(self, path: Path) -> bool:
        """Return True for a bag's folder, or a file named like one inside."""
        return path.suffix.lower() in self.endings or (path / "metadata.yaml").is_file()

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``message n``."""
        return f"message {row}"

    def _file(self, path: Path, options: Options, display_name: str) -> ParsedFile:
        """Return the bag, which may be a folder."""
        check_options(options, RosOptions, self.name, display_name)
        if not path.exists():
            raise InputError.at(FaultCode.FILE_MISSING, display_name, "", "no such file", "correct the file's name")
        return ParsedFile(self.name, path, options, display_name)


READER = RosReader()
