"""Where a fit of spring and play begins: of a play that is given, all else but the band is linear in the torque.

A play that is crossed at no torque leaves the spring the angle beyond it. So for each place and width of a grid one
linear least squares says how well a cubic, friction and a zero follow the branches (variable projection: Golub and
Pereyra 1973). Friction that grows with the load, as in reducers, counts there with the angle in place of the load:
without it the branches lie apart by more than any play makes up for, and all places seem alike.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.clamped.loops.branches import Branches

# Places of the play's middle, over half the range of angles: nearer ones end in the same minimum.
_MIDDLES = np.linspace(-0.95, 0.95, 39)
# Widths, likewise.
_WIDTHS = np.array([0.02, *np.arange(0.1, 1.9, 0.1)])
# A place so near to another, in both, leads to where that leads.
_APART = 0.15
# Of the columns' length: keeps the equations of few readings solvable, far below what any reading shows.
_RIDGE = 1e-9
# Sizes of the spring's range, and of its torque over it, below which it has none.
_LEAST_RANGE = 1e-3


def play_starts(data: Branches, width: float | None, *, with_zero: bool, with_friction: bool) -> Floats:
    """Return (k, 8) middle, width, zero, friction, drag, and the slope at either end and between.

    Parameters
    ----------
    data : averaged branches, angle over half the range, from −1 to 1, and torque over the largest.
    width : of the play; None where it is free. with_zero, with_friction : what is free.
    """
    middle, play = (g.ravel() for g in np.meshgrid(_MIDDLES, _WIDTHS if width is None else np.array([width])))
    reached = (middle - 0.5 * play >= data.angle.min()) & (middle + 0.5 * play <= data.angle.max())
    if reached.any():
        middle, play = middle[reached], play[reached]
    away = data.angle - middle[:, None]
    x = away - np.clip(away, -0.5 * play[:, None], 0.5 * play[:, None])
    columns, none = [x, x**2, x**3], np.zeros_like(middle)
    if with_friction:
        sign = np.broadcast_to(np.where(data.up, 1.0, -1.0), x.shape)
        columns += [sign, sign * np.abs(x)]
    columns += [np.ones_like(x)] if with_zero else []
    values, left = _solved(columns, data.torque)
    friction, growth = values[:, 3:5].T if with_friction else (none, none)
    zero = values[:, -1] if with_zero else none
    low = np.minimum(data.angle.min() - middle + 0.5 * play, -_LEAST_RANGE)
    high = np.maximum(data.angle.max() - middle - 0.5 * play, _LEAST_RANGE)
    p1, p2, p3 = values[:, :3].T
    first, last = (p1 + end * (2.0 * p2 + 3.0 * p3 * end) for end in (low, high))
    between = first + (p2 + 3.0 * p3 * low) * (high - low)
    before, after = (end * (p1 + end * (p2 + end * p3)) for end in (low, high))
    drag = growth * (high - low) / np.maximum(after - before, _LEAST_RANGE)
    starts = np.stack([middle, play, zero, np.maximum(friction, 0.0), drag, first, between, last], axis=1)
    return starts[_apart(starts, np.argsort(left, kind="stable").tolist())]


def _solved(columns: Sequence[Floats], torque: Floats) -> tuple[Floats, Floats]:
    """Return (g, c) values of c columns, each (g, m), and (g,) the squares that they leave of the torque (m,)."""
    design = np.stack(columns, axis=2)
    size = np.maximum(np.linalg.norm(design, axis=1), 1e-300)
    unit = design / size[:, None]
    gram = unit.swapaxes(1, 2) @ unit
    right = np.einsum("gmc,m->gc", unit, torque)
    values = np.linalg.solve(gram + _RIDGE * np.eye(len(columns)), right[..., None])[..., 0]
    left = torque @ torque - np.sum(values * (2.0 * right - np.einsum("gcd,gd->gc", gram, values)), axis=1)
    return values / size, np.asarray(left)


def _apart(starts: Floats, order: Sequence[int]) -> list[int]:
    """Return those of an order that are not close to one before."""
    chosen: list[int] = []
    for k in order:
        if all(np.abs(starts[k, :2] - starts[other, :2]).max() > _APART for other in chosen):
            chosen.append(k)
    return chosen
