"""A campaign of any number of small runs, each a log of its own, written in a moment."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.campaign_effects import placed_robot
from tests.laboratory.small_campaign import MODEL, NOISE_M, STIFFNESS, robot_text

MANIFEST = """
schema = "stiffcal/campaign/1"
name = "long"
robot = "robot.toml"

[frames.target]
parent = "flange"
xyz_m = [0.06, -0.04, 0.1]

[sources.log]
file = "raw/{run}_log.csv"
time = { column = "t", unit = "s" }
joints = { position = "A1..A6", units = { position = "deg" } }
wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, axes = "base", point = "target" }

[sources.tracker]
file = "raw/{run}_tracker.csv"
time = { column = "time", unit = "iso8601" }
pose = { frame = "base", body = "target", position = ["X", "Y", "Z"], units = { position = "mm" } }
"""
MOVED = MANIFEST[: MANIFEST.index("[sources.tracker]")] + "".join(
    f"""
[frames.place{k}]
parent = "base"
estimate = true

[sources.tracker{k}]
file = "raw/{{run}}_tracker{k}.csv"
time = {{ column = "time", unit = "iso8601" }}
pose = {{ frame = "place{k}", body = "target", position = ["X", "Y", "Z"], units = {{ position = "mm" }} }}
"""
    for k in (1, 2, 3)
)
"""The tracker is moved twice; where it stood is not stated."""
STOOD = (((3.0, -1.0, 0.3), 120.0), ((2.5, 2.0, 0.4), -150.0), ((-2.0, 3.0, 0.2), -40.0))
"""Its places, m in base axes, and its turns about the vertical, °: one for each week."""
RATE, HOLD_S, RAMP_S, LOAD_N = 20.0, 1.6, 0.4, 300.0
BEGIN = datetime(2026, 11, 2, 8, 0, tzinfo=UTC)
EVERY = timedelta(minutes=3)
"""From one run to the next: two hundred in a day's shift of ten hours."""


def write_head(folder: Path, manifest: str = MANIFEST) -> None:
    """Write manifest, robot and model."""
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(manifest, encoding="utf-8")
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")


def write_runs(folder: Path, first: int, stop: int, rows_per_second: float = RATE, moved: bool = False) -> None:
    """Write the logs of runs `first` to `stop`, from 1; the same number gives the same logs.

    Each run is one pose: no load, a load along one direction, one along another. The clock of the tracker is the day's.
    With ``moved`` they are spread over three weeks, after each of which the tracker stands elsewhere (`STOOD`).
    """
    campaign = load_campaign(folder, check_files=False)
    chain = campaign.chain
    values = {f"joint-compliance.j{k + 1}.c": 1.0 / size for k, size in enumerate(STIFFNESS)}
    robot = placed_robot(campaign).with_values(values)
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    loads = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.0, 0.2, 1.0], [-0.2, 1.0, 0.1], [0.0, 0.0, 0.0]]) * LOAD_N
    time, share = _course(len(loads), rows_per_second)
    for number in range(first, stop):
        generator = np.random.default_rng(number)
        pose = np.array([0.0, -80.0, 15.0, 0.0, 40.0, 0.0]) + generator.uniform(-1, 1, 6) * [60, 20, 25, 80, 30, 120]
        wrench = np.zeros((len(loads), 6))
        wrench[:, :3] = loads
        angles = chain.model_angles(np.repeat(np.radians([pose]), len(loads), axis=0))
        place = solve_balance(robot, angles, wrench, setup).target_position[:, 0]
        force = share @ loads + generator.normal(scale=0.3, size=(time.size, 3))
        position = share @ place + NOISE_M * generator.normal(size=(time.size, 3))
        tracker, begin = "tracker", BEGIN + number * EVERY
        if moved:
            week = (number - first) * len(STOOD) // (stop - first)
            origin, turn = STOOD[week]
            tracker, begin = f"tracker{week + 1}", begin + timedelta(weeks=week)
            position = (position - origin) @ rotation_from_vector(np.array([0.0, 0.0, np.radians(turn)]))
        position *= 1e3
        _write(
            folder / f"raw/run{number}_log.csv",
            "t,A1,A2,A3,A4,A5,A6,Fx,Fy,Fz",
            time,
            np.tile(pose, (time.size, 1)),
            force,
        )
        stamps = [(begin + timedelta(seconds=float(second))).isoformat(timespec="milliseconds") for second in time]
        rows = (f"{stamp},{x:.4f},{y:.4f},{z:.4f}" for stamp, (x, y, z) in zip(stamps, position, strict=True))
        text = "\n".join(("time,X,Y,Z", *rows)) + "\n"
        (folder / f"raw/run{number}_{tracker}.csv").write_text(text, encoding="utf-8")


def _course(n_loads: int, rate: float) -> tuple[Floats, Floats]:
    """Return (n,) times, s, and (n, l) the share of each load at each: held, then ramps from one to the next."""
    corners = np.cumsum(np.stack([np.full(n_loads, RAMP_S), np.full(n_loads, HOLD_S)], axis=1).ravel()) - RAMP_S
    time = np.arange(0.0, corners[-1], 1.0 / rate)
    held = np.repeat(np.eye(n_loads), 2, axis=0)
    return time, np.stack([np.interp(time, corners, column) for column in held.T], axis=1)


def _write(path: Path, head: str, time: Floats, *columns: Floats) -> None:
    table = np.concatenate([time[:, None], *columns], axis=1)
    rows = (",".join(f"{cell:.6g}" for cell in row) for row in table.tolist())
    path.write_text("\n".join((head, *rows)) + "\n", encoding="utf-8")
