"""Each joint by itself: how its two links move against each other, over the wrench that it carries (paper 001).

With a target on every link the six-dimensional displacement of a joint is measured, not inferred: link k's motion since
the run's reference, relative to link k−1. In the joint's own axes, about the joint's origin, it answers the load's
wrench moved there (001, eq. 4): W_k = (R F, R (T + (p_load − p_k) × F)). Where the loaded robot holds its links is
measured too: sensor, load and joint go with the targets on their links, so that levers are those of the deformed robot.
Nothing of any model is in it but kinematics.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, body_poses
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.reduction.loads.cycles import run_members


@dataclass(frozen=True)
class JointMotion:
    """One joint in n states."""

    joint: int
    """From 1."""
    inboard: str
    """The inboard target's name; "" inboard of joint 1 where the base itself carries none."""
    outboard: str
    """The outboard target's name."""
    displacement: Floats
    """(n, 6) m and rad, joint axes, about the joint's origin, since the run's reference; NaN where one of the two
    bodies was not measured, or that which carries the force sensor.
    """
    wrench: Floats
    """(n, 6) N and N·m that the load puts on the joint, joint axes, about its origin."""
    std: Floats
    """(n, 6) how far each displacement is known, over what is usual: 1 but where poses come from points of which some
    were hidden.
    """
    run: Integers
    """(n,) run numbers."""
    index: Integers
    """(n,) index of the state in the campaign's load states."""


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
    used = np.flatnonzero(states.used & np.isfinite(states.wrench).all(axis=1))
    angles = _run_means(chain.model_angles(states.joints), states.run)[used]
    positions, rotations = body_poses(chain, angles)
    bodies = {pair[1]: _since_reference(states, used, pair[1]) for pair in pairs.values()}
    force, moment, point = _load(states, chain, used, angles, bodies)
    motions = []
    for joint, (inboard, outboard) in pairs.items():
        axes = rotations[:, joint]
        place = positions[:, joint] + chain.bearing[joint - 1] * axes[:, :, 2]
        base = bodies[inboard] if inboard >= 0 else _Motion.none(len(used))
        displacement = _relative(bodies[outboard], base, place, axes)
        carried_place, joint_axes = base.carried(place), base.turn @ axes
        wrench = np.stack([force, moment + np.cross(point - carried_place, force)], axis=1)
        wrench = np.einsum("nji,nkj->nki", joint_axes, wrench).reshape(-1, 6)
        finite = np.isfinite(wrench).all(axis=1, keepdims=True)  # not where the sensor's link was hidden
        names = states.setup.target_names
        motions.append(
            JointMotion(
                joint,
                "" if inboard < 0 else names[inboard],
                names[outboard],
                np.where(finite, displacement, np.nan),
                np.where(finite, wrench, 0.0),
                _relative_std(states, used, (inboard, outboard), place, axes),
                states.run[used],
                used,
            )
        )
    return tuple(motions)


def _run_means(values: Floats, run: Integers) -> Floats:
    result = np.empty_like(values)
    for members in run_members(run):
        result[members] = values[members].mean(axis=0)
    return result


@dataclass(frozen=True)
class _Motion:
    """A body's motion since its run's reference, base axes: x → turn (x − reference_position) + position.

    NaN where not measured.
    """

    turn: Floats  # (n, 3, 3)
    position: Floats  # (n, 3)
    reference_position: Floats  # (n, 3)

    @classmethod
    def none(cls, n: int) -> _Motion:
        return cls(np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3)), np.zeros((n, 3)))

    def carried(self, points: Floats) -> Floats:
        """Return the present positions (n, 3) of points fixed on the body."""
        return np.asarray(np.einsum("nij,nj->ni", self.turn, points - self.reference_position) + self.position)

    def measured_from(self, points: Floats) -> Floats:
        """Return the reference positions (n, 3) of points that are on the body now."""
        return np.asarray(np.einsum("nji,nj->ni", self.turn, points - self.position) + self.reference_position)


