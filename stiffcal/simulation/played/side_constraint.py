"""Tools that their work holds across the load: a drill in its hole is pushed back where the robot gives way."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.simulation.played.places import Places
from stiffcal.simulation.played.secant import SecantSteps
from stiffcal.wording import significant

# Settled: the side force is the guide's to a millionth of the run's largest load, or to what the guide makes of a
# nanometre, which is where balances and engines of others end.
SETTLED, SETTLED_M = 1e-6, 1e-9
# A smooth robot takes six steps, one with play, friction and creep a dozen.
MOST_STEPS = 100
# Loads below this share of the run's largest say nothing of the compliance: what moves there is rounding or play.
_SIGNIFICANT_LOAD = 1e-3


class SideConstraintError(ArithmeticError):
    """No side force is found at which guide and robot agree.

    Attributes
    ----------
    run : number of the first such run, from 0.
    left_N : by how much the side force still is not the guide's, N.
    """

    def __init__(self, run: int, left_N: float) -> None:
        super().__init__(
            f"the side force of the guide does not converge: {significant(left_N, 2)} N remain after {MOST_STEPS} steps"
        )
        self.run, self.left_N = run, left_N


def balance_with_side_constraint(
    wrench: Floats, stiffness: Floats, sizes: Sequence[int], point: int, solve: Callable[[Floats], Places]
) -> tuple[Places, Floats]:
    """Find where a robot with a guided tool comes to rest, and what acts on it there.

    The side force is −k u, u the load point's displacement across the run's load since its start. It is the root of
    s + k u(s), found by secant steps that start from the run's own compliance.

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

    Raises
    ------
    SideConstraintError : the side force does not settle to `SETTLED`.
    """
    places = solve(wrench)
    if not stiffness.any():
        return places, wrench
    runs = [slice(end - size, end) for size, end in zip(sizes, np.cumsum(sizes), strict=True)]
    along, largest = _largest_load_directions(wrench, runs)
    enough = np.maximum(SETTLED * largest, SETTLED_M * stiffness)
    gives = _compliances(wrench, places.displacement[:, point, :3], runs)
    steps = SecantSteps(1.0 + stiffness * gives, 3)
    side, acting = np.zeros((len(wrench), 3)), wrench
    size = np.zeros(len(wrench))
    for _ in range(MOST_STEPS):
        translation = places.position[:, point].copy()
        for run in runs:
            translation[run] -= translation[run][0].copy()
        across = translation - along * np.sum(along * translation, axis=1, keepdims=True)
        left = -stiffness[:, None] * across - side
        size = np.linalg.norm(left, axis=1)
        if np.all(size <= enough):
            return places, acting
        side = steps.step(side, left)
        acting = wrench.copy()
        acting[:, :3] += side
        places = solve(acting)
    first = int(np.argmax(~(size <= enough)))
    raise SideConstraintError(int(np.searchsorted(np.cumsum(sizes), first, side="right")), float(size[first]))


def _largest_load_directions(wrench: Floats, runs: Sequence[slice]) -> tuple[Floats, Floats]:
    """Return (b, 3) the direction of the largest load of each balance's run, and (b,) its size, N.

    One row per balance: all balances of a run have their run's values.
    """
    along, size = np.zeros((len(wrench), 3)), np.zeros(len(wrench))
    for run in runs:
        force = wrench[run, :3]
        largest = force[int(np.argmax(np.linalg.norm(force, axis=1)))]
        size[run] = np.linalg.norm(largest)
        along[run] = largest / max(float(np.linalg.norm(largest)), 1e-12)
    return along, size


def _compliances(wrench: Floats, translation: Floats, runs: Sequence[slice]) -> Floats:
    """Return (b,) m/N: the most that a newton moves the load point in each run, by the load's own deflection.

    A controller's motion is none of it: ``translation`` (b, 3) is the deflection under the load alone, m.
    """
    gives = np.zeros(len(wrench))
    for run in runs:
        load, way = np.linalg.norm(wrench[run, :3], axis=1), np.linalg.norm(translation[run], axis=1)
        significant = load > _SIGNIFICANT_LOAD * load.max(initial=0.0)
        gives[run] = np.max(way[significant] / load[significant], initial=0.0)
    return gives
