"""Reading a log as a whole, and the one line that refuses it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.readers import Reader, WantedColumns


def read_columns(
    reader: Reader, path: Path, options: Mapping[str, Any], wanted: WantedColumns, shown: str = ""
) -> dict[str, Any]:
    """Return the wanted columns of a log as arrays; the batches' rows are numbered on."""
    found: dict[str, list[Any]] = {name: [] for name in wanted.names}
    for batch in reader.read_batches(path, options, wanted, *([shown] if shown else [])):
        assert batch.first_row == len(found[wanted.names[0]]) + 1
        for name in wanted.names:
            found[name].extend(batch.numbers.get(name, batch.texts.get(name, ())))
    return {name: np.array(values) for name, values in found.items()}


def refusal(read: Callable[[], object], shown: str = "") -> str:
    """Return the one line with which an input is refused; it begins with the file as ``shown``."""
    with pytest.raises(InputError) as caught:
        read()
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{shown}: " if shown else "")
    return line
