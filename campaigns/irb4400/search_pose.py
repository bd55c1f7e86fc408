"""Search for the pose of paper 002's Fig. 2, which the paper does not print.

Fig. 2 loads the tool tip from (-100, 200, -300) N over 0 to (100, -200, 100) N and shows, in z, an apparent negative
stiffness on one leg and a quite different, positive one on the other. The poses of a grid within the axes' limits are
tried. Wanted is a pose where the first leg pushes the tip down, with the force's z (positive stiffness), and the second
leg moves it down too, against the force's z (negative stiffness): the pose is taken where the smaller of the two
movements is largest. Axis 6 does not matter (the tip lies on it), nor much else does axis 4.

Run: python campaigns/irb4400/search_pose.py
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.simulation.scene import robot_with_values

Floats = NDArray[np.float64]

FOLDER = Path(__file__).parent / "figure-2"
START = np.array([-100.0, 200.0, -300.0])  # N, base axes
END = np.array([100.0, -200.0, 100.0])

# The rod that turns the upper arm lets the two arms stand at right angles, give or take this much (assumed), degrees.
ROD_ALLOWS = 75.0

# Degrees: every 15 within the limits, in front of the robot, tool from level to straight down.
GRID = {
    "A1": tuple(range(-90, 91, 15)),
    "A2": tuple(range(-60, 91, 15)),
    "A3": tuple(range(-60, 61, 15)),
    "A4": (0,),
    "A5": tuple(range(0, 91, 15)),
    "A6": (0,),
}


@dataclass(frozen=True)
class Found:
    """A pose, deg, and the apparent stiffness in z on the two legs, N/m (force's z over deflection's z)."""

    joints_deg: tuple[float, ...]
    first_leg: float
    second_leg: float


def deflections_in_z(robot: CompliantRobot, folder: Path, joints: Floats, force: Floats) -> Floats:
    """Return (n,) deflection of the tip in z, m, under one force, N, base axes, at logged joints (n, 6), rad."""
    campaign = load_campaign(folder, check_files=False)
    frames = resolve_frames(campaign.manifest, campaign.chain)
    setup = measurement_setup(campaign.manifest, campaign.chain, frames)
    wrench = np.zeros((len(joints), 6))
    wrench[:, :3] = force
    balance = solve_balance(robot, campaign.chain.model_angles(joints), wrench, setup)
    return balance.displacement[:, 0, 2]


def search(folder: Path = FOLDER) -> Found:
    """Return the pose that shows Fig. 2 most clearly."""
    robot = robot_with_values(load_campaign(folder, check_files=False))
    grid = np.array(list(itertools.product(*GRID.values())), dtype=np.float64)
    grid = grid[np.abs(grid[:, 2] - grid[:, 1]) <= ROD_ALLOWS]
    joints = np.deg2rad(grid)
    at_start = deflections_in_z(robot, folder, joints, START)
    at_end = deflections_in_z(robot, folder, joints, END)
    best = int(np.argmax(np.minimum(-at_start, -at_end)))
    pose = tuple(float(angle) for angle in grid[best])
    return Found(pose, float(START[2] / at_start[best]), float(END[2] / at_end[best]))


if __name__ == "__main__":
    found = search()
    pose = ",".join(f"{angle:g}" for angle in found.joints_deg)
    print(f"pose [deg]: {pose}")
    print(f"apparent stiffness in z: {1e-3 * found.first_leg:.3g} N/mm on the first leg, "
          f"{1e-3 * found.second_leg:.3g} N/mm on the second")
    print(f'stiffcal predict campaigns/irb4400/figure-2 --load-path "-100,200,-300;0,0,0;100,-200,100" --at {pose}')
