"""MCAP files outside a bag, read as a bag is, with the same options (``mcap = {…}``). Needs the extra ``ros``."""

from __future__ import annotations

from pathlib import Path

from stiffcal.files import open_regular
from stiffcal.readers.rosbag2 import RosReader
from stiffcal.readers.rosbag2.fuzz_inputs import fuzz_input

MCAP_MAGIC = b"\x89MCAP0\r\n"


class McapReader(RosReader):
    """Reads one topic of an MCAP file in batches of messages."""

    name = "mcap"
    endings = (".mcap",)
    fuzz_inputs = (fuzz_input(".mcap", "MCAP"),)

    def recognises(self, path: Path) -> bool:
        """Return True for a file that begins like MCAP, or is named so."""
        if path.suffix.lower() in self.endings:
            return True
        try:
            with open_regular(path) as file:
                return file.read(len(MCAP_MAGIC)) == MCAP_MAGIC
        except OSError:
            return False


READER = McapReader()
