"""What is measured: poses and loads of a campaign, before anything is read."""

from __future__ import annotations

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from tests.laboratory.random_robots import DrawnRobot, draw_setup
from tests.laboratory.unread_states import unread_states

LEVELS = np.array([0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0])
ONE_CYCLE = np.concatenate([LEVELS, -LEVELS])


def cycles(rng: np.random.Generator, robot: DrawnRobot, full_pose: bool, force_only: bool) -> LoadStates:
    """Return load cycles in 8 to 14 poses, and no readings yet."""
    poses, family = int(rng.integers(8, 15)), robot.family
    directions = int(rng.integers(2, 5))
    per_run = 1 + directions * 2 * len(ONE_CYCLE)
    angles = family.draw_joints(rng, poses)
    wrench = np.zeros((poses, per_run, 6))
    point = np.array([0.02, 0.0, rng.uniform(0.1, 0.16)])
    setup = draw_setup(rng, robot.chain, point, force_only)
    for pose in range(poses):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        if directions == 4:
            axes = np.vstack([axes, np.sum(axes, axis=0)[None] / np.sqrt(3.0)])
        level = (
            np.tile(ONE_CYCLE, 2)[None]
            * family.force
            * (1.0 + 0.03 * rng.normal(size=(directions, per_run // directions)))
        )
        wrench[pose, 1:, :3] = (level[:, :, None] * axes[:directions, None]).reshape(-1, 3)
        if not force_only:
            wrench[pose, :, 3:] = np.cross(point, wrench[pose, :, :3])
    return unread_states(angles, wrench, setup, full_pose)


def spreadsheet(rng: np.random.Generator, robot: DrawnRobot, full_pose: bool, force_only: bool) -> LoadStates:
    """Return 24 poses, each unloaded and under two loads of different directions, none of them twice."""
    poses, family = 24, robot.family
    angles = family.draw_joints(rng, poses)
    point = np.array([0.02, 0.0, rng.uniform(0.1, 0.16)])
    direction = rng.normal(size=(poses, 2, 3))
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    wrench = np.zeros((poses, 3, 6))
    wrench[:, 1:, :3] = family.force * rng.uniform(0.5, 1.0, (poses, 2, 1)) * direction
    if not force_only:
        wrench[:, :, 3:] = np.cross(point, wrench[:, :, :3])
    return unread_states(angles, wrench, draw_setup(rng, robot.chain, point, force_only), full_pose)
