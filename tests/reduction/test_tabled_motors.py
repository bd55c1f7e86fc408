"""Tables of states with what the motors' sensors read: angles and torques come at the joints' side."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np

from stiffcal.commands.ingest import ingest_campaign, stored_states

PRACTICE = Path(__file__).resolve().parents[2] / "campaigns" / "absolute" / "02"
RATIO = -120.5


def test_a_table_of_motor_angles_and_torques_is_that_of_the_joints(tmp_path: Path) -> None:
    folder, plain = tmp_path / "motors", tmp_path / "joints"
    for copy in (folder, plain):
        shutil.copytree(PRACTICE, copy)
    with (plain / "raw" / "poses.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    first = header.index("A1")
    for row in rows:
        angles = [float(cell) for cell in row[first : first + 6]]
        row[first : first + 6] = [repr(RATIO * angle) for angle in angles]
        row.extend(repr(angle / RATIO) for angle in angles)
    header.extend(f"T{k}" for k in range(1, 7))
    text = "\n".join(map(",".join, [header, *rows])) + "\n"
    (folder / "raw" / "poses.csv").write_text(text, encoding="utf-8")
    robot = (folder / "robot.toml").read_text(encoding="utf-8")
    (folder / "robot.toml").write_text(
        robot.replace("limits_deg", f"gear_ratio = {RATIO}\nlimits_deg"), encoding="utf-8"
    )
    manifest = (folder / "campaign.toml").read_text(encoding="utf-8")
    motors = 'position = "A1..A6", motor = true, torque = "T1..T6", torque_gain_sigma = 0.03,'
    (folder / "campaign.toml").write_text(manifest.replace('position = "A1..A6",', motors), encoding="utf-8")
    for copy in (folder, plain):
        ingest_campaign(copy)
    found, expected = stored_states(folder), stored_states(plain)
    np.testing.assert_allclose(found.joints, expected.joints, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.joint_torque, np.rad2deg(expected.joints), rtol=1e-12)
