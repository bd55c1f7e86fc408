"""MuJoCo as the robot that ``stiffcal simulate`` loads: its poses go through our instruments into raw logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.effect import StateOrder
from stiffcal.simulation.played.places import Places
from stiffcal.simulation.played.true_motion import RestSolver
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from tests.laboratory.log_campaigns import Robot
from tests.laboratory.mujoco_path import MujocoPath
from tests.laboratory.mujoco_robot import MujocoRobot
from tests.laboratory.robots import SIX_STIFFNESS


def mujoco_settles(chain: Chain, robot: Robot) -> RestSolver:
    """Return a robot for ``simulate``: settled state by state, or led along its path where that matters."""
    drives = SIX_STIFFNESS if robot.mujoco_drives is None else robot.mujoco_drives

    def settle(joints: Floats, wrench: Floats, setup: MeasurementSetup, order: StateOrder) -> Places:
        played = MujocoRobot(chain, drives, setup, robot.springs, cables=robot.cables)
        if any(spring.needs_path for spring in robot.springs):
            rest = MujocoPath(played).walk(joints, wrench, order.run, order.time)
        else:
            rest = played.settle(joints, wrench)
        first = np.searchsorted(order.run, order.run)
        turn = rest.rotation @ np.swapaxes(rest.rotation[first], -1, -2)
        turned = np.stack([vector_from_rotation(one) for one in turn])
        return Places(
            rest.position, rest.rotation, np.concatenate([rest.position - rest.position[first], turned], axis=-1)
        )

    return settle


def measure_mujoco(robot: Robot, source: Path, out: Path) -> dict[str, Any]:
    """Write the raw logs of a folder's campaign, MuJoCo being the robot; return the truth as its model file has it."""
    campaign = load_campaign(source, check_files=False)
    settle = mujoco_settles(campaign.chain, robot)
    written = simulate_campaign(campaign, load_settings(source), out, robot.seed, settle=settle)
    truth: dict[str, Any] = written["truth"]
    return truth
