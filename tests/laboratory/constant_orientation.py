"""Absolute campaigns of robots whose target does not turn: a SCARA, a palletiser, and a table of one orientation.

Places by products of matrices on a true robot that differs from the robot file by zeros and lengths of some 0.5 mm and
0.5 mrad; 20 µm of noise. Tracker and target are to be found.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector, transform, vector_from_rotation
from tests.laboratory.robots import SIX_AXES, shifted

SIGMA = 2e-5
TARGET = (0.06, -0.04, 0.10)
"""m, flange frame; the manifest states it 5 mm off along z."""
TRACKER = transform(rotation_from_vector(np.array([0.02, -0.01, 2.0])), np.array([3.0, -1.5, 0.6]))
"""base_from_tracker."""

Entry = dict[str, Any]


def _entry(name: str, a: float, alpha: float, d: float, theta: float, mass: float, **more: Any) -> Entry:
    link = {"name": f"link{name}", "mass_kg": mass, "com_m": [0.1, 0.02, 0.03]}
    return {"name": name, "a_m": a, "alpha_deg": alpha, "d_m": d, "theta_deg": theta, "link": link} | more


SCARA = [
    _entry("A1", 0.0, 0.0, 0.4, 0.0, 20.0, limits_deg=[-130, 130]),
    _entry("A2", 0.35, 0.0, 0.0, 0.0, 12.0, limits_deg=[-140, 140]),
    _entry("Z", 0.30, 180.0, 0.05, 0.0, 2.0, type="prismatic", limits_m=[0.0, 0.2]),
    _entry("A4", 0.0, 0.0, 0.0, 0.0, 1.0, limits_deg=[-180, 180]),
]
# the rods of the wrist hold it upright: its joint follows the two before it
PALLETISER = [
    _entry("A1", 0.0, 0.0, 0.8, 0.0, 300.0, limits_deg=[-170, 170]),
    _entry("A2", 0.3, -90.0, 0.0, 0.0, 200.0, limits_deg=[-130, -40]),
    _entry("A3", 1.2, 0.0, 0.0, 0.0, 150.0, limits_deg=[20, 130]),
    _entry("P", 1.1, 0.0, 0.0, 0.0, 30.0, limits_deg=[-90, 90], logged={"A2": -1.0, "A3": -1.0}),
    _entry("A4", 0.2, -90.0, 0.1, 0.0, 10.0, limits_deg=[-180, 180]),
]
SIX = [
    _entry(f"A{k + 1}", a, alpha, d, theta, mass, limits_deg=[-170, 170])
    for k, (a, alpha, d, theta, mass, _) in enumerate(SIX_AXES)
]
ROBOTS: dict[str, list[Entry]] = {"scara": SCARA, "palletiser": PALLETISER, "table of one orientation": SIX}


def robot_file(joints: list[Entry]) -> RobotFile:
    return RobotFile.model_validate({"schema": "stiffcal/robot/1", "convention": "modified-dh", "joints": joints})


def logged_poses(name: str, n: int, seed: int) -> Floats:
    """Return (n, L) logged positions, rad and m; of the six-axis robot those that hold one orientation."""
    rng = np.random.default_rng(seed)
    chain = chain_of(robot_file(ROBOTS[name]), Path())
    low, high = np.where(np.isfinite(chain.limits), chain.limits, [-1.0, 1.0]).T
    drawn = rng.uniform(low, high, (n, chain.n_joints))
    return drawn if ROBOTS[name] is not SIX else np.array([_upright(chain, rng) for _ in range(n)])


def _upright(chain: Chain, rng: np.random.Generator) -> Floats:
    """Return joint angles that bring the flange to a drawn place with its z axis down, by Newton steps."""
    down = rotation_from_vector(np.array([np.pi, 0.0, 0.0]))
    tip = Attachment(chain.n_joints + 1, np.eye(4))
    while True:
        goal = np.array([rng.uniform(0.5, 1.2), rng.uniform(-0.7, 0.7), rng.uniform(0.2, 1.0)])
        q = np.radians([0.0, -70.0, 20.0, 0.0, 50.0, 0.0]) + rng.uniform(-0.5, 0.5, 6)
        for _ in range(50):
            ahead = np.concatenate([q[None], q + 1e-6 * np.eye(6)])
            place, turn = attached_poses(chain, chain.model_angles(ahead), tip)
            away = np.concatenate([place - goal, vector_from_rotation(turn @ down.T)], axis=1)
            if np.abs(away[0]).max() < 1e-10:
                return np.asarray((q + np.pi) % (2.0 * np.pi) - np.pi)
            slope = (away[1:] - away[0]).T / 1e-6
            q = q - np.clip(np.linalg.lstsq(slope, away[0], rcond=1e-6)[0], -0.3, 0.3)


def true_chain(chain: Chain, seed: int) -> Chain:
    """Return the chain as it was built: half a millimetre and half a milliradian at every joint but the first."""
    rng = np.random.default_rng(seed)
    fixed = chain.fixed.copy()
    for k in range(1, chain.n_joints):
        fixed[k] = fixed[k] @ transform(rotation_from_vector(rng.normal(0.0, 5e-4, 3)), rng.normal(0.0, 5e-4, 3))
    return replace(chain, fixed=fixed)


def write_campaign(folder: Path, name: str, n: int = 60, seed: int = 1, more: str = "") -> Path:
    """Write the campaign; return its folder."""
    import tomlkit

    (folder / "raw").mkdir(parents=True)
    joints = ROBOTS[name]
    chain = chain_of(robot_file(joints), folder)
    robot = {"schema": "stiffcal/robot/1", "name": name, "convention": "modified-dh", "joints": joints}
    (folder / "robot.toml").write_text(tomlkit.dumps(robot), "utf-8")
    logged = logged_poses(name, n, seed)
    target = Attachment(chain.n_joints + 1, shifted(*TARGET))
    place, _ = attached_poses(true_chain(chain, seed), chain.model_angles(logged), target)
    seen = (np.c_[place, np.ones(n)] @ np.linalg.inv(TRACKER).T)[:, :3]
    seen = seen + np.random.default_rng(seed + 1).normal(0.0, SIGMA, seen.shape)
    names = [entry["name"] for entry in joints]
    units = ", ".join('"mm"' if prismatic else '"deg"' for prismatic in chain.prismatic)
    header = ",".join([*names, "X1", "Y1", "Z1"])
    np.savetxt(
        folder / "raw" / "poses.csv", np.c_[chain.printed_positions(logged), 1e3 * seen], "%.6f", ",", header=header,
        comments="",
    )  # fmt: skip
    (folder / "campaign.toml").write_text(
        f"""schema = "stiffcal/campaign/1"
robot = "robot.toml"

[frames.tracker]
parent = "base"
estimate = true

[frames.target1]
parent = "flange"
estimate = true
xyz_m = [{TARGET[0]}, {TARGET[1]}, {TARGET[2] + 0.005}]

[sources.table]
file = "raw/poses.csv"
sampling = "states"
joints = {{ position = {names}, units = {{ position = [{units}] }} }}

[sources.table.poses.target1]
frame = "tracker"
position = ["X1", "Y1", "Z1"]
units = {{ position = "mm" }}
sigma = {{ position = {1e3 * SIGMA} }}

[[runs]]
id = "poses"
experiment = "absolute"
{more}""",
        "utf-8",
    )
    return folder
