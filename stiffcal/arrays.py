"""Arrays by what they hold; shapes, units and frames stand where an array is used."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Booleans: TypeAlias = NDArray[np.bool_]

_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def evenly(numbers: Integers, count: int) -> Integers:
    """Return so many of some numbers, evenly over them yet with no period that loads could have."""
    if numbers.size <= count:
        return numbers
    k = np.arange(count)
    return np.asarray(numbers[((k + k * _GOLDEN % 1.0) * numbers.size / count).astype(np.int64)])
