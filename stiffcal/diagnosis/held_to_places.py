"""Set-up errors held against absolute places: a target elsewhere, or a turned tracker, shows in the reference states.

What is measured there is a place, not a displacement, so that a target that is 10 mm off is 10 mm off in every pose,
and a tracker turned by a degree misses by centimetres. Where the places do not show what was fitted to displacements,
another error stands behind it (physics, section 5.8).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Kind, Observed, StateOrder
from stiffcal.model.equilibrium import solve_balance

# Robots that were not calibrated miss by some tenths of a millimetre to a millimetre: less is no contradiction …
LEAST_WORSE_M = 1e-3
# … nor is what does not double the misfit.
LEAST_TIMES = 2.0


@dataclass(frozen=True)
class PlacesWith:
    """How absolute places agree with a set-up error, a shift of the tracker taken out."""

    without: float
    """m, rms misfit of the places without it."""
    misfit: float
    """m, rms misfit with it."""

    @property
    def contradicted(self) -> bool:
        """Whether the places speak against it."""
        return self.misfit > LEAST_TIMES * self.without and self.misfit - self.without > LEAST_WORSE_M


def held_to_places(states: LoadStates, robot: CompliantRobot, placed: PlacedEffect) -> PlacesWith | None:
    """Return how the reference states' places agree with an effect's values; None where they cannot show it.

    Parameters
    ----------
    states : the campaign's load states.
    robot : valued, with the effect.
    placed : the effect, one of the robot's.
    """
    if placed.effect.kind is not Kind.OBSERVATION or states.deflection_given or not states.setup.targets:
        return None
    chosen = np.flatnonzero(states.reference & states.used & np.isfinite(states.position[:, 0]).all(axis=1))
    if len(chosen) < 3:
        return None
    angles, still = robot.chain.model_angles(states.joints[chosen]), np.zeros((len(chosen), 6))
    bare = replace(robot, placed=tuple(other for other in robot.placed if other is not placed))
    expected, changed = (
        solve_balance(model, angles, still, states.setup).unloaded_position[:, 0] for model in (bare, robot)
    )
    changed = changed + _seen_shift(placed, expected)
    if np.abs(changed - expected).max() == 0.0:
        return None
    measured = states.position[chosen, 0]
    return PlacesWith(_misfit(measured - expected), _misfit(measured - changed))


def _seen_shift(placed: PlacedEffect, places: Floats) -> Floats:
    """Return (n, 3) what an observation law does to places, counted from their centre, as it does to displacements."""
    n = len(places)
    nothing = np.zeros(n)
    order = StateOrder(np.arange(n), nothing, nothing, np.zeros((0, n)), nothing, nothing)
    seen = np.zeros((1, 6, n))
    seen[0, :3] = (places - places.mean(axis=0)).T
    shift = placed.effect.observation_shift(placed.place, Observed(seen, order), placed.values)
    return np.zeros_like(places) if shift is None else np.asarray(shift[0, :3].T)


def _misfit(away: Floats) -> float:
    return float(np.sqrt(np.mean(np.sum((away - away.mean(axis=0)) ** 2, axis=1))))
