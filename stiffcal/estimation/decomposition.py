"""Singular values of small matrices, whatever the machine's kernels make of them."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats


def thin_svd(matrix: Floats) -> tuple[Floats, Floats, Floats]:
    """Return U (…, r, k), the singular values (…, k) and Vᵀ (…, k, c) of matrices (…, r, c), k the smaller of both.

    The fast algorithm fails for some finite matrices; of the same matrix turned round it does not.
    """
    try:
        basis, values, axes = np.linalg.svd(matrix, full_matrices=False)
    except np.linalg.LinAlgError:
        turned, values, other = np.linalg.svd(np.swapaxes(matrix, -1, -2), full_matrices=False)
        return np.swapaxes(other, -1, -2), np.asarray(values), np.swapaxes(turned, -1, -2)
    return np.asarray(basis), np.asarray(values), np.asarray(axes)
