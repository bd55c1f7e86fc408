"""Turns between frames against rotation vectors that are known."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.mechanics.kinematics import SMALL_SINE, turn_between
from stiffcal.mechanics.rotations import rotation_from_vector


@pytest.mark.parametrize("size", [1e-7, 1e-3, 0.9 * SMALL_SINE, 0.3, 3.0])
def test_the_turn_between_two_frames_is_the_rotation_vector(size: float) -> None:
    """By series and by the matrix logarithm, to rounding of the frames' elements."""
    rng = np.random.default_rng(7)
    vectors, before = rng.normal(size=(20, 3)), rotation_from_vector(rng.normal(size=(20, 3)))
    vectors *= size / np.linalg.norm(vectors, axis=1, keepdims=True)
    after = rotation_from_vector(vectors) @ before
    found = turn_between(np.moveaxis(after, 0, -1).copy(), np.moveaxis(before, 0, -1).copy())
    np.testing.assert_allclose(found.T, vectors, rtol=0.0, atol=1e-14)
