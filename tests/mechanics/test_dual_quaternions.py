"""Dual quaternions against matrices, at ordinary and at singular orientations."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.dual_quaternions import (
    attached_duals,
    displacement_from_change,
    displacement_map,
    displacement_of_duals,
    dual_chain,
    dual_conjugate,
    dual_from_pose,
    dual_hessian,
    dual_jacobian,
    dual_product,
    pose_error,
    position_of_dual,
)
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.rotations import rotation_from_rpy, rotation_from_vector, transform
from stiffcal.quaternions import rotation_from_quaternion
from tests.laboratory.robots import seven_axes

# Orientations where the angles of some convention are singular: pitch ±90°, wrist stretched, half turns, the identity.
SINGULAR = np.array(
    [[0.3, np.pi / 2, -0.4], [0.3, -np.pi / 2, 1.0], [0, 0, 0], [np.pi, 0, 0], [0, np.pi, 0], [0, 0, np.pi]]
)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def poses(rng: np.random.Generator, n: int = 40) -> tuple[Floats, Floats]:
    rotations = np.concatenate([rotation_from_vector(rng.normal(size=(n, 3)) * 2.0), rotation_from_rpy(SINGULAR)])
    return rng.normal(size=(len(rotations), 3)), rotations


def pose_of(dual: Floats) -> tuple[Floats, Floats]:
    return position_of_dual(dual), rotation_from_quaternion(dual[..., :4])


def homogeneous(position: Floats, rotation: Floats) -> Floats:
    return np.stack([transform(r, p) for p, r in zip(position, rotation, strict=True)])


def test_products_are_those_of_matrices(rng: np.random.Generator) -> None:
    (p, r), (s, t) = poses(rng), poses(rng)
    a, b = dual_from_pose(p, r), dual_from_pose(s, t)
    position, rotation = pose_of(dual_product(a, b))
    assert np.allclose(homogeneous(position, rotation), homogeneous(p, r) @ homogeneous(s, t), atol=1e-13)
    assert np.allclose(dual_product(a, dual_conjugate(a)), np.eye(8)[0], atol=1e-14)


def test_error_is_the_correction(rng: np.random.Generator) -> None:
    (p, r), (s, t) = poses(rng), poses(rng)
    nominal, actual = dual_from_pose(p, r), dual_from_pose(s, t)
    back = dual_product(pose_error(nominal, actual), actual)
    position, rotation = pose_of(back)
    assert np.allclose(position, p, atol=1e-13)
    assert np.allclose(rotation, r, atol=1e-13)
    assert np.all(pose_error(nominal, actual)[:, 0] >= 0.0)


def test_displacements_at_singular_orientations(rng: np.random.Generator) -> None:
    position, rotation = poses(rng)
    moved = rng.normal(size=position.shape) * 1e-3
    turned = rng.normal(size=position.shape) * 1e-3
    after = dual_from_pose(position + moved, rotation_from_vector(turned) @ rotation)
    before = dual_from_pose(position, rotation)
    error = displacement_of_duals(after, before)
    assert np.allclose(error, np.concatenate([moved, turned], axis=1), atol=1e-15, rtol=1e-11)


def test_linear_map_and_its_inverse(rng: np.random.Generator) -> None:
    position, rotation = poses(rng)
    dual = dual_from_pose(position, rotation)
    across = displacement_from_change(dual) @ displacement_map(dual)
    assert np.allclose(across, np.eye(6), atol=1e-14)
    small = rng.normal(size=(len(dual), 6)) * 1e-6
    after = [
        dual_from_pose(position + s * small[:, :3], rotation_from_vector(s * small[:, 3:]) @ rotation) for s in (1, -1)
    ]
    # q and −q are one pose
    after = [np.where(np.sum(one * dual, axis=1, keepdims=True) < 0.0, -one, one) for one in after]
    change = 0.5 * (after[0] - after[1])
    assert np.allclose(change, np.einsum("nij,nj->ni", displacement_map(dual), small), atol=1e-15)


@pytest.mark.parametrize("body", [2, 7, 8])
def test_chain_and_jacobian(rng: np.random.Generator, body: int) -> None:
    chain: Chain = seven_axes()
    angles = rng.uniform(-3.0, 3.0, size=(12, 7))
    angles[:3] = 0.0
    attachment = Attachment(body, transform(rotation_from_vector(rng.normal(size=3)), rng.normal(size=3)))
    frames = dual_chain(chain, angles)
    place = attached_duals(frames, attachment)
    position, rotation = pose_of(place)
    expected = attached_poses(chain, angles, attachment)
    assert np.allclose(position, expected[0], atol=1e-13)
    assert np.allclose(rotation, expected[1], atol=1e-13)
    jacobian = dual_jacobian(frames, attachment)
    assert np.allclose(jacobian, displacement_map(place) @ jacobians(chain, angles, attachment), atol=1e-13)
    assert np.allclose(displacement_from_change(place) @ jacobian, jacobians(chain, angles, attachment), atol=1e-13)


def test_second_derivatives(rng: np.random.Generator) -> None:
    chain = seven_axes()
    angles = rng.uniform(-3.0, 3.0, size=(4, 7))
    attachment = Attachment(6, transform(rotation_from_vector(rng.normal(size=3)), rng.normal(size=3)))
    hessian = dual_hessian(dual_chain(chain, angles), attachment)
    step = 1e-6
    for j in range(7):
        sides = [dual_jacobian(dual_chain(chain, angles + s * step * np.eye(7)[j]), attachment) for s in (1, -1)]
        assert np.allclose((sides[0] - sides[1]) / (2 * step), np.swapaxes(hessian[:, :, j], 1, 2), atol=1e-8)
