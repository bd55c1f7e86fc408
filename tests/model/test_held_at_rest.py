"""The held frame of a clamped robot that its weight has bent."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import HELD
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.balance.deformed_chain import deformed_chain
from stiffcal.model.balance.equilibrium import displacement_between
from stiffcal.model.balance.held_at_rest import held_at_rest, second_order_turn
from stiffcal.model.held_frame import HeldFrame, held_frame
from tests.laboratory.clamped_bench import clamped_bench
from tests.laboratory.robots import six_axes, six_axis_joints

CHAIN = six_axes()
STATES = clamped_bench(CHAIN, six_axis_joints(np.random.default_rng(4), 2), (2, 6), np.diag([1e-9] * 6))
TARGET = STATES.setup.targets[STATES.setup.target_names.index(HELD)]
ANGLES = np.stack([CHAIN.model_angles(STATES.joints[STATES.run == run].mean(axis=0)[None])[0] for run in STATES.run]).T
# shifts of a millimetre, turns of ten milliradians: a heavy, soft robot
SMALL = np.repeat(
    np.random.default_rng(5).normal(size=(14, 6, 1)) * np.array([1e-3] * 3 + [1e-2] * 3)[:, None], len(STATES), axis=2
)


def at_rest(small: Floats | None) -> HeldFrame:
    held = held_frame(CHAIN, STATES)
    assert held is not None
    return held_at_rest(held, CHAIN, ANGLES, small, STATES.run, TARGET)


def test_the_jacobian_is_that_of_the_bent_chain() -> None:
    """Against central differences of where the bent chain holds the frame."""
    held, step = at_rest(SMALL), 1e-5
    for joint in range(6):
        ends = []
        for sign in (1.0, -1.0):
            turned = ANGLES.copy()
            turned[joint] += sign * step
            ends.append(deformed_chain(CHAIN, turned, SMALL).bodies[TARGET.body].moved(TARGET.transform))
        shift = (ends[0].position - ends[1].position) / (2.0 * step)
        assert held.jacobian[:3, joint] == pytest.approx(shift, abs=1e-7)
        turn = np.einsum("ijn,kjn->nik", ends[0].rotation, ends[1].rotation)
        vector = np.array([vector_from_rotation(matrix) for matrix in turn]).T / (2.0 * step)
        assert held.jacobian[3:, joint] == pytest.approx(vector, abs=1e-6)


def test_turning_the_drives_by_the_inverse_undoes_the_motion() -> None:
    held = at_rest(SMALL)
    back = np.einsum("jin,ikn->njk", held.inverse, held.jacobian)
    assert back == pytest.approx(np.broadcast_to(np.eye(6), back.shape), abs=1e-9)


def test_without_weight_it_is_the_undeformed_robots() -> None:
    plain, held = held_frame(CHAIN, STATES), at_rest(None)
    assert plain is not None
    assert held.jacobian == pytest.approx(plain.jacobian, abs=1e-9)
    assert held.inverse == pytest.approx(plain.inverse, abs=1e-7)


@pytest.mark.parametrize("joint", range(6))
def test_a_drive_turns_back_along_its_arc(joint: int) -> None:
    """Of an arc of 5 mrad the straight way differs by 12 µrad, the arc's second order by its third."""
    held = at_rest(SMALL)
    turned = ANGLES.copy()
    turned[joint] += 5e-3
    ends = (
        deformed_chain(CHAIN, angles, SMALL).bodies[TARGET.body].moved(TARGET.transform) for angles in (turned, ANGLES)
    )
    displacement = displacement_between(*ends)
    arc = displacement - second_order_turn(held, CHAIN, ANGLES, SMALL, TARGET, displacement)
    back = np.einsum("jin,in->jn", held.inverse, arc)
    assert back == pytest.approx(turned - ANGLES, abs=5e-7)
