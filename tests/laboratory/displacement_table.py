"""A campaign whose table holds one pose, load and displacement a row, played by joint springs."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import stiffcal.propose
from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_robot
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from tests.laboratory.robots import shifted, six_axes, six_axis_joints
from tests.laboratory.small_campaign import MODEL, STIFFNESS, robot_text

TOOL_M = (0.05, 0.0, 0.2)
NOISE_MM = 0.01
ROBOTS = Path(stiffcal.propose.__file__).parent / "robots"
JOINTS, FORCES, DISPLACEMENTS = ("A1", "A2", "A3", "A4", "A5", "A6"), ("Fx", "Fy", "Fz"), ("dx", "dy", "dz")
Columns = dict[str, Floats]

MANIFEST = f"""schema = "stiffcal/campaign/1"
robot = "robot.toml"

[sources.table]
file = "raw/table.csv"
run = {{ each = "row" }}
joints = {{ position = "A1..A6", units = {{ position = "deg" }} }}
wrench = {{ columns = ["Fx", "Fy", "Fz"], units = {{ force = "N" }}, axes = "base", point = "tool" }}
deflection = {{ translation = ["dx", "dy", "dz"], units = {{ translation = "mm" }}, body = "tool", axes = "base" }}

[frames.tool]
parent = "flange"
xyz_m = [{", ".join(map(str, TOOL_M))}]
"""


def displacement_columns(
    rows: int = 24,
    seed: int = 1,
    largest_N: float = 600.0,
    joints: Floats | None = None,
    chain: Chain | None = None,
) -> Columns:
    """Return columns as they are written: degrees, N, mm; a pose, a load and its displacement a row.

    ``joints``: (n, 6) rad, drawn within the robot's range where None. ``chain``: of six joints; None: six_axes.
    """
    rng, chain = np.random.default_rng(seed), chain or six_axes()
    joints = six_axis_joints(rng, rows) if joints is None else joints
    force = rng.uniform(-largest_N, largest_N, (len(joints), 3))
    tool, angles = Attachment(chain.n_joints + 1, shifted(*TOOL_M)), chain.model_angles(joints)
    jacobian = jacobians(chain, angles, tool)[:, :3] @ chain.drive_axes
    torque = np.einsum("nij,ni->nj", jacobian, force)
    displacement = 1e3 * np.einsum("nij,nj->ni", jacobian, torque / np.array(STIFFNESS))
    displacement += NOISE_MM * rng.standard_normal(displacement.shape)
    values = np.concatenate([np.degrees(joints), force, displacement], axis=1)
    return dict(zip((*JOINTS, *FORCES, *DISPLACEMENTS), values.T, strict=True))


def ramps(poses: int, steps: Floats, lag: Floats | None = None) -> Columns:
    """Return columns of rows in which the load of each pose goes through these shares of the largest.

    ``lag``: what displacements are more than these shares of theirs.
    """
    columns, n = displacement_columns(poses), len(steps)
    more = np.zeros(n) if lag is None else lag
    share = {**dict.fromkeys(FORCES, steps), **dict.fromkeys(DISPLACEMENTS, steps + more)}
    return {name: np.repeat(own, n) * np.tile(share.get(name, np.ones(n)), poses) for name, own in columns.items()}


def places_of_tool(columns: Columns) -> Floats:
    """Return (n, 3) where the unloaded robot has the tool in the rows' poses, m."""
    chain = six_axes()
    joints = np.radians(np.stack([columns[name] for name in JOINTS], axis=1))
    place, _ = attached_poses(chain, chain.model_angles(joints), Attachment(chain.n_joints + 1, shifted(*TOOL_M)))
    return np.asarray(place)


def write_table(path: Path, columns: Columns, decimals: int = 4, headers: Sequence[str] = ()) -> Path:
    """Write columns as CSV, under their own names unless ``headers`` are given."""
    lines = [",".join(headers or columns)]
    lines += [",".join(f"{value:.{decimals}f}" for value in row) for row in zip(*columns.values(), strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def write_displacement_campaign(
    folder: Path,
    columns: Columns | None = None,
    manifest: str = MANIFEST,
    change: Callable[[Columns], None] | None = None,
) -> Path:
    """Write the campaign and return its folder."""
    columns = displacement_columns() if columns is None else columns
    if change is not None:
        change(columns)
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(manifest, encoding="utf-8")
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    write_table(folder / "raw" / "table.csv", columns)
    return folder


def campaign_of_robot(name: str, poses: int, folder: Path) -> tuple[Path, Columns]:
    """Return a campaign's folder with a bundled robot and its columns: poses around one where J2 stands at zero."""
    chain = chain_of(load_robot(ROBOTS / f"{name}.toml"), ROBOTS)
    middle, spread = np.radians([0, 0, 20, 0, 40, 0]), np.radians([60, 20, 20, 60, 40, 90])
    joints = middle + spread * np.random.default_rng(4).uniform(-1.0, 1.0, (poses, 6))
    columns = displacement_columns(joints=joints, chain=chain)
    folder = write_displacement_campaign(folder, columns)
    text = (ROBOTS / f"{name}.toml").read_text(encoding="utf-8")
    # the names of the table's columns
    (folder / "robot.toml").write_text(re.sub(r"\bJ([1-6])\b", r"A\1", text), encoding="utf-8")
    return folder, columns
