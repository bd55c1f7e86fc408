"""KUKA RobotSensorInterface: the XML documents that controller and computer exchange, one after the other in a file.

No options. Each document (``<Rob>`` of the controller, ``<Sen>`` of the computer) is a row. A column is an attribute by
its path, ``AIPos.A1``, or the text of an element: ``IPOC``, the controller's clock in ms. XML that declares a document
type or entities is refused.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.readers import FuzzInput, Options, ParsedReader


class RsiOptions(TomlTable):
    """Nothing to say yet: each document names its values itself."""


def _write_fuzz_input(path: Path) -> None:
    rows = (
        f'<Rob TYPE="KUKA"><AIPos A1="{0.1 * k - 3.05:.2f}" A2="-90.0"/><State>run{k // 20}</State>'
        f"<IPOC>{4 * k}</IPOC></Rob>\n"
        for k in range(60)
    )
    path.write_text("".join(rows), encoding="utf-8")


class RsiReader(ParsedReader):
    """Reads documents in batches."""

    name = "rsi"
    endings = (".xml",)
    first_bytes = b"<Rob "
    options = RsiOptions
    fuzz_inputs = (FuzzInput(".xml", _write_fuzz_input, ("IPOC", "AIPos.A1"), ("State",)),)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``document n``."""
        return f"document {row}"


READER = RsiReader()
