"""Products of vectors whose components lie along the first axis, without copies of their own."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Real = TypeVar("Real", np.float64, np.float32)


def crossed(a: NDArray[Real], b: NDArray[Real]) -> NDArray[Real]:
    """Return a × b along the first axis, the others broadcast."""
    result: NDArray[Real] = np.empty((3, *np.broadcast(a[0], b[0]).shape), dtype=a.dtype)
    other = np.empty_like(result[0])
    for part, i, j in zip(result, (1, 2, 0), (2, 0, 1), strict=True):
        np.multiply(a[i], b[j], out=part)
        np.multiply(a[j], b[i], out=other)
        part -= other
    return result


def along(a: NDArray[Real], b: NDArray[Real]) -> NDArray[Real]:
    """Return a · b along the first axis, the others broadcast."""
    result: NDArray[Real] = a[0] * b[0]
    other = a[1] * b[1]
    result += other
    np.multiply(a[2], b[2], out=other)
    result += other
    return result
