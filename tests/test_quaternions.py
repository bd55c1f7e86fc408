"""Unit quaternions against SciPy's, which is another code."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiffcal.quaternions import (
    conjugate,
    quaternion_from_rotation,
    quaternion_product,
    rotation_from_quaternion,
    vector_from_quaternion,
)

TURNS = Rotation.random(200, random_state=7)
# half turns about the axes and next to them, where three of the four forms lose all digits
HALF = Rotation.from_rotvec(np.pi * np.concatenate([np.eye(3), np.eye(3) + 1e-9 * np.ones((3, 3))])[:, ::-1])


def scalar_first(rotations: Rotation) -> np.ndarray:
    values = rotations.as_quat()[:, [3, 0, 1, 2]]
    return np.where(values[:, :1] < 0.0, -values, values)


def test_matrices_and_quaternions_are_those_of_scipy() -> None:
    np.testing.assert_allclose(quaternion_from_rotation(TURNS.as_matrix()), scalar_first(TURNS), atol=1e-14)
    np.testing.assert_allclose(rotation_from_quaternion(3.0 * scalar_first(TURNS)), TURNS.as_matrix(), atol=1e-14)


def test_half_turns_come_back() -> None:
    back = rotation_from_quaternion(quaternion_from_rotation(HALF.as_matrix()))
    np.testing.assert_allclose(back, HALF.as_matrix(), atol=1e-14)


def test_products_and_inverses_are_those_of_scipy() -> None:
    first, second = scalar_first(TURNS[:100]), scalar_first(TURNS[100:])
    product = rotation_from_quaternion(quaternion_product(first, second))
    np.testing.assert_allclose(product, (TURNS[:100] * TURNS[100:]).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(rotation_from_quaternion(conjugate(first)), TURNS[:100].inv().as_matrix(), atol=1e-14)


def test_vectors_are_those_of_scipy_down_to_nanoradians() -> None:
    np.testing.assert_allclose(vector_from_quaternion(scalar_first(TURNS)), TURNS.as_rotvec(), atol=1e-13)
    small = np.array([[3e-9, -2e-9, 1e-9]])
    turned = vector_from_quaternion(scalar_first(Rotation.from_rotvec(small)))
    np.testing.assert_allclose(turned, small, rtol=1e-9)


@pytest.mark.filterwarnings("error")
def test_what_was_not_measured_stays_unknown() -> None:
    rotation = TURNS.as_matrix()[:3].copy()
    rotation[1] = np.nan
    quaternion = quaternion_from_rotation(rotation)
    assert np.isnan(quaternion).all(axis=1).tolist() == [False, True, False]
    assert np.isnan(rotation_from_quaternion(quaternion)).all(axis=(1, 2)).tolist() == [False, True, False]
