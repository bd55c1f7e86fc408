"""Motors' torques in a table of absolute places: from the log through the store to the scale of the moments."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.errors import InputError
from stiffcal.identification.derivatives.holding_torques import holding_torques
from stiffcal.identification.derivatives.observation import observe
from stiffcal.mechanics.kinematics import body_poses
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.effect_bench import bare_states
from tests.laboratory.robots import force_sensor_setup

SOURCE = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"
GAIN = 0.02


def with_torques(folder: Path) -> None:
    """Add what the motors hold to the table of places, with scatter, in N·m."""
    shutil.copytree(SOURCE, folder)
    data = up_to_date_states(folder, RunContext())
    held = holding_torques(CompliantRobot(data.campaign.chain, ()), observe(data.states, data.campaign.chain)).T
    logged = held + np.random.default_rng(1).normal(0.0, 2.0, held.shape)
    table = folder / "raw" / "poses.csv"
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    lines = [head + "".join(f",T{k}" for k in range(1, 7))]
    lines += [row + "".join(f",{value:.6f}" for value in own) for row, own in zip(rows, logged, strict=True)]
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")


def state_torques(folder: Path, keys: str) -> None:
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8")
    assert 'position = "A1..A6", units' in text
    manifest.write_text(text.replace('position = "A1..A6", units', f'position = "A1..A6", {keys}, units'), "utf-8")


def test_one_torque_log_fixes_the_scale(tmp_path: Path) -> None:
    folder = tmp_path / "01"
    with_torques(folder)
    state_torques(folder, f'torque = "T1..T6", torque_gain_sigma = {GAIN}')
    states = up_to_date_states(folder, RunContext()).states
    assert states.joint_torque.shape == (80, 6)
    assert states.setup.torque_gain_sigma == GAIN
    edit_model(folder, "add", "link-weight", everywhere=True)
    fit = identify_campaign(folder)
    second = fit.parameter("joint-compliance.j2.c")
    # between one motor's gain and the mean of the three that hold most
    assert GAIN / 2.0 < (second.std or np.inf) / (second.value or np.nan) < GAIN
    assert fit.parameter("link-weight.swing.mx").identifiable


def test_a_gain_without_torques_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "01"
    shutil.copytree(SOURCE, folder)
    state_torques(folder, f"torque_gain_sigma = {GAIN}")
    with pytest.raises(InputError) as caught:
        load_campaign(folder)
    assert "torque_gain_sigma" in str(caught.value)


def test_they_are_the_slope_of_the_potential_energy() -> None:
    """Of a parallelogram, whose third drive holds two joints: ∂V/∂q of the logged angles, by central differences."""
    chain = load_campaign(SOURCE.parents[1] / "irb4400", check_files=False).chain
    rng = np.random.default_rng(4)
    logged = rng.uniform(-0.6, 0.6, (5, 6))
    data = observe(bare_states(list(range(5)), logged, force_sensor_setup(chain)), chain)
    held = holding_torques(CompliantRobot(chain, ()), data)

    def energy(angles: Floats) -> Floats:
        positions, rotations = body_poses(chain, chain.model_angles(angles))
        centres = positions[:, 1:-1] + np.einsum("njab,jb->nja", rotations[:, 1:-1], chain.link_com)
        return np.asarray(-np.einsum("j,nja,a->n", chain.link_mass, centres, chain.gravity))

    step = 1e-5
    for joint in range(6):
        slope = (energy(logged + step * np.eye(6)[joint]) - energy(logged - step * np.eye(6)[joint])) / (2.0 * step)
        np.testing.assert_allclose(held[joint], slope, rtol=1e-6, atol=1e-4)
