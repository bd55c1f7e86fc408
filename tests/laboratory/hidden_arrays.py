"""The campaigns of `campaigns/hidden`, read with the standard library and none of stiffcal's readers.

Made by a simulator that shares nothing with stiffcal.
"""

from __future__ import annotations

import csv
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup, TrackerPlace
from stiffcal.mechanics.chain import Chain
from tests.laboratory.hidden_campaigns import folder_of, truth
from tests.laboratory.robots import chain_from_rows


@dataclass(frozen=True)
class HiddenCampaign:
    """A campaign as arrays.

    Attributes
    ----------
    chain, setup : robot and frames.
    joint_stiffness : (J,) N·m/rad, the truth.
    joints : (n, J) model angles, rad.
    wrench : (n, 6) N, N·m, sensor axes, on the robot.
    position : (n, 3) m, base axes.
    rotation : (n, 3, 3) base_from_target, or None where only positions were measured.
    run : (n,) run number.
    noise : translation_m and rotation_rad, per axis.
    """

    chain: Chain
    setup: MeasurementSetup
    joint_stiffness: Floats
    joints: Floats
    wrench: Floats
    position: Floats
    rotation: Floats | None
    run: Floats
    noise: dict[str, float]


def read_arrays(name: str) -> HiddenCampaign:
    """Read one of the tables."""
    folder = folder_of(name)
    robot, frames = _toml(folder / "robot.toml"), _toml(folder / "campaign.toml")["frames"]
    chain = chain_from_rows(
        robot["name"],
        tuple(
            (j["a_m"], j["alpha_deg"], j["d_m"], j["theta_deg"], j["link"]["mass_kg"], tuple(j["link"]["com_m"]))
            for j in robot["joints"]
        ),
        _transform(robot["flange"]),
    )
    flange = chain.n_joints + 1
    sensor = Attachment(flange, _transform(frames["ft_sensor"]))
    base_from_tracker = _transform(frames["tracker"])
    setup = MeasurementSetup(
        wrench_axes=sensor,
        wrench_point=sensor,
        targets=(Attachment(flange, _transform(frames["target"])),),
        target_names=("target",),
        moments_measured=True,
        trackers=(TrackerPlace("tracker", base_from_tracker),),
    )
    with (folder / "raw" / "states.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    known = truth()[name]
    turn = base_from_tracker[:3, :3]
    measured = None
    if "q0" in rows[0]:
        measured = np.stack([turn @ _matrix(one) for one in _columns(rows, ["q0", "qx", "qy", "qz"])])
    return HiddenCampaign(
        chain=chain,
        setup=setup,
        joint_stiffness=np.array(known["joint_stiffness"]),
        joints=chain.model_angles(np.radians(_columns(rows, [f"A{k + 1}" for k in range(chain.n_joints)]))),
        wrench=_columns(rows, ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]),
        position=_columns(rows, ["X", "Y", "Z"]) / 1e3 @ turn.T + base_from_tracker[:3, 3],
        rotation=measured,
        run=np.unique([row["run"] for row in rows], return_inverse=True)[1].astype(np.float64),
        noise=known["noise"],
    )


def scatter_within_runs(residual: Floats, run: Floats) -> float:
    """Return the standard deviation per axis of (n, 3) residuals, one free offset per run and axis taken out."""
    squares, freedom = 0.0, 0
    for number in np.unique(run):
        rest = residual[run == number] - residual[run == number].mean(axis=0)
        squares += float(np.sum(rest**2))
        freedom += 3 * (len(rest) - 1)
    return float(np.sqrt(squares / freedom))


def small_turns(after: Floats, before: Floats) -> Floats:
    """Return (n, 3) rotation vectors of after · beforeᵀ, rad, for turns far below a radian."""
    turn = after @ np.swapaxes(before, 1, 2)
    skew = [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]]
    return np.stack(skew, axis=1) / 2


def _toml(file: Path) -> dict[str, Any]:
    return tomllib.loads(file.read_text("utf-8"))


def _columns(rows: list[dict[str, str]], names: list[str]) -> Floats:
    return np.array([[float(row[name]) for name in names] for row in rows])


def _transform(frame: dict[str, Any]) -> Floats:
    transform = np.eye(4)
    transform[:3, 3] = frame["xyz_m"]
    transform[:3, :3] = _matrix(np.array(frame.get("quaternion_wxyz", [1.0, 0.0, 0.0, 0.0])))
    return transform


def _matrix(quaternion: Floats) -> Floats:
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
