"""A campaign folder made on the spot: four poses, full load cycles, full pose, known stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.mechanics.rotations import rotation_from_vector, vector_from_rotation
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.campaign_effects import placed_robot
from tests.laboratory.robots import SIX_AXES

STIFFNESS = (7.3e5, 4.9e5, 4.3e5, 6.0e4, 5.7e4, 1.7e4)  # N·m/rad
NOISE_M = 10e-6
POSES_DEG = (
    (-30.0, -70.0, 20.0, 15.0, 40.0, 10.0),
    (10.0, -95.0, 35.0, -60.0, 55.0, 80.0),
    (35.0, -60.0, -10.0, 70.0, -45.0, -50.0),
    (-5.0, -80.0, 5.0, -20.0, 75.0, 120.0),
)
DIRECTIONS = ((1.0, 0.1, 0.0), (-0.1, 1.0, 0.05), (0.0, 0.1, 1.0))
LEVELS = (0.0, 150.0, 300.0, 150.0, 0.0)

CAMPAIGN = """
schema = "stiffcal/campaign/1"
name = "small"
robot = "robot.toml"

[frames.target]
parent = "flange"
xyz_m = [0.06, -0.04, 0.1]
[frames.load_point]
parent = "flange"
xyz_m = [0.02, 0.0, 0.18]

[sources.table]
file = "raw/states.csv"
sampling = "states"
run = { column = "run" }
joints = { position = "A1..A6", units = { position = "deg" } }
wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, axes = "base", point = "load_point" }
[sources.table.pose]
frame = "base"
body = "target"
position = ["X", "Y", "Z"]
rotvec = ["rx", "ry", "rz"]
units = { position = "mm", rotation = "rad" }
"""

MODEL = """# the drives, and nothing else
schema = "stiffcal/model/1"

[[effects]]
type = "joint-compliance"   # one spring each
joints = [1, 2, 3, 4, 5, 6]
"""


def robot_text() -> str:
    """Return robot.toml: a medium six-axis robot."""
    parts = ['schema = "stiffcal/robot/1"\nname = "medium six-axis"\nconvention = "modified-dh"\n']
    for number, (a, alpha, d, theta, mass, com) in enumerate(SIX_AXES, start=1):
        link = f'link = {{ name = "link_A{number}", mass_kg = {mass}, com_m = [{com[0]}, {com[1]}, {com[2]}] }}'
        numbers = f"a_m = {a}\nalpha_deg = {alpha}\nd_m = {d}\ntheta_deg = {theta}"
        parts.append(f'[[joints]]\nname = "A{number}"\n{numbers}\n{link}\n')
    return "\n".join(parts) + "\n[flange]\nxyz_m = [0.0, 0.0, 0.14]\n"


def write_small_campaign(
    folder: Path, seed: int = 1, poses: int = 4, hidden: str = "", stiffness: Sequence[float] = STIFFNESS,
    set_up: str = CAMPAIGN, tracker_turn: Sequence[float] = (0.0, 0.0, 0.0),
) -> Path:  # fmt: skip
    """Write the campaign's files and its measured table; return the folder.

    ``hidden`` is what the real robot has beyond model.toml: entries of a model file, every parameter with a value.
    ``set_up`` is the manifest as it is in truth, and ``tracker_turn`` (rad) how the tracker is turned; the manifest
    that is written knows of neither.
    """
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(set_up, encoding="utf-8")
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    (folder / "model.toml").write_text(MODEL + hidden, encoding="utf-8")
    campaign = load_campaign(folder, check_files=False)
    chain = campaign.chain
    values = {f"joint-compliance.j{k + 1}.c": 1.0 / size for k, size in enumerate(stiffness)}
    robot = placed_robot(campaign).with_values(values)
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    tracker_from_base = rotation_from_vector(np.array(tracker_turn))
    rng = np.random.default_rng(seed)
    lines = ["run,A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,X,Y,Z,rx,ry,rz"]
    for number, pose in enumerate(POSES_DEG[:poses], start=1):
        loads = [
            level * np.array(direction)
            for direction in DIRECTIONS
            for cycle in range(2)
            for level in (LEVELS if direction == DIRECTIONS[0] and cycle == 0 else LEVELS[1:])
        ]
        wrench = np.zeros((len(loads), 6))
        wrench[:, :3] = loads
        joints = np.repeat(np.radians([pose]), len(loads), axis=0)
        balance = solve_balance(robot, chain.model_angles(joints), wrench, setup)
        position = balance.target_position[:, 0] @ tracker_from_base.T
        position = 1e3 * (position + NOISE_M * rng.standard_normal((len(loads), 3)))
        turned = vector_from_rotation(tracker_from_base @ balance.target_rotation[:, 0])
        turned = turned + 2e-5 * rng.standard_normal((len(loads), 3))
        for k in range(len(loads)):
            cells = [*pose, *wrench[k, :3], *position[k], *turned[k]]
            lines.append(f"pose{number}," + ",".join(f"{cell:.9g}" for cell in cells))
    (folder / "raw" / "states.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder
