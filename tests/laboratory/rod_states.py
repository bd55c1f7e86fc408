"""Campaigns of a robot whose swing carries rods, or whose tool is pushed by a load-displacement device."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.measurements.load_states import Attachment, Gauge, LoadStates, Sigma
from stiffcal.measurements.rods import Rods, rods_between
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rods import rod_matrix
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place, StateOrder, link_node
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.simulated_states import joint_springs
from tests.laboratory.small_campaign import robot_text

SWING = {"EI2": 4e6, "EI3": 6e6, "GJ": 3e6, "EA": 1.5e9}
"""Of the swing of most of these campaigns, N·m² and N."""
NOISE = Sigma(translation=10e-6, rotation=20e-6)
"""Of their tracker."""

# Two pairs on opposite sides, long ones and short ones, and a fifth: paper 000's pattern.
STARTS = np.array([[0.05, 0.0, 0.1], [0.05, 0.11, 0.0], [0.05, -0.11, 0.0], [0.1, 0.0, 0.12], [0.1, 0.0, -0.12]])
ENDS = np.array([[0.8, 0.0, 0.1], [0.75, 0.11, 0.0], [0.75, -0.11, 0.0], [0.45, 0.0, 0.12], [0.45, 0.0, -0.12]])


def six_axes_with_beams() -> Chain:
    """Return the medium six-axis robot with its swing and arm as places for beams."""
    return chain_of(RobotFile.model_validate(tomllib.loads(robot_text())), Path())


def five_rods(chain: Chain, sigma: float = 1e-6, link: str = "swing") -> Rods:
    """Return five rods on a link."""
    return rods_between(link, STARTS, ENDS, sigma)


def placed(effect: str, place: Place, **values: float) -> PlacedEffect:
    """Return an effect at a place, with or without values."""
    return PlacedEffect(find_effects()[effect], place, values)


def bending_swing(**values: float) -> PlacedEffect:
    """Return a swing that bends, with or without values."""
    return placed("link-beam", Place("links", (), "swing"), **values)


def tilting_bearing(joint: int = 2, **values: float) -> PlacedEffect:
    """Return a bearing that tilts, with or without values."""
    return placed("bearing-tilt", Place("joints", (joint,)), **values)


def with_effect(robot: CompliantRobot, *added: PlacedEffect) -> CompliantRobot:
    """Return the robot with more effects."""
    return replace(robot, placed=(*robot.placed, *added))


def swinging_robot() -> CompliantRobot:
    """Return the medium six-axis robot with the published joint stiffness and a swing that bends."""
    return with_effect(joint_springs(six_axes_with_beams(), SIX_STIFFNESS), bending_swing(**SWING))


def with_rods(
    states: LoadStates, robot: CompliantRobot, rods: Rods, seed: int = 7, wrench: Floats | None = None
) -> LoadStates:
    """Let the rods on the robot's link read in all states; their noise is that of ``rods.sigma``.

    Parameters
    ----------
    wrench : (n, 6) the true wrenches; the states' where None.
    """
    n, chain = len(states), robot.chain
    beam = chain.beams[rods.link]
    nodes = solve_balance(
        robot,
        chain.model_angles(states.joints),
        states.wrench if wrench is None else wrench,
        states.setup,
        _order(states),
    ).nodes
    read = nodes[:, link_node(beam.joint)] @ rod_matrix(rods, beam.shape).T
    noise = np.nan_to_num(rods.sigma) * np.random.default_rng(seed).standard_normal((n, len(rods.names)))
    sigma = replace(states.setup.sigma, length=float(rods.sigma[0]))
    setup = replace(states.setup, rods=(rods,), beams=(beam.shape,), sigma=sigma)
    return replace(states, lengths=read + noise + 1e-4, setup=setup)


def without_rods(states: LoadStates) -> LoadStates:
    """Return the states as if there were no rods."""
    setup = replace(states.setup, rods=(), beams=(), sigma=replace(states.setup.sigma, length=None))
    return replace(states, lengths=np.zeros((len(states), 0)), setup=setup)


def gauge_instead(states: LoadStates, robot: CompliantRobot, sigma: float = 2e-6, seed: int = 8) -> LoadStates:
    """Replace the tracker by a device per base axis that reads along it, another axis in each run."""
    n, chain = len(states), robot.chain
    moved = solve_balance(robot, chain.model_angles(states.joints), states.wrench, states.setup, _order(states))
    axis = states.run % 3
    reading = np.full((n, 3), np.nan)
    noise = sigma * np.random.default_rng(seed).standard_normal(n)
    reading[np.arange(n), axis] = moved.displacement[np.arange(n), 0, axis] + noise + 3e-4
    base = Attachment(0, np.eye(4))
    setup = replace(
        states.setup,
        gauges=tuple(Gauge(f"device_{name}", 0, base, np.eye(3)[k]) for k, name in enumerate("xyz")),
        sigma=Sigma(force=states.setup.sigma.force, moment=states.setup.sigma.moment, gauge=sigma),
    )
    nothing = np.full_like(states.position, np.nan)
    return replace(
        states, position=nothing, rotation=np.full_like(states.rotation, np.nan), displacement=reading, setup=setup
    )


def _order(states: LoadStates) -> StateOrder:
    n = len(states)
    unknown = np.full(n, np.nan)
    still = np.zeros((states.joints.shape[1], n))
    return StateOrder(states.run, states.time, unknown, still, unknown, states.time, np.arange(1, n + 1))
