"""How parameters of the geometry move the target in absolute runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.identification.readings import Observations
from stiffcal.mechanics.chain import Chain
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Term


def geometry_terms(placed: Sequence[PlacedEffect], chain: Chain, data: Observations) -> list[tuple[PlacedEffect, Term]]:
    """Return how the parameters of the geometry move the nodes outboard of them; nothing where displacements count.

    A displacement depends on the geometry by its square alone: both of its ends move with it.

    Parameters
    ----------
    placed : the effects; shape parameters have their values or typical ones.
    chain : as the robot file describes it.
    data : the observations.
    """
    if not data.absolute.any():
        return []
    return [
        (placed_effect, replace(term, value=np.where(data.absolute, term.value, 0.0)))
        for placed_effect in placed
        for term in placed_effect.effect.geometry_terms(placed_effect.place, chain, data.angles, placed_effect.shape())
    ]
