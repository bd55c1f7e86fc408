"""What a law gives as its own derivatives by shape parameters, against differences of the law."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.model.abilities import KnownSlopes
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Effect, EffectAtRest, NodeLoads, ParameterRole, Place
from stiffcal.model.forms import WholeForm
from tests.laboratory.effect_bench import order_of, robot_chain

EFFECTS = built_in_effects()
N = 41
# A central difference errs by a third derivative times the square of this share, and by rounding over it: 1e-10 each.
STEP = 1e-5
TOLERANCE = 1e-6


def carried() -> NodeLoads:
    """Return loads on every node that run through zero, each with a phase of its own, as states of one run in order."""
    rng = np.random.default_rng(4)
    size = rng.uniform(0.5, 1.0, (14, 6, 1)) * np.array([300.0] * 3 + [200.0] * 3)[None, :, None]
    phase = rng.uniform(0.0, 2.0 * np.pi, (14, 6, 1))
    wrench = size * np.sin(2.0 * np.pi * np.arange(N) / 20.0 + phase)
    order = order_of([0] * N, np.linspace(0.0, 120.0, N).tolist(), motor=1e-4 * rng.normal(size=(6, N)))
    return NodeLoads(wrench, rng.uniform(-1.0, 1.0, (6, N)), order, np.full_like(wrench, 0.3) * size)


def forms(effect: Effect) -> list[Effect]:
    """Return all forms of an effect."""
    return [*effect.forms] or [effect]


def values_of(effect: Effect, place: Place, loads: NodeLoads) -> dict[str, float]:
    """Return typical values; shapes from the grid of these loads; of a whole curve, one that bends by a fifth."""
    values = {spec.symbol: spec.typical for spec in effect.parameters}
    grids = effect.nonlinear_grid(place, robot_chain(), loads) if isinstance(effect, EffectAtRest) else {}
    for symbol, grid in grids.items():
        if len(grid):
            values[symbol] = float(grid[len(grid) // 2])
    if not all(values.values()):
        angle = np.linspace(-1e-3, 1e-3, 21)
        assert isinstance(effect, WholeForm)
        values |= effect.start(4e5 * angle + 2e7 * angle**2 + 4e10 * angle**3, angle)
    return values


def law(effect: Effect, place: Place, loads: NodeLoads, values: dict[str, float]) -> dict[tuple[int, int], Floats]:
    """Return the displacement by node and component."""
    total: dict[tuple[int, int], Floats] = {}
    for term in PlacedEffect(effect, place, values).terms(robot_chain(), loads):
        key = (term.node, term.component)
        amplitude = values[term.symbol] if term.symbol else 1.0
        total[key] = total.get(key, np.zeros(N)) + amplitude * term.value
    return total


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_slopes_are_those_of_the_law(name: str) -> None:
    loads = carried()
    for effect in forms(EFFECTS[name]):
        shapes = {spec.symbol for spec in effect.parameters if spec.role is ParameterRole.NONLINEAR}
        own = isinstance(effect, KnownSlopes)
        for place in effect.places(robot_chain()):
            values = values_of(effect, place, loads)
            slopes: dict[str, dict[tuple[int, int], Floats]] = {}
            for term in (
                effect.shape_slopes(place, robot_chain(), loads, values) if isinstance(effect, KnownSlopes) else ()
            ):
                entry = slopes.setdefault(term.symbol, {})
                key = (term.node, term.component)
                entry[key] = entry.get(key, np.zeros(N)) + term.value
            assert set(slopes) <= shapes
            assert bool(slopes) == own
            for symbol, entry in slopes.items():
                step = STEP * abs(values[symbol])
                low, high = (
                    law(effect, place, loads, values | {symbol: values[symbol] + way * step}) for way in (-1.0, 1.0)
                )
                assert set(entry) == set(low)
                for key, slope in entry.items():
                    exact = (high[key] - low[key]) / (2.0 * step)
                    assert np.abs(exact).max() > 0.0
                    np.testing.assert_allclose(slope, exact, rtol=0.0, atol=TOLERANCE * np.abs(exact).max())


def test_some_laws_give_slopes_of_their_own() -> None:
    """Else the comparison above would compare nothing."""
    with_slopes = {
        name for name, effect in EFFECTS.items() if any(isinstance(form, KnownSlopes) for form in forms(effect))
    }
    assert with_slopes >= {"backlash", "cubic-stiffness"}
