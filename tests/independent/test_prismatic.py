"""Prismatic joints: pinocchio's frames, Jacobians and weights, rows of both conventions, and completeness."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.campaign.robot.geometry import chain_of, planned_rows
from stiffcal.effects.joint_offset import JointOffset
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.gauge import redundant_geometry
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.joint_rows import rows_of_chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.rotations import rotation_from_vector, transform
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.assembled.measured_frames import placed_frame
from stiffcal.model.balance.equilibrium import solve_balance
from tests.laboratory.absolute_places import TARGET, absolute_states
from tests.laboratory.pinocchio_robot import gravity_torques, pinocchio_model, place_and_jacobian
from tests.laboratory.robots import force_sensor_setup, shifted, turned
from tests.laboratory.track_and_arm import GANTRY, SCARA, TRACK, draw_joints, robot_of

EXACT = 1e-12
ROBOTS = {"track": TRACK, "gantry": GANTRY, "scara": SCARA}


def chain_named(name: str, convention: str = "modified-dh") -> Chain:
    return chain_of(robot_of(ROBOTS[name], convention), Path())


@pytest.mark.parametrize("convention", ["modified-dh", "dh"])
@pytest.mark.parametrize("name", ROBOTS)
def test_rows_by_hand(name: str, convention: str) -> None:
    """Elementary transforms multiplied out: a prismatic joint's position is added to d."""
    rows = robot_of(ROBOTS[name], convention).joints
    chain = chain_named(name, convention)
    for q in draw_joints(chain, 3, seed=1):
        place = np.eye(4)
        for row, position in zip(rows, q, strict=True):
            slides = row.type == "prismatic"
            cross = turned(shifted(row.a_m, 0.0, 0.0), 0, np.radians(row.alpha_deg))
            screw = turned(
                shifted(0.0, 0.0, row.d_m + position * slides), 2, np.radians(row.theta_deg) + position * (not slides)
            )
            place = place @ (cross @ screw if convention == "modified-dh" else screw @ cross)
        at, turn = attached_poses(chain, chain.model_angles(q[None]), Attachment(chain.n_joints + 1, np.eye(4)))
        np.testing.assert_allclose(at[0], place[:3, 3], atol=EXACT)
        np.testing.assert_allclose(turn[0], place[:3, :3], atol=EXACT)


