"""Each joint by itself: how its two links move against each other, over the wrench that it carries (paper 001).

With a target on every link the six-dimensional displacement of a joint is measured, not inferred: link k's motion since
the run's reference, seen from link k−1. In the joint's own axes, about the joint's origin, it answers the load's
wrench moved there (001, eq. 4): W_k = (R F, R (T + (p_load − p_k) × F)). Nothing of any model is in it but kinematics,
on the undeformed chain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import body_poses
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.effect import Inputs, joint_node
from stiffcal.model.shape import chain_shape, node_wrenches
from stiffcal.reduction.load_cycles import run_members

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class JointMotion:
    """One joint in n states.

    Attributes
    ----------
    joint : from 1.
    inboard, outboard : the two targets' names; "" inboard of joint 1 where the base itself carries none.
    displacement : (n, 6) m and rad, joint axes, about the joint's origin, since the run's reference; NaN where one of
        the two bodies was not seen.
    wrench : (n, 6) N and N·m that the load puts on the joint, joint axes, about its origin.
    run : (n,) run numbers.
    index : (n,) index of the state in the campaign's load states.
    """

    joint: int
    inboard: str
    outboard: str
    displacement: Floats
    wrench: Floats
    run: Integers
    index: Integers


def measured_joints(states: LoadStates, chain: Chain) -> dict[int, tuple[int, int]]:
    """Return joint to the targets (inboard, outboard) on either side; −1 stands for the base, which does not move.

    Only joints whose two links both carry a target with orientation can be looked at by themselves.
    """
    bodies: dict[int, int] = {}
    for number, target in enumerate(states.setup.targets):
        if np.isfinite(states.rotation[:, number]).any():
            bodies.setdefault(target.body, number)
    # What rides on the flange rides on the last link, as far as joints go.
    if chain.n_joints not in bodies and chain.n_joints + 1 in bodies:
        bodies[chain.n_joints] = bodies[chain.n_joints + 1]
    bodies.setdefault(0, -1)
    return {k: (bodies[k - 1], bodies[k]) for k in range(1, chain.n_joints + 1) if k in bodies and k - 1 in bodies}


def joint_motions(states: LoadStates, chain: Chain) -> tuple[JointMotion, ...]:
    """Return the joints that can be looked at by themselves, in order; none where one body alone is tracked.

    Parameters
    ----------
    states : load states; those set aside are left out.
    """
    pairs = measured_joints(states, chain)
    if states.deflection_given or len({body for pair in pairs.values() for body in pair} - {-1}) < 2:
        return ()
    kept = np.flatnonzero(states.used & np.isfinite(states.wrench).all(axis=1))
    angles = _run_means(chain.model_angles(states.joints), states.run)[kept]
    positions, rotations = body_poses(chain, angles)
    wrench = _joint_wrenches(states, chain, kept, angles)
    found = []
    for joint, (inboard, outboard) in pairs.items():
        place = positions[:, joint] + chain.bearing[joint - 1] * rotations[:, joint, :, 2]
        moved = _relative(states, kept, inboard, outboard, place, rotations[:, joint])
        names = states.setup.target_names
        found.append(
            JointMotion(
                joint,
                "" if inboard < 0 else names[inboard],
                names[outboard],
                moved,
                wrench[:, :, joint - 1],
                states.run[kept],
                kept,
            )
        )
    return tuple(found)


def _run_means(values: Floats, run: Integers) -> Floats:
    result = np.empty_like(values)
    for members in run_members(run):
        result[members] = values[members].mean(axis=0)
    return result


def _joint_wrenches(states: LoadStates, chain: Chain, kept: Integers, angles: Floats) -> Floats:
    """Return (n, 6, J) what the load alone puts on the joints, weight left out (001, eq. 4)."""
    inputs = Inputs(np.ascontiguousarray(angles.T), np.ascontiguousarray(states.wrench[kept].T), states.setup)
    shape = chain_shape(chain, inputs.angles, None)
    nodes = node_wrenches(chain, shape, inputs, forces=inputs.wrench)
    return np.stack([nodes[joint_node(k)].T for k in range(1, chain.n_joints + 1)], axis=2)


def _relative(states: LoadStates, kept: Integers, inboard: int, outboard: int, place: Floats, axes: Floats) -> Floats:
    """Return (n, 6) how the outboard body has moved since the reference, seen from the inboard one.

    Parameters
    ----------
    place : (n, 3) the joint's origin, base axes, m. axes : (n, 3, 3) base_from_joint.
    """
    result = np.full((len(kept), 6), np.nan)
    both = np.isfinite(states.rotation[:, outboard, 0, 0])
    if inboard >= 0:
        both &= np.isfinite(states.rotation[:, inboard, 0, 0])
    load = np.sqrt(np.sum(np.nan_to_num(states.wrench) ** 2, axis=1))
    for members in run_members(states.run[kept]):
        mine = members[both[kept[members]]]
        if not len(mine):
            continue
        # the marked reference, or the least load where a body was hidden in it
        start = kept[mine[np.argmin(np.where(states.reference[kept[mine]], -1.0, load[kept[mine]]))]]
        seen = kept[mine]
        moved = place[mine]
        turn = np.broadcast_to(np.eye(3), (len(mine), 3, 3))
        for body, inverse in ((outboard, False), (inboard, True)):
            if body < 0:
                continue
            rotation = states.rotation[seen, body] @ states.rotation[start, body].T
            here, there = states.position[seen, body], states.position[start, body]
            if inverse:
                moved = np.einsum("nji,nj->ni", rotation, moved - here) + there
                turn = np.swapaxes(rotation, 1, 2) @ turn
            else:
                moved = np.einsum("nij,nj->ni", rotation, moved - there) + here
                turn = rotation @ turn
        result[mine, :3] = np.einsum("nji,nj->ni", axes[mine], moved - place[mine])
        result[mine, 3:] = np.einsum("nji,nj->ni", axes[mine], vector_from_rotation(turn))
    return result
