"""Practice campaigns of absolute places, made by a simulator that shares nothing with stiffcal, with their truth."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.errors import no_progress
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import identify_parameters
from stiffcal.ingest.reducing import reduce_campaign
from stiffcal.mechanics.kinematics import stacked_bodies
from stiffcal.mechanics.rotations import rotation_from_vector, transform
from stiffcal.model.campaign_effects import placed_robot
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import Inputs
from stiffcal.model.equilibrium import reported_targets

FOLDER = Path(__file__).resolve().parents[2] / "campaigns" / "absolute"
N_POSES = 1000


@cache
def fitted(name: str) -> tuple[Campaign, Fit]:
    campaign = load_campaign(FOLDER / name)
    states = reduce_campaign(campaign, no_progress).states
    return campaign, identify_parameters(states, placed_robot(campaign))


@cache
def truth(name: str) -> dict[str, Any]:
    entry: dict[str, Any]
    (entry,) = [entry for entry in json.loads((FOLDER / "truth.json").read_text()) if entry["folder"] == name]
    return entry


def along(x: float = 0.0, z: float = 0.0) -> Floats:
    return transform(np.eye(3), np.array([x, 0.0, z]))


def about(axis: int, angle: float) -> Floats:
    return transform(rotation_from_vector(angle * np.eye(3)[axis]), np.zeros(3))


def true_places(name: str, joints: Floats) -> Floats:
    """Return (n, 3) of the target on the true rigid robot: A = R_x(α) R_y(β) T_x(a) R_z(θ) T_z(d).

    A joint whose next axis is parallel has no error of d: the turn β takes its place.
    """
    true, robot = truth(name), tomllib.loads((FOLDER / name / "robot.toml").read_text())
    places = []
    for q in joints:
        frame = np.eye(4)
        for k, joint in enumerate(robot["joints"]):
            a, alpha, d, theta = true["geometry_errors_a_alpha_d_theta"][k]
            beta = true["parallel_axis_beta"]
            d = 0.0 if any(beta[k + 1 : k + 2]) else d
            frame = frame @ about(0, np.radians(joint["alpha_deg"]) + alpha) @ about(1, beta[k])
            frame = frame @ along(x=joint["a_m"] + a) @ about(2, q[k] + np.radians(joint["theta_deg"]) + theta)
            frame = frame @ along(z=joint["d_m"] + d)
        frame = frame @ transform(np.eye(3), np.array(robot["flange"]["xyz_m"]))
        places.append((frame @ np.append(true["targets_in_flange"][0], 1.0))[:3])
    return np.array(places)


def fitted_places(fit: Fit, robot: CompliantRobot, angles: Floats) -> Floats:
    """Return (n, 3) of the target on the fitted rigid robot, as the tracker reports it."""
    inputs = Inputs(angles, np.zeros((6, angles.shape[1])), fit.data.setup)
    for placed in robot.placed:
        inputs = placed.effect.adjusted(placed.place, inputs, placed.values)
    return reported_targets(stacked_bodies(robot.adjusted_chain, inputs.angles), inputs.setup)[0].position.T


def test_nothing_but_noise_is_left() -> None:
    _, fit = fitted("01")
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=0.15)
    assert fit.last_step is None


def test_springs_are_within_their_joint_covariance() -> None:
    _, fit = fitted("01")
    chosen = [k for k, name in enumerate(fit.free_names) if name.startswith("joint-compliance")]
    joints = [int(fit.free_names[k].split(".")[1][1:]) for k in chosen]
    assert joints == [2, 3, 4, 5]  # weight turns neither joint 1 nor joint 6
    true = 1.0 / np.array(truth("01")["joint_stiffness"])[np.array(joints) - 1]
    values = fit.robot.values()
    away = np.array([values[fit.free_names[k]] for k in chosen]) - true
    assert float(away @ np.linalg.solve(fit.covariance[np.ix_(chosen, chosen)], away)) < 13.3  # 99 % of χ² with 4


def test_the_rigid_robot_is_the_true_one_but_for_a_rigid_motion() -> None:
    """Gauge-free: places at 1000 poses after the best rigid alignment, against what the covariance predicts."""
    campaign, fit = fitted("01")
    limits = campaign.chain.limits
    joints = np.random.default_rng(3).uniform(limits[:, 0], limits[:, 1], (N_POSES, len(limits)))
    angles = campaign.chain.model_angles(joints).T
    true, found = true_places("01", joints), fitted_places(fit, fit.robot, angles)
    left, _, right = np.linalg.svd((found - found.mean(axis=0)).T @ (true - true.mean(axis=0)))
    away = (found - found.mean(axis=0)) @ (left @ right) - (true - true.mean(axis=0))
    rms = float(np.sqrt(np.mean(np.sum(away**2, axis=1))))

    chosen = [k for k, name in enumerate(fit.free_names) if not name.startswith("joint-compliance")]
    values, step = fit.robot.values(), 1e-6
    columns = []
    for k in chosen:
        name = fit.free_names[k]
        moved = fitted_places(fit, fit.robot.with_values({name: values[name] + step}), angles)
        columns.append((moved - found).ravel() / step)
    rigid = [
        np.tile(np.eye(3), (N_POSES, 1)),
        np.swapaxes(np.cross(np.eye(3)[None], found[:, None]), 1, 2).reshape(-1, 3),
    ]
    basis, _ = np.linalg.qr(np.concatenate(rigid, axis=1))
    spread = np.array(columns).T
    spread -= basis @ (basis.T @ spread)
    predicted = np.sqrt(np.einsum("ki,ij,kj->", spread, fit.covariance[np.ix_(chosen, chosen)], spread) / N_POSES)
    assert rms <= 1.5 * predicted


@pytest.mark.parametrize("name", ["02", "03", "04", "05", "06", "07"])
def test_what_is_hidden_leaves_more_than_noise(name: str) -> None:
    _, fit = fitted(name)
    assert fit.reduced_chi2 is not None
    # the effect's size is ``snr`` times the noise, what a model with springs of either sign absorbs taken out
    assert fit.reduced_chi2 > 1.0 + 0.7 * truth(name)["snr"] ** 2
