"""The JSON Schema of simulate.toml, made from its types: ``python -m stiffcal.simulation.schema schemas/``."""

from __future__ import annotations

import sys
from pathlib import Path

from stiffcal.campaign.schemas import schema_text
from stiffcal.simulation.settings import settings_type

FILE = "simulate.schema.json"


def simulate_schema_text() -> str:
    """Return the JSON Schema of simulate.toml as it stands in `schemas/`.

    Examples
    --------
    >>> '"const": "stiffcal/simulate/1"' in simulate_schema_text()
    True
    """
    return schema_text(settings_type())


if __name__ == "__main__":
    (Path(sys.argv[1]) / FILE).write_text(simulate_schema_text(), encoding="utf-8", newline="\n")
