"""Whether the straight line from a tracker to the measured frame is free of links and boxes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.planning.capsules import distance_of_lines

# A link is no thicker than the target is away from its axis, less this share: a beam that comes no nearer to the axis
# than its own target passes.
THINNER = 0.9


def beam_is_free(
    tracker: Floats, target: Floats, lines: Sequence[tuple[Floats, Floats]], radius: float, boxes: Floats
) -> Booleans:
    """Return (n,) True where no capsule and no box is in the beam.

    A target that lies within the radius of a link's axis sits on that link, or is mounted close to it: there the link
    is taken as thinner than the distance of the target, so that a beam through its axis is blocked and one that comes
    from the target's own side is not. The beam is a line without width. A box that the tracker stands in keeps the
    robot away from it and hides nothing.

    Parameters
    ----------
    tracker : (3,) base axes, m.
    target : (n, 3) the measured frame, base axes, m.
    lines : start and end of each capsule's line, (n, 3) each, base axes, m.
    radius : of the capsules, m.
    boxes : (B, 2, 3) lower and upper corners, base axes, m.
    """
    tracker_of_each = np.broadcast_to(tracker, target.shape)
    free = np.ones(len(target), dtype=np.bool_)
    for start, end in lines:
        own = distance_of_lines(start, end, target, target)
        thickness = np.minimum(radius, THINNER * own)
        free &= ~(distance_of_lines(start, end, tracker_of_each, target) < thickness)
    for lower, upper in boxes:
        if not ((tracker >= lower) & (tracker <= upper)).all():
            free &= ~_passes_box(tracker, target, lower, upper)
    return free


def _passes_box(tracker: Floats, target: Floats, lower: Floats, upper: Floats) -> Booleans:
    """Return (n,) whether the lines pass a box: the intervals in which they lie between its planes have a common part.

    T. L. Kay, J. T. Kajiya, "Ray tracing complex scenes", Computer Graphics 20, 1986.
    """
    along = target - tracker
    parallel = along == 0.0
    safe = np.where(parallel, 1.0, along)
    one, other = (lower - tracker) / safe, (upper - tracker) / safe
    inside = (tracker >= lower) & (tracker <= upper)
    enters = np.where(parallel, np.where(inside, -np.inf, np.inf), np.minimum(one, other))
    leaves = np.where(parallel, np.where(inside, np.inf, -np.inf), np.maximum(one, other))
    return np.asarray(np.maximum(enters.max(axis=1), 0.0) <= np.minimum(leaves.min(axis=1), 1.0))
