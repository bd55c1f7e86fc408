"""A drill that its hole holds: the side force is the guide's, and less where the controller corrects (003, Fig. 10)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.simulation.played import controller, side_constraint
from stiffcal.simulation.played.places import Places
from stiffcal.simulation.played.side_constraint import (
    SETTLED,
    SETTLED_M,
    SideConstraintError,
    balance_with_side_constraint,
)
from stiffcal.simulation.settings import Loads
from stiffcal.simulation.simulate import simulate_runs
from tests.laboratory.simulation_folders import FRAMES, MODEL, SETTINGS, TABLE, write_folder
from tests.simulation.test_controller import POSES, SAME, TWICE

STIFFNESS = 5e4
DRILL = "directions = [[0.3, 0.2, -1.0]]\nboth_ways = false\nguide_N_per_m = {}\n"
FRICTION = """
[[effects]]
type = "friction-hysteresis"
joints = [2, 3]
[effects.parameters]
"friction-hysteresis.j2.c" = { value = 1e-6 }
"friction-hysteresis.j2.slip" = { value = 60.0 }
"friction-hysteresis.j3.c" = { value = 1e-6 }
"friction-hysteresis.j3.slip" = { value = 40.0 }
"""


def sides_of(folder: Path, stiffness: float, model: str = MODEL) -> list[float]:
    """Play a run without and one with the controller; return the largest side force of each, N."""
    manifest = FRAMES + TABLE + TWICE.format(off="", on="")
    once = SETTINGS.replace("[0.5, 1.0]", "[1.0]") + "ramp_points = 0\n"
    campaign, settings = write_folder(folder, manifest, once + SAME + DRILL.format(stiffness) + POSES, model)
    _, recording = simulate_runs(campaign, settings, 1)
    off, on = recording.true_run
    sides = []
    for true_run in (off, on):
        assert true_run.wrench is not None
        program = true_run.planned.program.wrench_at(true_run.node)
        side = true_run.wrench[:, :3] - program[:, :3]
        thrust = program[int(np.argmax(np.abs(program[:, 2]))), :3]
        along = thrust / np.linalg.norm(thrust)
        assert np.abs(side @ along).max() < 1e-9
        sides.append(float(np.linalg.norm(side, axis=1).max()))
        if true_run is off:
            enough = max(SETTLED * float(np.linalg.norm(thrust)), SETTLED_M * stiffness)
            moved = true_run.position["load_point"] - true_run.position["load_point"][0]
            across = moved - np.outer(moved @ along, along)
            assert np.allclose(side, -stiffness * across, atol=2.0 * enough)
            assert np.allclose(true_run.wrench_at(true_run.node), true_run.wrench)
    return sides


def test_the_side_force_is_that_of_the_guide(tmp_path: Path) -> None:
    sides = sides_of(tmp_path, STIFFNESS)
    assert sides[0] > 8.0
    assert sides[1] < 0.1 * sides[0]


@pytest.mark.parametrize("stiffness", [1e3, 1e6, 1e8])
def test_soft_and_hard_guides_settle(tmp_path: Path, stiffness: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stiffcal.simulation.simulate.compensated", lambda robot, true_run, *_: true_run)
    sides = sides_of(tmp_path, stiffness)
    assert sides[0] == pytest.approx(sides[1])


def test_a_robot_with_friction_settles_too(tmp_path: Path) -> None:
    sides_of(tmp_path, STIFFNESS, MODEL + FRICTION)


COMPLIANCE = np.array([[2e-5, 1e-6, 3e-6], [1e-6, 1e-5, 2e-6], [3e-6, 2e-6, 1.5e-5]])


def springs(wrench: NDArray[np.float64], noise: float = 0.0) -> Places:
    """Return where a point on springs rests; its first state is off by rounding, as sums in another order make it."""
    displacement = np.zeros((len(wrench), 1, 6))
    displacement[:, 0, :3] = wrench[:, :3] @ COMPLIANCE
    displacement[0, 0, 0] += noise
    position = np.array([1.2, 0.3, 0.9]) + displacement[:, :, :3]
    return Places(position, np.broadcast_to(np.eye(3), (len(wrench), 1, 3, 3)), displacement)


@pytest.mark.parametrize("rounding", [0.0, 1e-30, 1e-18])
def test_loads_that_are_rounding_do_not_count(rounding: float) -> None:
    """Zero times a turned axis is 1e-17 N on one processor and nothing on another: the answer is the same."""
    wrench = np.zeros((3, 6))
    wrench[:, 2] = [rounding, -150.0, -300.0]
    places, acting = balance_with_side_constraint(
        wrench, np.full(3, STIFFNESS), [3], 0, lambda load: springs(load, 1e-16)
    )
    across = np.diag([1.0, 1.0, 0.0])
    side = np.linalg.solve(
        np.eye(3) + STIFFNESS * across @ COMPLIANCE, -STIFFNESS * across @ COMPLIANCE @ wrench[2, :3]
    )
    assert np.allclose(acting[2, :3] - wrench[2, :3], side, atol=1e-5)
    assert places.displacement.shape == (3, 1, 6)


def test_a_guide_that_does_not_settle_is_an_error_of_its_run(monkeypatch: pytest.MonkeyPatch) -> None:
    wrench = np.zeros((4, 6))
    wrench[:, 2] = [0.0, -300.0, 0.0, -300.0]
    restless = iter(range(1000))

    def jumping(load: NDArray[np.float64]) -> Places:
        places = springs(load)
        places.position[3, 0, 0] += 1e-3 * (-1) ** next(restless)
        return places

    with pytest.raises(SideConstraintError, match="does not converge") as caught:
        balance_with_side_constraint(wrench, np.full(4, STIFFNESS), [2, 2], 0, jumping)
    assert caught.value.run == 1


def test_what_does_not_settle_names_the_run_and_the_guide(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(side_constraint, "MOST_STEPS", 2)
    with pytest.raises(InputError, match=r'simulate.toml: runs "off": loads.guide_N_per_m: .* does not converge'):
        sides_of(tmp_path, STIFFNESS)


def test_a_controller_that_does_not_settle_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(controller, "_MOST_ROUNDS", 1)
    with pytest.raises(InputError, match=r"simulate.toml: loads.guide_N_per_m: correction and side force"):
        sides_of(tmp_path, 1e6)


def test_without_a_guide_the_program_is_all_that_acts() -> None:
    assert Loads().guide_N_per_m == 0.0
