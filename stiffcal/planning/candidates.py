"""Which poses are possible: joint limits, boxes that no link may enter, what the tracker can measure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, body_poses
from stiffcal.planning.capsules import keep_apart
from stiffcal.planning.sight import beam_is_free

# Poses that are drawn for each one wanted, at most: where fewer than one in so many is possible, few remain.
DRAWN_PER_POSE = 200
DRAWN_AT_ONCE = 2000
# Points on a link's axis are no further apart than this share of the capsule's radius.
SPACING = 0.5
MOST_POINTS = 200


@dataclass(frozen=True)
class Tracker:
    """What the tracker can measure."""

    position: Floats
    """(3,) base axes, m."""
    axis: Floats | None
    """(3,) base axes, the middle of its field of view; None: all directions."""
    cone: float
    """Half the opening angle of its field of view, rad."""
    reflector_axis: Floats | None
    """(3,) outward, in the measured frame; None: measured from all sides."""
    acceptance: float
    """Largest angle between beam and ``reflector_axis``, rad."""


@dataclass(frozen=True)
class Cell:
    """What limits poses."""

    limits: Floats
    """(L, 2) of the logged angles, rad; finite."""
    boxes: Floats
    """(B, 2, 3) lower and upper corners, base axes, m."""
    radius: float
    """Of the capsules around the links, m."""
    lowest: float | None
    """Height in base axes that no link goes below, m."""
    tracker: Tracker | None
    """None: everything can be measured."""


@dataclass(frozen=True)
class Rejected:
    """How many drawn poses were impossible, by the first reason."""

    drawn: int
    """All poses that were drawn."""
    collision: int
    """A link enters a box, goes too low, or meets another link."""
    out_of_view: int
    """The measured frame is outside of the tracker's field of view."""
    reflector: int
    """The reflector is turned away from the tracker."""
    obstructed: int
    """A link or a keep-out box is in the beam."""


def possible_poses(
    chain: Chain, cell: Cell, target: Attachment, tips: tuple[Attachment, ...], wanted: int, seed: int
) -> tuple[Floats, Rejected]:
    """Draw poses that are possible, evenly within the joint limits.

    Parameters
    ----------
    chain : the robot.
    cell : what limits poses.
    target : the measured frame.
    tips : frames on the flange that the last capsules reach to (target, load point).
    wanted : number of poses.
    seed : of the drawing.

    Returns
    -------
    joints : (n, L) logged angles, rad; n may be less than wanted, and 0.
    rejected : why others were not taken.
    """
    rng = np.random.default_rng(seed)
    taken: list[Floats] = []
    n_taken = drawn = collision = out_of_view = reflector = obstructed = 0
    low, high = cell.limits.T
    while n_taken < wanted and drawn < DRAWN_PER_POSE * wanted:
        joints = low + (high - low) * rng.random((min(DRAWN_AT_ONCE, DRAWN_PER_POSE * wanted), len(low)))
        drawn += len(joints)
        free = is_free(chain, cell, tips, joints)
        collision += int(np.count_nonzero(~free))
        joints = joints[free]
        if cell.tracker is not None and len(joints):
            viewed, accepted = can_measure(chain, cell.tracker, target, joints)
            out_of_view += int(np.count_nonzero(~viewed))
            reflector += int(np.count_nonzero(viewed & ~accepted))
            joints = joints[viewed & accepted]
            clear = has_line_of_sight(chain, cell, cell.tracker, target, tips, joints)
            obstructed += int(np.count_nonzero(~clear))
            joints = joints[clear]
        taken.append(joints)
        n_taken += len(joints)
    return np.concatenate(taken)[:wanted], Rejected(drawn, collision, out_of_view, reflector, obstructed)


@dataclass(frozen=True)
class Region:
    """A box, edges along the base axes."""

    low: Floats
    """(3,) its lower corner, m."""
    high: Floats
    """(3,) its upper corner, m."""


def poses_in_region(
    chain: Chain, cell: Cell, target: Attachment, tips: tuple[Attachment, ...], region: Region, wanted: int,
    drawn: int, seed: int,
) -> Floats:  # fmt: skip
    """Draw free poses whose target lies in a region; the tracker need not see them.

    Parameters
    ----------
    region : where the target is to be.
    wanted : number of poses; fewer where so many are not among those drawn.
    drawn : number of poses that are drawn.
    chain, cell, target, tips, seed : as in `possible_poses`.
    """
    low, high = cell.limits.T
    joints = low + (high - low) * np.random.default_rng(seed).random((drawn, len(low)))
    place, _ = attached_poses(chain, chain.model_angles(joints), target)
    joints = joints[((place >= region.low) & (place <= region.high)).all(axis=1)]
    return np.asarray(joints[is_free(chain, cell, tips, joints)][:wanted])


