"""MCAP files outside a bag, read as a bag is, with the same options (``mcap = {…}``). Needs the extra ``ros``."""

from __future__ import annotations

from pathlib import Path

from stiffcal.readers import Reader
from stiffcal.readers.rosbag2 import RosReader
from stiffcal.readers.rosbag2.fuzz_inputs import fuzz_input

MCAP_MAGIC = b"\x89MCAP0\r\n"


class McapReader(RosReader):
    """Reads one topic of an MCAP file in batches of messages."""

    name = "mcap"
    endings = (".mcap",)
    first_bytes = MCAP_MAGIC
    fuzz_inputs = (fuzz_input(".mcap", "MCAP"),)

    def recognises(self, path: Path) -> bool:
        """Return True for a file, not a bag's folder, that begins like MCAP or is named so."""
        return Reader.recognises(self, path)


READER = McapReader()
