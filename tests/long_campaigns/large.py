"""Campaigns of few runs with much in them: a table of any number of states in one run, logs of any number of bytes."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.campaign_effects import placed_robot
from tests.laboratory.small_campaign import CAMPAIGN, MODEL, NOISE_M, POSES_DEG, STIFFNESS, robot_text
from tests.long_campaigns.campaign import LOAD_N, MANIFEST

LOADS = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.0, 0.2, 1.0], [-0.2, 1.0, 0.1], [0.0, 0.0, 0.0]]) * LOAD_N
FORCE_RATE, TRACKER_RATE = 7000, 20
CYCLE = 12
"""States of a table after which its loads begin anew."""
RAMP_S = 0.4
LEAST_HOLD_S = 2
STATES_AT_ONCE = 50_000


def write_table(folder: Path, states: int, each: int = 0) -> None:
    """Write a campaign of one table: so many states, full poses, loads along three directions in turn.

    They are of one run, or a run has `each` of them.
    """
    _write_settings(folder, CAMPAIGN)
    generator = np.random.default_rng(states)
    steps = np.array([[0.0], [0.5], [1.0], [0.5]])
    cycle = np.concatenate([steps * direction for direction in LOADS[1:4]])
    position, rotation = _places(folder, POSES_DEG[0], cycle)
    with (folder / "raw/states.csv").open("w", encoding="utf-8") as file:
        file.write("run,A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,X,Y,Z,rx,ry,rz\n")
        for start in range(0, states, STATES_AT_ONCE):
            numbers = np.arange(start, min(start + STATES_AT_ONCE, states))
            noise = generator.standard_normal((len(numbers), 6)) * ([1e3 * NOISE_M] * 3 + [2e-5] * 3)
            places = np.hstack([1e3 * position, rotation])[numbers % len(cycle)] + noise
            rows = np.hstack([np.tile(POSES_DEG[0], (len(numbers), 1)), cycle[numbers % len(cycle)], places])
            runs = numbers // each + 1 if each else np.ones_like(numbers)
            file.writelines(
                f"pose{run}," + ",".join(f"{cell:.9g}" for cell in row) + "\n"
                for run, row in zip(runs.tolist(), rows.tolist(), strict=True)
            )


def write_logs(folder: Path, size: float) -> None:
    """Write a campaign of three runs whose logs of joints and forces have so many bytes together, 7000 rows a second.

    Loads are held for as long as that takes; noise repeats every second.
    """
    manifest = MANIFEST.replace('time = { column = "t", unit = "s" }', f"time = {{ rate_hz = {FORCE_RATE} }}")
    _write_settings(folder, manifest.replace('unit = "iso8601"', 'unit = "s"'))
    generator = np.random.default_rng(1)
    for number, pose in enumerate(POSES_DEG[:3], start=1):
        held = [_rows_of_force(pose, np.tile(load, (FORCE_RATE, 1)), generator) for load in LOADS]
        ramps = [
            _rows_of_force(pose, np.linspace(one, other, round(RAMP_S * FORCE_RATE)), generator)
            for one, other in pairwise(LOADS)
        ]
        seconds = max(LEAST_HOLD_S, round(size / 3 / sum(map(len, held))))
        with (folder / f"raw/run{number}_log.csv").open("wb") as file:
            file.write(b"A1,A2,A3,A4,A5,A6,Fx,Fy,Fz\n")
            for hold, ramp in zip(held, [*ramps, b""], strict=True):
                for _ in range(seconds):
                    file.write(hold)
                file.write(ramp)
        position, _ = _places(folder, pose, LOADS)
        corners = np.cumsum([0.0, *([seconds, RAMP_S] * len(LOADS))])[:-1]
        time = np.arange(0.0, corners[-1], 1.0 / TRACKER_RATE)
        course = np.stack([np.interp(time, corners, np.repeat(column, 2)) for column in position.T], axis=1)
        course = 1e3 * (course + NOISE_M * generator.standard_normal(course.shape))
        with (folder / f"raw/run{number}_tracker.csv").open("w", encoding="utf-8") as tracker:
            tracker.write("time,X,Y,Z\n")
            tracker.writelines(
                f"{at:.3f},{x:.4f},{y:.4f},{z:.4f}\n"
                for at, (x, y, z) in zip(time.tolist(), course.tolist(), strict=True)
            )


def _write_settings(folder: Path, manifest: str) -> None:
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(manifest, encoding="utf-8")
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")


def _places(folder: Path, pose: tuple[float, ...], loads: Floats) -> tuple[Floats, Floats]:
    """Return (n, 3) m the places and (n, 3) rad the rotation vectors of the target under loads (n, 3) N."""
    campaign = load_campaign(folder, check_files=False)
    chain = campaign.chain
    values = {f"joint-compliance.j{k + 1}.c": 1.0 / size for k, size in enumerate(STIFFNESS)}
    robot = placed_robot(campaign).with_values(values)
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    wrench = np.hstack([loads, np.zeros((len(loads), 3))])
    angles = chain.model_angles(np.repeat(np.radians([pose]), len(loads), axis=0))
    balance = solve_balance(robot, angles, wrench, setup)
    return balance.target_position[:, 0], vector_from_rotation(balance.target_rotation[:, 0])


def _rows_of_force(pose: tuple[float, ...], force: Floats, generator: np.random.Generator) -> bytes:
    angles = ",".join(f"{angle:.4f}" for angle in pose)
    noisy = force + generator.normal(scale=0.3, size=force.shape)
    return "".join(f"{angles},{x:.4f},{y:.4f},{z:.4f}\n" for x, y, z in noisy.tolist()).encode()
