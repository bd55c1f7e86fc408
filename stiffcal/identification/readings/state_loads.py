"""What each load state carries: the load since the reference, the branch of its cycle, the torque of every joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.reduction.loads.cycles import LOADING, PEAK, UNLOADING, LoadCycles, find_load_cycles

BRANCH, LOAD, TORQUE = "branch", "load_N", "tau_{}_Nm"


def force_in_base(states: LoadStates, chain: Chain) -> Floats:
    """Return (n, 3) N: the force on the robot in base axes, as read."""
    _, rotation = attached_poses(chain, chain.model_angles(states.joints), states.setup.wrench_axes)
    return np.asarray(np.einsum("nij,nj->ni", rotation, np.nan_to_num(states.wrench[:, :3])))


def force_since_reference(states: LoadStates, chain: Chain) -> Floats:
    """Return (n, 3) N: the force on the robot less that of its run's reference, base axes; in absolute rows all."""
    force = force_in_base(states, chain)
    for members in members_of(states.run):
        # a row of absolute places has no reference but itself
        chosen = members[states.reference[members] & ~states.absolute[members]]
        if chosen.size and not states.deflection_given:
            force[members] -= force[chosen][0]
    return force


def branch_words(cycles: LoadCycles) -> NDArray[np.str_]:
    """Return (n,) "loading", "unloading", or "": unloaded, or all of them where the load only rises."""
    # A single state a run is on no branch: there is nothing that it was loaded from.
    words = np.full(len(cycles.branch), "", dtype="<U9")
    if np.any(cycles.branch == UNLOADING):
        words[np.isin(cycles.branch, (LOADING, PEAK))] = "loading"
        words[cycles.branch == UNLOADING] = "unloading"
    return words


def torques_about_joints(states: LoadStates, robot: CompliantRobot) -> Floats:
    """Return (n, J) N·m: the whole torque about each joint's axis, weight included, of a robot with values."""
    from stiffcal.model.balance.equilibrium import solve_balance

    wrench = np.nan_to_num(states.wrench)
    return solve_balance(robot, robot.chain.model_angles(states.joints), wrench, states.setup).joint_torque


def load_columns(states: LoadStates, robot: CompliantRobot) -> Mapping[str, NDArray[Any]]:
    """Return the loads of every state as columns of a table: ``branch``, ``load_N``, ``tau_1_Nm``, ``tau_2_Nm``, ….

    Parameters
    ----------
    states : all load states of the campaign, n of them.
    robot : with values.
    """
    torque = torques_about_joints(states, robot)
    return {
        BRANCH: branch_words(find_load_cycles(states)),
        LOAD: np.linalg.norm(force_since_reference(states, robot.chain), axis=1),
        **{TORQUE.format(joint + 1): torque[:, joint] for joint in range(torque.shape[1])},
    }
