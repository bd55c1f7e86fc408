"""Arrays for the browser: rounded to a step far below the noise, deflated, as text.

The packed bytes are: four bytes with the length of a JSON text, the text, then the arrays one after the other. Bytes of
equal significance of an array stand together, which deflates better.
"""

from __future__ import annotations

import base64
import json
import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.documents import Document

NOISE_SHARE = 0.02
"""Step of rounding over the noise: errors are at most half of it, 1 % of the noise."""
RELATIVE = 2e-5
"""Step over the largest value where no noise is known to measure it by."""


@dataclass
class Packer:
    """Collects arrays; `packed` joins them to a document that refers to them."""

    _bytes: list[bytes] = field(default_factory=list)
    _position: int = 0

    def add(self, values: Floats, step: float | None = None) -> Document:
        """Return the reference to an array, by which the scripts find it.

        Parameters
        ----------
        values : any shape; what is not finite becomes the lowest integer.
        step : of rounding, in the values' unit; None: `RELATIVE` times the largest value.
        """
        array = np.asarray(values, dtype=np.float64)
        finite = np.isfinite(array)
        largest = float(np.max(np.abs(array[finite]), initial=0.0))
        step = step if step else max(largest * RELATIVE, 1e-15)
        width = 2 if largest / step < 32000 else 4
        if largest / step > 2e9:
            step, width = largest / 2e9, 4
        lowest = -(1 << (8 * width - 1))
        integers = np.full(array.shape, lowest, dtype=np.int64)
        integers[finite] = np.rint(array[finite] / step).astype(np.int64)
        return self._store(integers.astype(f"<i{width}"), {"step": step})

    def add_integers(self, values: Any) -> Document:
        """Return the reference to an array of integers below 2³¹ in magnitude."""
        return self._store(np.asarray(values).astype("<i4"), {"step": 1})

    def _store(self, integers: Any, reference: Document) -> Document:
        width = integers.dtype.itemsize
        planes = np.frombuffer(np.ascontiguousarray(integers).tobytes(), dtype=np.uint8).reshape(-1, width).T
        self._bytes.append(np.ascontiguousarray(planes).tobytes())
        reference |= {"at": self._position, "n": int(integers.size), "width": width, "shape": list(integers.shape)}
        self._position += integers.size * width
        return {"$": reference}

    def packed(self, document: Document) -> str:
        """Return the document with its arrays, deflated, in base 64.

        Raises
        ------
        ValueError : a number of the document is not finite.
        """
        text = json.dumps(document, ensure_ascii=True, allow_nan=False, separators=(",", ":"), sort_keys=True).encode()
        whole = len(text).to_bytes(4, "little") + text + b"".join(self._bytes)
        return base64.b64encode(zlib.compress(whole, 6)).decode("ascii")


def unpacked(text: str) -> tuple[Document, dict[int, Floats]]:
    """Return what `Packer.packed` made: the document, and the arrays by the place where they begin (for tests)."""
    whole = zlib.decompress(base64.b64decode(text))
    length = int.from_bytes(whole[:4], "little")
    document = json.loads(whole[4 : 4 + length])
    arrays: dict[int, Floats] = {}

    def visit(value: Any) -> None:
        if isinstance(value, dict):
            if "$" in value:
                entry = value["$"]
                begin, width = 4 + length + entry["at"], entry["width"]
                planes = np.frombuffer(whole[begin : begin + entry["n"] * width], dtype=np.uint8).reshape(width, -1)
                integers = np.frombuffer(np.ascontiguousarray(planes.T).tobytes(), dtype=f"<i{width}")
                lowest = -(1 << (8 * width - 1))
                numbers = np.where(integers == lowest, np.nan, integers * entry["step"])
                if entry["n"] or entry["at"] not in arrays:  # an empty array begins where the next one does
                    arrays[entry["at"]] = numbers.reshape(entry["shape"])
            else:
                for item in value.values():
                    visit(item)
        elif isinstance(value, list):
            for item in value:
                visit(item)

    visit(document)
    return document, arrays
