"""Effects that the catalogue does not hold: whoever names one of its own effects for them is wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drives import drive_terms, drive_torque
from stiffcal.model.effect import (
    DocumentedEffect,
    Kind,
    NodeLoads,
    Observed,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
)


def _amplitude() -> ParameterSpec:
    return ParameterSpec("c", "1", "size", -np.inf, np.inf, 1e-9, "invented")


def _number(symbol: str, value: float) -> ParameterSpec:
    return ParameterSpec(symbol, "1", "shape", -np.inf, np.inf, value, "invented", ParameterRole.NONLINEAR)


class CrossStiffness(DocumentedEffect):
    """A joint's compliance follows the sine of a broken multiple of another joint's angle."""

    name = "cross-stiffness"
    kind = Kind.NODE_LAW
    place_kind = "pairs"
    summary = "outside"
    parameters = (_amplitude(), _number("order", 2.3), _number("phase", 0.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c sin(order q_a + phase) τ_b."""
        a, b = place.joints
        wave = np.sin(shape["order"] * loads.angles[a - 1] + shape["phase"])
        return (*drive_terms(chain, b, "c", wave * drive_torque(chain, loads.wrench, b)),)


class TorqueProduct(DocumentedEffect):
    """A joint is softer the more another one is loaded."""

    name = "torque-product"
    kind = Kind.NODE_LAW
    place_kind = "pairs"
    summary = "outside"
    parameters = (_amplitude(),)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c |τ_a| τ_b."""
        a, b = place.joints
        product = np.abs(drive_torque(chain, loads.wrench, a)) * drive_torque(chain, loads.wrench, b)
        return (*drive_terms(chain, b, "c", product),)


class QuadraticCross(DocumentedEffect):
    """A joint turns with the square of the torque on another."""

    name = "quadratic-cross"
    kind = Kind.NODE_LAW
    place_kind = "pairs"
    summary = "outside"
    parameters = (_amplitude(),)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c τ_a² at b, less what the weight alone makes."""
        a, b = place.joints
        return (*drive_terms(chain, b, "c", drive_torque(chain, loads.wrench, a) ** 2),)


class LooseBeyond(DocumentedEffect):
    """A joint is softer while another one stands beyond an angle."""

    name = "loose-beyond"
    kind = Kind.NODE_LAW
    place_kind = "pairs"
    summary = "outside"
    parameters = (_amplitude(), _number("angle", 0.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c τ_b where q_a lies beyond the angle."""
        a, b = place.joints
        beyond = loads.angles[a - 1] > shape["angle"]
        return (*drive_terms(chain, b, "c", beyond * drive_torque(chain, loads.wrench, b)),)


class Wander(DocumentedEffect):
    """The target wanders up and down, to and fro: a sum of waves with no rate in common."""

    name = "wander"
    kind = Kind.OBSERVATION
    place_kind = "setup"
    summary = "outside"
    parameters = (_amplitude(), _number("seed", 0.0))

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return a random walk per axis, one step per state."""
        rng = np.random.default_rng(round(shape["seed"]))
        column = np.zeros_like(observed.displacement)
        for axis in range(3):
            column[:, axis] = np.cumsum(rng.normal(size=8192))[observed.order.number]
        return {"c": column}


OUTSIDE = (CrossStiffness(), TorqueProduct(), QuadraticCross(), LooseBeyond(), Wander())
