"""Effects that the catalogue does not hold: one of its own effects that is named for them is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Instrument,
    Law,
    NodeLoads,
    Observed,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.laws.drives import drive_terms, drive_torque


def amplitude() -> ParameterSpec:
    """Return the size of an invented law."""
    return ParameterSpec("c", "1", "size", -np.inf, np.inf, 1e-9, "invented")


def number(symbol: str, value: float) -> ParameterSpec:
    """Return a parameter of an invented law's shape."""
    return ParameterSpec(symbol, "1", "shape", -np.inf, np.inf, value, "invented", ParameterRole.NONLINEAR)


class InventedLaw(Law):
    """A law of how the robot is loaded, of one size, that the catalogue does not hold."""

    summary = "outside"
    parameters: ClassVar[tuple[ParameterSpec, ...]] = (amplitude(),)


class CrossStiffness(InventedLaw):
    """A joint's compliance follows the sine of a broken multiple of another joint's angle."""

    name = "cross-stiffness"
    place_kind = "pairs"
    parameters = (amplitude(), number("order", 2.3), number("phase", 0.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c sin(order q_a + phase) τ_b."""
        a, b = place.joints
        wave = np.sin(shape["order"] * loads.angles[a - 1] + shape["phase"])
        return (*drive_terms(chain, b, "c", wave * drive_torque(chain, loads.wrench, b)),)


class TorqueProduct(InventedLaw):
    """A joint is softer the more another one is loaded."""

    name = "torque-product"
    place_kind = "pairs"

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c |τ_a| τ_b."""
        a, b = place.joints
        product = np.abs(drive_torque(chain, loads.wrench, a)) * drive_torque(chain, loads.wrench, b)
        return (*drive_terms(chain, b, "c", product),)


class QuadraticCross(InventedLaw):
    """A joint turns with the square of the torque on another."""

    name = "quadratic-cross"
    place_kind = "pairs"

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c τ_a² at b, less what the weight alone makes."""
        a, b = place.joints
        return (*drive_terms(chain, b, "c", drive_torque(chain, loads.wrench, a) ** 2),)


class LooseBeyond(InventedLaw):
    """A joint is softer while another one stands beyond an angle."""

    name = "loose-beyond"
    place_kind = "pairs"
    parameters = (amplitude(), number("angle", 0.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c τ_b where q_a lies beyond the angle."""
        a, b = place.joints
        beyond = loads.angles[a - 1] > shape["angle"]
        return (*drive_terms(chain, b, "c", beyond * drive_torque(chain, loads.wrench, b)),)


class Wander(Instrument):
    """The target wanders up and down, to and fro: a sum of waves with no rate in common."""

    name = "wander"
    place_kind = "setup"
    summary = "outside"
    parameters = (amplitude(), number("seed", 0.0))

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return a random walk per axis, one step per state."""
        rng = np.random.default_rng(round(shape["seed"]))
        column = np.zeros_like(observed.displacement)
        for axis in range(3):
            column[:, axis] = np.cumsum(rng.normal(size=8192))[observed.order.number]
        return {"c": column}


OUTSIDE = (CrossStiffness(), TorqueProduct(), QuadraticCross(), LooseBeyond(), Wander())
