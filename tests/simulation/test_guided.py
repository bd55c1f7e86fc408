"""A drill that its hole holds: the side force is the guide's, and less where the controller corrects (003, Fig. 10)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stiffcal.simulation.settings import Loads
from stiffcal.simulation.simulate import play_campaign
from tests.simulation.folders import FRAMES, SETTINGS, TABLE, write_folder
from tests.simulation.test_controller import POSES, SAME, TWICE

STIFFNESS = 5e4
DRILL = f"directions = [[0.3, 0.2, -1.0]]\nboth_ways = false\nguide_N_per_m = {STIFFNESS}\n"


def test_the_side_force_is_that_of_the_guide(tmp_path: Path) -> None:
    manifest = FRAMES + TABLE + TWICE.format(off="", on="")
    once = SETTINGS.replace("[0.5, 1.0]", "[1.0]") + "ramp_points = 0\n"
    campaign, settings = write_folder(tmp_path, manifest, once + SAME + DRILL + POSES)
    _, stage = play_campaign(campaign, settings, 1)
    off, on = stage.played
    sides = []
    for played in (off, on):
        assert played.wrench is not None
        program = played.act.program.wrench_at(played.node)
        side = played.wrench[:, :3] - program[:, :3]
        thrust = program[int(np.argmax(np.abs(program[:, 2]))), :3]
        along = thrust / np.linalg.norm(thrust)
        assert np.abs(side @ along).max() < 1e-9
        sides.append(float(np.linalg.norm(side, axis=1).max()))
        if played is off:
            moved = played.position["load_point"] - played.position["load_point"][0]
            across = moved - np.outer(moved @ along, along)
            assert np.allclose(side, -STIFFNESS * across, atol=1e-3 * sides[0])
            assert np.allclose(played.wrench_at(played.node), played.wrench)
    assert sides[0] > 8.0
    assert sides[1] < 0.1 * sides[0]


def test_without_a_guide_the_program_is_all_that_acts() -> None:
    assert Loads().guide_N_per_m == 0.0
