"""Tools that their work holds across the load: a drill in its hole is pushed back where the robot gives way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from stiffcal.simulation.play import Places

Floats = NDArray[np.float64]

# Such a guide is about as stiff as a robot: the side force then settles to a thousandth in a dozen steps.
_STEPS = 12


def settle_guided(
    wrench: Floats, stiffness: Floats, sizes: Sequence[int], point: int, solve: Callable[[Floats], Places]
) -> tuple[Places, Floats]:
    """Find where a robot with a guided tool comes to rest, and what acts on it there.

    The side force is −k u, u the load point's displacement across the run's load since its start; found by iteration,
    each step cut down by what the force itself would move.

    Parameters
    ----------
    wrench : (b, 6) what the program sets, N and N·m, base axes.
    stiffness : (b,) k of the guide, N/m; zero where none holds the tool.
    sizes : how many of the b balances belong to each run, in order.
    point : which of the places is the load point.
    solve : wrench to places.

    Returns
    -------
    Places, and (b, 6) what acts.
    """
    places = solve(wrench)
    if not stiffness.any():
        return places, wrench
    runs = [slice(end - size, end) for size, end in zip(sizes, np.cumsum(sizes), strict=True)]
    along = _directions(wrench, runs)
    side, acting = np.zeros((len(wrench), 3)), wrench
    for _ in range(_STEPS):
        moved = places.position[:, point].copy()
        for run in runs:
            moved[run] -= moved[run][0].copy()
        across = moved - along * np.sum(along * moved, axis=1, keepdims=True)
        # What a newton moves, by the load's own deflection: a controller's motion is none of it.
        load, given = (np.linalg.norm(one, axis=1) for one in (acting[:, :3], places.displacement[:, point, :3]))
        gives = float(np.max(given[load > 0.0] / load[load > 0.0], initial=0.0))
        side = side + (-stiffness[:, None] * across - side) / (1.0 + stiffness[:, None] * gives)
        acting = wrench.copy()
        acting[:, :3] += side
        places = solve(acting)
    return places, acting


def _directions(wrench: Floats, runs: Sequence[slice]) -> Floats:
    """Return (b, 3) the direction of each run's largest load."""
    along = np.zeros((len(wrench), 3))
    for run in runs:
        force = wrench[run, :3]
        largest = force[int(np.argmax(np.linalg.norm(force, axis=1)))]
        along[run] = largest / max(float(np.linalg.norm(largest)), 1e-12)
    return along
