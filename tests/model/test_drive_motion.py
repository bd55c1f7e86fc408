"""Free motion of a drive, and what an effect answers of it by default."""

from __future__ import annotations

import numpy as np

from stiffcal.effects_api import DriveMotion, Floats, Motion, ParameterRole, ParameterSpec, Values
from tests.laboratory.effect_bench import robot_chain


class _Drag(Motion):
    """Torque in proportion to a power of the speed, written with `torque_columns` alone."""

    name = "drag"
    place_kind = "joints"
    parameters = (
        ParameterSpec("factor", "N·m", "torque at 1 rad/s", 0.0, 1e3, 1.0, "example"),
        ParameterSpec("power", "1", "power of the speed", 0.5, 4.0, 2.0, "example", ParameterRole.NONLINEAR),
    )

    def torque_columns(self, velocity: Floats, shape: Values) -> dict[str, Floats]:
        return {"factor": np.sign(velocity) * np.abs(velocity) ** shape["power"]}


def test_a_law_of_velocity_needs_torque_columns_only() -> None:
    chain, drag = robot_chain(), _Drag()
    place = drag.places(chain)[1]
    motion = DriveMotion.at_velocity(np.array([-2.0, 0.5]))
    columns = drag.motion_columns(place, chain, motion, {"power": 3.0})
    np.testing.assert_allclose(columns["factor"], [-8.0, 0.125])
    grid = drag.motion_grid(place, chain, motion)["power"]
    assert grid.min() == 0.5
    assert grid.max() == 4.0
    assert drag.lacking_motion(chain, motion) is None


def test_some_samples_of_a_motion() -> None:
    velocity = np.arange(5.0)
    motion = DriveMotion(*(velocity + 10.0 * k for k in range(6)))
    some = motion.block(np.array([True, False, False, True, False]))
    assert len(some) == 2
    np.testing.assert_array_equal(some.travel, [50.0, 53.0])
    np.testing.assert_array_equal(some.velocity, [0.0, 3.0])
