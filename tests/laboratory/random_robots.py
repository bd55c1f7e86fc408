"""Robots for the rates: three families, geometry, masses and stiffness varied at random."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from tests.laboratory.robots import SEVEN_AXES, SEVEN_STIFFNESS, SIX_AXES, SIX_STIFFNESS

Row = tuple[float, float, float, float, float, tuple[float, float, float]]

HEAVY_AXES: tuple[Row, ...] = (
    # a m, alpha deg, d m, theta deg, mass kg, centre of mass m: modified DH, a machining robot
    (0.0, 0.0, 0.70, 0.0, 270.0, (0.16, 0.0, -0.15)),
    (0.36, -90.0, 0.0, 0.0, 190.0, (0.52, 0.0, 0.10)),
    (1.20, 0.0, 0.0, -90.0, 210.0, (0.05, 0.25, 0.0)),
    (0.05, -90.0, 1.05, 0.0, 60.0, (0.0, 0.0, -0.35)),
    (0.0, 90.0, 0.0, 0.0, 30.0, (0.0, 0.03, 0.0)),
    (0.0, -90.0, 0.0, 0.0, 15.0, (0.0, 0.0, 0.18)),
)
HEAVY_STIFFNESS = np.array([2.7, 2.6, 2.4, 0.55, 0.5, 0.35]) * 1e6
"""N·m/rad, of the order of a 240 kg class robot."""


@dataclass(frozen=True)
class Family:
    """A kind of robot.

    Attributes
    ----------
    rows, flange : modified Denavit-Hartenberg parameters, masses; m along the last axis.
    stiffness : (J,) N·m/rad.
    centre, spread : (L,) of logged positions, deg, m of a prismatic joint, where poses are drawn.
    force : N, largest loads.
    translation, rotation : m and rad, tracker noise per state and axis.
    prismatic : numbers of the joints that slide, from 1.
    coupled : of joints that are not logged by themselves, by number, entries of the robot file (`logged`, `coupling`).
    gravity : m/s², base axes.
    """

    name: str
    rows: tuple[Row, ...]
    flange: float
    stiffness: Floats
    centre: tuple[float, ...]
    spread: tuple[float, ...]
    force: float
    translation: float
    rotation: float
    prismatic: tuple[int, ...] = ()
    coupled: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)

    def draw_joints(self, rng: np.random.Generator, poses: int) -> Floats:
        """Draw (poses, L) logged positions, rad, m of a prismatic joint."""
        n = len(self.centre)
        drawn = np.array(self.centre) + np.array(self.spread) * rng.uniform(-1.0, 1.0, (poses, n))
        slides = np.isin(np.arange(1, n + 1), self.prismatic)
        return np.asarray(np.where(slides, drawn, np.radians(drawn)))


FAMILIES = (
    Family(
        "heavy six-axis", HEAVY_AXES, 0.24, HEAVY_STIFFNESS,
        (0, -70, 22, 0, 0, 0), (65, 42, 44, 110, 95, 140), 1700.0, 18e-6, 25e-6,
    ),
    Family(
        "medium six-axis", SIX_AXES, 0.14, SIX_STIFFNESS,
        (0, -75, 15, 0, 0, 0), (65, 38, 40, 110, 95, 140), 310.0, 16e-6, 30e-6,
    ),
    Family(
        "seven-axis", SEVEN_AXES, 0.15, SEVEN_STIFFNESS,
        (0, 0, 0, 63, 0, 0, 0), (85, 75, 85, 45, 85, 90, 140), 70.0, 15e-6, 40e-6,
    ),
)  # fmt: skip


@dataclass(frozen=True)
class DrawnRobot:
    """A robot that no other campaign has.

    Attributes
    ----------
    chain : with all its masses.
    stiffness : (J,) N·m/rad.
    family : what it was drawn from.
    """

    chain: Chain
    stiffness: Floats
    family: Family

    def without_masses(self) -> Chain:
        """Return the chain as somebody knows it who does not know the masses."""
        return replace(self.chain, masses_known=False, link_mass=np.zeros_like(self.chain.link_mass))


def draw_robot(rng: np.random.Generator, families: Sequence[Family] = FAMILIES) -> DrawnRobot:
    """Draw a family, then lengths by ±15 %, masses by ±20 %, stiffness by some 25 %."""
    family = families[int(rng.integers(len(families)))]
    names = [f"link{k + 1}" for k in range(len(family.rows))]
    names[1], names[2 if len(names) == 6 else 3] = "swing", "arm"
    joints: list[dict[str, Any]] = []
    for number, (a, alpha, d, theta, mass, com) in enumerate(family.rows):
        size = rng.uniform(0.85, 1.15)
        joints.append(
            {
                "name": f"A{number + 1}", "a_m": a * size, "alpha_deg": alpha, "d_m": d * size, "theta_deg": theta,
                "link": {
                    "name": names[number],
                    "mass_kg": mass * rng.uniform(0.8, 1.2),
                    "com_m": [x * size for x in com],
                },
                **({"type": "prismatic", "limits_m": [-5.0, 5.0]} if number + 1 in family.prismatic else {}),
                **family.coupled.get(number + 1, {}),
            }
        )  # fmt: skip
    flange = family.flange * rng.uniform(0.85, 1.15)
    robot = {
        "schema": "stiffcal/robot/1", "name": family.name, "convention": "modified-dh", "joints": joints,
        "flange": {"xyz_m": [0.0, 0.0, flange]}, "gravity_mps2": list(family.gravity),
    }  # fmt: skip
    if len(family.rows) == 6 and not family.prismatic and rng.uniform() < 0.25:
        # from behind and below joint 2 to a third up its link, as on heavy robots; a rate that is stated would count
        arm, drop = float(family.rows[2][0]) * rng.uniform(0.25, 0.4), rng.uniform(-0.3, -0.15)
        robot["gravity_compensator"] = {
            "joint": 2, "anchor_m": [rng.uniform(-0.5, -0.3), 0.0, drop], "arm_m": [arm, rng.uniform(-0.1, 0.1), 0.0],
        }  # fmt: skip
    chain = chain_of(RobotFile.model_validate(robot), Path())
    return DrawnRobot(chain, family.stiffness * np.exp(0.25 * rng.normal(size=len(joints))), family)


def draw_setup(rng: np.random.Generator, chain: Chain, point: Floats, force_only: bool) -> MeasurementSetup:
    """Return a force sensor turned about the flange's axis and a target next to it.

    Parameters
    ----------
    point : (3,) where the force acts, in the sensor's frame, m.
    force_only : the sensor reads no moments; the manifest then says where the force acts.
    """
    flange = chain.n_joints + 1
    sensor = Attachment(flange, _attachment((0.0, 0.0, 0.06), rng.uniform(-1.0, 1.0)))
    target = Attachment(flange, _attachment((0.06, *rng.uniform(-0.06, 0.06, 1), rng.uniform(0.08, 0.15)), 0.0))
    acts = np.eye(4)
    acts[:3, 3] = point
    place = Attachment(flange, sensor.transform @ acts) if force_only else sensor
    return MeasurementSetup(sensor, place, (target,), ("target",), not force_only)


def _attachment(position: tuple[float, ...], turn: float) -> Floats:
    transform = np.eye(4)
    c, s = np.cos(turn), np.sin(turn)
    transform[:2, :2] = [[c, -s], [s, c]]
    transform[:3, 3] = position
    return transform
