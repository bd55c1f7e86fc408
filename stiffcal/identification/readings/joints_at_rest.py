"""Noise of the wrench of clamped runs, as far as the joints that were not driven show it.

While the flange is held and their motors stand still, the torques of the other joints cannot change by noise alone:
what Aᵀ ΔW is more than a share of the driven joint's torque, with the Jacobian's columns A of these joints, is the
sensor's. The most probable wrench is that much less of it (least squares with the constraint Aᵀ ΔW = β τ, Σ the
variances of the wrench's components: W − Σ A (Aᵀ Σ A)⁻¹ (Aᵀ ΔW − β τ)). Without it, a law whose regressor is another
combination of the wrench, a fixture's compliance above all, is named for holding less of the noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.clamped_inverse import RANK
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.held_frame import held_frame

# Mean squares of the other joints' torques above this multiple of the noise are more than noise: they are left alone.
NOISE_ONLY = 2.0
# Drives that turn with the driven one by less than this share of its motion stand still.
AT_REST = 0.01
# A sweep is cut into states until nothing bends beyond the noise of its readings: that leaves errors of this share of
# it, alike in every cycle (a play whose band is crossed within the noise came out 3 % too broad with less).
STATE_SHARE = 0.4
# With fewer states nothing is known of that.
LEAST_STATES = 20


def with_other_joints_at_rest(states: LoadStates, chain: Chain) -> LoadStates:
    """Return load states in which the wrenches of clamped runs hold no noise that turns joints that stood still.

    The driven joint's torque is then better known, and the uncertainty of the wrench is scaled to it.

    Parameters
    ----------
    states : n load states. chain : the robot. Runs whose torque was read from motor currents stay as they are, and so
        do those in which the other joints' torques follow more than the driven one's.
    """
    held = held_frame(chain, states)
    if held is None or chain.n_joints == 1 or not states.setup.moments_measured:
        return states
    wrench, sigma, drives = states.wrench.copy(), states.wrench_sigma.copy(), chain.drives_of_logged
    known = states.clamped & np.isfinite(sigma).all(axis=1) & np.isfinite(wrench).all(axis=1)
    for run in np.unique(states.run[known]):
        members = np.flatnonzero(known & (states.run == run))
        if states.runs[run].motor_torque or len(members) < LEAST_STATES:
            continue
        turn = states.joints[members] @ drives.T
        turn, driven = turn - turn.mean(axis=0), int(np.argmax(np.ptp(turn, axis=0)))
        # with the driven one: the noise of an encoder at rest is no motion
        share = np.abs(turn.T @ turn[:, driven]) / max(float(turn[:, driven] @ turn[:, driven]), np.finfo(float).tiny)
        angles = chain.model_angles(states.joints[members].mean(axis=0)[None])
        # of the wrench as read: axes of the sensor, about its point
        axes = attached_poses(chain, angles, states.setup.wrench_axes)[1][0]
        jacobian = held.jacobian[:, :, members[0]] @ np.linalg.inv(drives)
        jacobian = np.concatenate([axes.T @ jacobian[:3], axes.T @ jacobian[3:]])
        change = _noise_of(wrench[members].T, sigma[members].T, jacobian[:, share < AT_REST], jacobian[:, driven])
        if change is None:
            continue
        noise, remaining = change
        wrench[members] -= noise.T
        sigma[members] *= min(float(np.hypot(remaining, STATE_SHARE)), 1.0)
    return replace(states, wrench=wrench, wrench_sigma=sigma)


def _noise_of(wrench: Floats, sigma: Floats, at_rest: Floats, driven: Floats) -> tuple[Floats, float] | None:
    """Return the noise (6, n) of wrenches that drives at rest show, and by what the driven torque's uncertainty falls.

    Parameters
    ----------
    wrench, sigma : (6, n). at_rest : (6, k) the Jacobian's columns of drives at rest. driven : (6,) of the driven one.
    """
    size = np.sqrt(np.mean(sigma**2, axis=1))
    if not np.all(size > 0.0) or not at_rest.size:
        return None
    scatter = np.sqrt(np.mean((sigma / size[:, None]) ** 2, axis=0))
    left, values, _ = np.linalg.svd(at_rest * size[:, None], full_matrices=False)
    basis = left[:, values > RANK * values[0]]
    change, own = (wrench - wrench.mean(axis=1, keepdims=True)) / size[:, None], driven * size
    torque, turning = own @ change, basis.T @ change
    turning = turning - np.outer(turning @ torque, torque) / max(float(torque @ torque), np.finfo(float).tiny)
    if float(np.mean((turning / scatter) ** 2)) > NOISE_ONLY:
        return None
    remaining = own - basis @ (basis.T @ own)
    return size[:, None] * (basis @ turning), float(np.linalg.norm(remaining) / np.linalg.norm(own))