def _since_reference(states: LoadStates, kept: Integers, body: int) -> _Motion:
    """Return the motion of a target since its run's marked reference, or the least load where it was hidden in that."""
    n = len(kept)
    motion = _Motion(np.full((n, 3, 3), np.nan), np.full((n, 3), np.nan), np.full((n, 3), np.nan))
    measured = np.isfinite(states.rotation[kept, body, 0, 0])
    load = np.sqrt(np.sum(np.nan_to_num(states.wrench) ** 2, axis=1))
    for members in run_members(states.run[kept]):
        mine = members[measured[members]]
        if not len(mine):
            continue
        start = kept[mine[np.argmin(np.where(states.reference[kept[mine]], -1.0, load[kept[mine]]))]]
        motion.turn[mine] = states.rotation[kept[mine], body] @ states.rotation[start, body].T
        motion.position[mine], motion.reference_position[mine] = (
            states.position[kept[mine], body],
            states.position[start, body],
        )
    return motion


def _load(
    states: LoadStates, chain: Chain, kept: Integers, angles: Floats, bodies: Mapping[int, _Motion]
) -> tuple[Floats, Floats, Floats]:
    """Return force, moment and the point that the moment is about, (n, 3) each, base axes, on the robot as it gives."""
    carriers: dict[int, _Motion] = {}
    for number, motion in bodies.items():
        carriers.setdefault(states.setup.targets[number].body, motion)
    last, flange = chain.n_joints, chain.n_joints + 1
    for start, end in ((last, flange), (flange, last)):
        if start in carriers:
            carriers.setdefault(end, carriers[start])
    no_motion = _Motion.none(len(kept))
    setup = states.setup
    _, axes = attached_poses(chain, angles, setup.wrench_axes)
    point, _ = attached_poses(chain, angles, setup.wrench_point)
    axes = carriers.get(setup.wrench_axes.body, no_motion).turn @ axes
    point = carriers.get(setup.wrench_point.body, no_motion).carried(point)
    force, moment = (
        np.einsum("nij,nj->ni", axes, states.wrench[kept, component]) for component in (slice(3), slice(3, 6))
    )
    return force, moment, point


def _relative(outboard: _Motion, inboard: _Motion, place: Floats, axes: Floats) -> Floats:
    """Return (n, 6) how the outboard body has moved since the reference, relative to the inboard one.

    Parameters
    ----------
    place : (n, 3) the joint's origin, base axes, m.
    axes : (n, 3, 3) base_from_joint.
    """
    shifted = inboard.measured_from(outboard.carried(place)) - place
    turn = np.swapaxes(inboard.turn, 1, 2) @ outboard.turn
    shift = np.einsum("nji,nj->ni", axes, shifted)
    return np.concatenate([shift, np.einsum("nji,nj->ni", axes, vector_from_rotation(turn))], axis=1)


def _relative_std(states: LoadStates, kept: Integers, pair: tuple[int, int], place: Floats, axes: Floats) -> Floats:
    """Return (n, 6) how far displacements are known over what is usual; 1 where not both poses come from points.

    Parameters
    ----------
    pair : targets inboard and outboard, −1 for the base.
    place, axes : as in `_relative`.
    """
    n = len(kept)
    variance = np.zeros((n, 6))
    for body in pair:
        if body < 0:
            continue
        markers = states.setup.markers[body] if states.setup.markers else None
        if markers is None:
            return np.ones((n, 6))
        measured = states.markers_measured[kept, body, : len(markers.names)]
        pose = markers.covariance(measured, states.rotation[kept, body])
        # the joint's origin goes with the body: its place errs with the turn too
        lever = np.cross(np.eye(3)[None], (place - states.position[kept, body])[:, None, :])
        rows = np.concatenate([np.eye(3) * np.ones((n, 1, 1)), np.swapaxes(lever, 1, 2)], axis=2)
        joint_from_base = np.swapaxes(axes, 1, 2)
        variance[:, :3] += np.einsum("nij,njk,nik->ni", joint_from_base @ rows, pose, joint_from_base @ rows)
        variance[:, 3:] += np.einsum("nij,njk,nik->ni", joint_from_base, pose[:, 3:, 3:], joint_from_base)
    middle = np.nanmedian(variance, axis=0)
    return np.sqrt(np.where(np.isfinite(variance), variance, middle) / middle)
