"""What looks at the robot stands on the ground: a base that gives and a target that wanders show in the logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.simulation.scene import robot_with_values
from stiffcal.simulation.simulate import simulate_campaign
from tests.laboratory.simulation_folders import FRAMES, MODEL, POSES, SETTINGS, TABLE, write_folder
from tests.simulation.test_simulate import rows_of

GIVES = """
[[effects]]
type = "base-compliance"
[effects.parameters]
"base-compliance.setup.rx" = { value = 2e-7 }
"base-compliance.setup.ry" = { value = 1e-7 }
"base-compliance.setup.rz" = { value = 0 }
"base-compliance.setup.tx" = { value = 0 }
"base-compliance.setup.ty" = { value = 0 }
"base-compliance.setup.tz" = { value = 0 }
"""
WANDERS = """
[[effects]]
type = "thermal-drift"
[effects.parameters]
"thermal-drift.setup.x" = { value = 3e-6 }
"thermal-drift.setup.y" = { value = 0 }
"thermal-drift.setup.z" = { value = -4e-6 }
"thermal-drift.setup.rx" = { value = 0 }
"thermal-drift.setup.ry" = { value = 0 }
"thermal-drift.setup.rz" = { value = 0 }
"""


def seen(folder: Path, hidden: str = "") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times, s, and positions (n, 3) that the tracker logs without any error, m."""
    campaign, settings = write_folder(folder / "source", FRAMES + TABLE, SETTINGS + POSES, MODEL + hidden)
    simulate_campaign(campaign, settings, folder / "out")
    rows = rows_of(folder / "out", "table")
    first = [number for number, run in enumerate(rows.run) if run == rows.run[0]]
    return rows.time[first], rows.signals["position.target"].T[first]


def test_a_target_that_wanders(tmp_path: Path) -> None:
    time, still = seen(tmp_path / "still")
    _, wandering = seen(tmp_path / "wandering", WANDERS)
    away = np.linalg.norm(wandering - still, axis=1)
    np.testing.assert_allclose(away, 5e-6 * (time - time[0]), atol=3e-8)
    assert away.max() > 2e-4


def test_a_base_that_gives(tmp_path: Path) -> None:
    """The tracker's readings are the balance on the base that gives, seen from where the tracker was set up."""
    campaign, settings = write_folder(tmp_path / "source", FRAMES + TABLE, SETTINGS + POSES, MODEL + GIVES)
    simulate_campaign(campaign, settings, tmp_path / "out")
    rows = rows_of(tmp_path / "out", "table")
    frames = resolve_frames(campaign.manifest, campaign.chain)
    setup = measurement_setup(campaign.manifest, campaign.chain, frames)
    angles = campaign.chain.model_angles(rows.signals["joints"].T)
    balance = solve_balance(robot_with_values(campaign), angles, rows.signals["wrench"].T, setup)
    tracker = frames["tracker"].transform
    expected = (balance.target_position[:, 0] - tracker[:3, 3]) @ tracker[:3, :3]
    np.testing.assert_allclose(rows.signals["position.target"].T, expected, atol=2e-8)
    # the same tracker on the base, which sags by a tenth of a milliradian, would miss it by ten thousand times that
    assert np.abs(balance.unloaded_position - balance.target_position).max() > 3e-4