@pytest.mark.parametrize("name", ROBOTS)
def test_frames_jacobians_and_weights_are_pinocchios(name: str) -> None:
    chain = chain_named(name)
    model = pinocchio_model(chain)
    target = Attachment(chain.n_joints + 1, turned(shifted(0.06, -0.04, 0.10), 0, -0.3))
    joints = chain.model_angles(draw_joints(chain, 4, seed=2))
    position, rotation = attached_poses(chain, joints, target)
    found = jacobians(chain, joints, target)
    setup = force_sensor_setup(chain)
    balance = solve_balance(CompliantRobot(chain, ()), joints, np.zeros((4, 6)), setup)
    for k, q in enumerate(joints):
        at, turn, jacobian = place_and_jacobian(model, chain, q, target)
        np.testing.assert_allclose(position[k], at, atol=EXACT)
        np.testing.assert_allclose(rotation[k], turn, atol=EXACT)
        np.testing.assert_allclose(found[k], jacobian, atol=EXACT)
        # what pinocchio's motors hold is against the weight
        np.testing.assert_allclose(balance.joint_torque[k], -gravity_torques(model, q), atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_link_geometry_is_the_slope_of_pinocchios_placements(name: str) -> None:
    """Central differences of an outside library's placements, 1e-7 of a column's size."""
    chain = replace(chain_named(name), bearing=np.full(len(ROBOTS[name]), 0.07))
    states = states_of(chain, 6, seed=3)
    robot = CompliantRobot(chain, on_every_joint(LinkGeometry(), chain))
    data = observe(states, chain)
    columns = free_columns(robot)
    found = np.concatenate([block.columns for block in evaluate(robot, data, columns)], axis=2)
    target, step = states.setup.targets[0], 1e-4
    for column, row in zip(columns, found, strict=True):
        placed = robot.placed[column.placed]
        ends = []
        for sign in (1.0, -1.0):
            changed = placed.adjusted_chain(chain, {column.symbol: sign * step})
            model = pinocchio_model(changed)
            ends.append([place_and_jacobian(model, chain, q, target)[0] for q in data.angles.T])
        slope = (np.array(ends[0]) - np.array(ends[1])) / (2.0 * step)
        np.testing.assert_allclose(row.T, slope, atol=1e-7 * np.abs(slope).max())


def states_of(chain: Chain, n: int, seed: int) -> LoadStates:
    """Return n places of one target, measured as zero."""
    return replace(absolute_states(chain, n, seed), joints=draw_joints(chain, n, seed))


def on_every_joint(effect: Any, chain: Chain) -> tuple[PlacedEffect, ...]:
    return tuple(PlacedEffect(effect.at(place, chain), place) for place in effect.places(chain))


@pytest.mark.parametrize(("name", "turning", "sliding"), [("track", 6, 1), ("gantry", 3, 3), ("scara", 3, 1)])
def test_completeness(name: str, turning: int, sliding: int) -> None:
    """4 r + 2 p and the target's three are all that a place can show, and nothing counts twice."""
    chain = chain_named(name)
    frames = (placed_frame("tracker", True), placed_frame(TARGET, False))
    robot = CompliantRobot(chain, (*frames, *on_every_joint(LinkGeometry(), chain)))
    data = observe(states_of(chain, 60, seed=4), chain)
    columns = free_columns(robot)
    names = [robot.placed[column.placed].parameter_name(column.symbol) for column in columns]
    matrix = np.concatenate([block.columns for block in evaluate(robot, data, columns)], axis=2)
    matrix = np.moveaxis(matrix, 0, -1).reshape(-1, len(columns))
    matrix /= np.linalg.norm(matrix, axis=0)
    complete = 4 * turning + 2 * sliding + 3
    singular = np.linalg.svd(matrix, compute_uv=False)
    assert int(np.sum(singular > 1e-6 * singular[0])) == complete
    conventions = redundant_geometry(robot, data, frozenset())
    assert len(names) - len(conventions) == complete
    kept = [k for k, own in enumerate(names) if own not in conventions]
    singular = np.linalg.svd(matrix[:, kept], compute_uv=False)
    assert singular[-1] > 1e-6 * singular[0]
    # zeros next to the whole geometry add nothing, a prismatic joint's neither
    more = CompliantRobot(chain, (*robot.placed, *on_every_joint(JointOffset(), chain)))
    offsets = {f"joint-offset.j{k}.zero" for k in range(1, chain.n_joints + 1)}
    assert offsets <= redundant_geometry(more, data, frozenset())


@pytest.mark.parametrize("convention", ["modified-dh", "dh"])
@pytest.mark.parametrize("name", ROBOTS)
def test_calibrated_rows_are_the_same_robot(name: str, convention: str) -> None:
    rng = np.random.default_rng(5)
    robot = robot_of(ROBOTS[name], convention)
    chain = chain_of(robot, Path())
    fixed = []
    for step in chain.fixed:
        error = transform(rotation_from_vector(1e-3 * rng.standard_normal(3)), 5e-4 * rng.standard_normal(3))
        fixed.append(step @ error)
    true = replace(chain, fixed=np.array(fixed))
    planned = planned_rows(robot, chain)
    for ends in (True, False):
        found = rows_of_chain(true, planned, first_held=ends, last_held=ends)
        rows = found.rows
        entries = [
            entry.model_copy(
                update={
                    "a_m": rows.a[k], "d_m": rows.d[k], "alpha_deg": np.degrees(rows.alpha[k]),
                    "theta_deg": np.degrees(rows.theta[k]), "beta_deg": np.degrees(rows.beta[k]),
                }
            )
            for k, entry in enumerate(robot.joints)
        ]  # fmt: skip
        again = chain_of(robot.model_copy(update={"joints": tuple(entries)}), Path())
        joints = draw_joints(chain, 5, seed=6)
        tip = Attachment(chain.n_joints + 1, np.eye(4))
        at, turn = attached_poses(true, true.model_angles(joints), tip)
        own, own_turn = attached_poses(again, again.model_angles(joints), Attachment(chain.n_joints + 1, rows.flange))
        np.testing.assert_allclose(own @ rows.base[:3, :3].T + rows.base[:3, 3], at, atol=1e-9)
        np.testing.assert_allclose(rows.base[:3, :3] @ own_turn, turn, atol=1e-9)