def near_poses(
    chain: Chain, cell: Cell, target: Attachment, tips: tuple[Attachment, ...], joints: Floats, spread: float,
    per_pose: int, seed: int,
) -> tuple[Floats, Integers]:  # fmt: skip
    """Draw possible poses around others.

    Parameters
    ----------
    joints : (n, L) logged angles of the others, rad.
    spread : standard deviation of each angle about them, rad.
    per_pose : how many are drawn about each; fewer are possible.
    chain, cell, target, tips, seed : as in `possible_poses`.

    Returns
    -------
    near : (m, L) logged angles, rad.
    source : (m,) which of the others each was drawn about.
    """
    rng = np.random.default_rng(seed)
    source = np.repeat(np.arange(len(joints)), per_pose)
    near = joints[source] + spread * rng.normal(size=(len(source), joints.shape[1]))
    near = np.clip(near, cell.limits[:, 0], cell.limits[:, 1])
    possible = is_free(chain, cell, tips, near)
    if cell.tracker is not None:
        viewed, accepted = can_measure(chain, cell.tracker, target, near)
        possible &= viewed & accepted & has_line_of_sight(chain, cell, cell.tracker, target, tips, near)
    return near[possible], source[possible]


def is_free(chain: Chain, cell: Cell, tips: tuple[Attachment, ...], joints: Floats) -> Booleans:
    """Return (n,) True where no link's capsule enters a box, goes too low, or meets that of another link.

    Conservative: a box is widened by the radius on all sides, so that corners count as filled. The first link, which
    turns on the base, is not checked against the lowest height, and no link against its neighbours
    (`planning.capsules`).
    """
    if not len(joints):
        return np.zeros(0, dtype=np.bool_)
    lines = link_lines(chain, tips, joints)
    starts, stops, bodies = zip(*lines, strict=True)
    ends = lines[1:]
    positions = body_poses(chain, chain.model_angles(joints[:1]))[0]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=1), axis=2)[0])])
    # tips all begin at the flange
    lengths = [float(along[min(body, len(along) - 1)]) for body in bodies]
    free = keep_apart(starts, stops, lengths, cell.radius)
    for start, end, body in ends:
        length = float(np.max(np.linalg.norm(end - start, axis=1), initial=0.0))
        n_points = min(MOST_POINTS, 2 + int(length / (SPACING * cell.radius)))
        share = np.linspace(0.0, 1.0, n_points)[None, :, None]
        points = start[:, None] + share * (end - start)[:, None]
        if cell.lowest is not None and body > 1:
            free &= (points[:, :, 2] - cell.radius >= cell.lowest).all(axis=1)
        for lower, upper in cell.boxes:
            inside = (points > lower - cell.radius) & (points < upper + cell.radius)
            free &= ~inside.all(axis=2).any(axis=1)
    return free


def link_lines(chain: Chain, tips: tuple[Attachment, ...], joints: Floats) -> list[tuple[Floats, Floats, int]]:
    """Return start and end (n, 3) of each capsule's line, m, base axes, and its body; that of the base comes first."""
    angles = chain.model_angles(joints)
    positions, _ = body_poses(chain, angles)
    lines = [(positions[:, k], positions[:, k + 1], k) for k in range(positions.shape[1] - 1)]
    return lines + [(positions[:, -1], attached_poses(chain, angles, tip)[0], chain.n_joints + 1) for tip in tips]


def has_line_of_sight(
    chain: Chain, cell: Cell, tracker: Tracker, target: Attachment, tips: tuple[Attachment, ...], joints: Floats
) -> Booleans:
    """Return (n,) True where neither a link nor a keep-out box is in the beam (`planning.sight`)."""
    place, _ = attached_poses(chain, chain.model_angles(joints), target)
    lines = [(start, end) for start, end, _ in link_lines(chain, tips, joints)]
    return beam_is_free(tracker.position, place, lines, cell.radius, cell.boxes)


def can_measure(chain: Chain, tracker: Tracker, target: Attachment, joints: Floats) -> tuple[Booleans, Booleans]:
    """Return (n,) whether the target is in the field of view, and (n,) whether the reflector faces the tracker."""
    place, rotation = attached_poses(chain, chain.model_angles(joints), target)
    beam = place - tracker.position
    beam = beam / np.linalg.norm(beam, axis=1, keepdims=True)
    viewed = np.ones(len(joints), dtype=np.bool_)
    if tracker.axis is not None:
        viewed = beam @ (tracker.axis / np.linalg.norm(tracker.axis)) >= np.cos(tracker.cone)
    accepted = np.ones(len(joints), dtype=np.bool_)
    if tracker.reflector_axis is not None:
        outward = rotation @ (tracker.reflector_axis / np.linalg.norm(tracker.reflector_axis))
        accepted = -np.einsum("ni,ni->n", outward, beam) >= np.cos(tracker.acceptance)
    return viewed, accepted
