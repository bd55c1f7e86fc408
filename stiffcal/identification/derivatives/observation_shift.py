"""What effects of the measurement add to the targets' displacements."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.readings.observations import Observations
from stiffcal.model.abilities import FiniteShift
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Observed

# Of a parameter's own size: the difference of both sides errs by the square of it.
STEP = 1e-3


def observation_shift(model: CompliantRobot, data: Observations, displacement: Floats) -> Floats:
    """Return (B, 6, n) by how much the targets' displacements (B, 6, n) are read otherwise, m and rad, base axes."""
    shift = np.zeros_like(displacement)
    observed = Observed(displacement, data.order, data.layout.held)
    for placed_effect in model.acting:
        added = placed_effect.observation_shift(observed)
        if added is not None:
            shift += added
    return shift


def observation_slopes(placed: PlacedEffect, data: Observations, displacement: Floats) -> dict[str, Floats]:
    """Return symbol to (B, 6, n) how the readings of the targets' displacements follow an effect's parameters."""
    observed = Observed(displacement, data.order, data.layout.held)
    columns = placed.observation_columns(observed)
    if not isinstance(placed.effect, FiniteShift):
        return columns
    slopes = {}
    for symbol in columns:
        spec = placed.effect.spec(symbol)
        value, step = placed.values.get(symbol, spec.neutral), STEP * spec.size
        low, high = (
            placed.effect.observation_shift(placed.place, observed, {**placed.values, symbol: value + sign * step})
            for sign in (-1.0, 1.0)
        )
        slopes[symbol] = (high - low) / (2.0 * step * spec.amplitude_of(1.0))
    return slopes


def shift_slopes(model: CompliantRobot, data: Observations, displacement: Floats) -> Floats | None:
    """Return (B, 6, 6, n) how a target's shift (2nd axis) follows its displacement (3rd); None where none does."""
    step = float(np.abs(displacement).max(initial=0.0))
    before = observation_shift(model, data, displacement)
    if not (step > 0.0 and before.any()):
        return None
    slopes = np.zeros((len(displacement), 6, 6, displacement.shape[-1]))
    for component in range(6):
        changed = displacement.copy()
        changed[:, component] += step
        slopes[:, :, component] = (observation_shift(model, data, changed) - before) / step
    return slopes if slopes.any() else None
