"""How much of the measured frame's deflection each effect of the model makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import TRANSLATION
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect


@dataclass(frozen=True)
class DeflectionShare:
    """The part of the deflection that is due to one effect at one place."""

    placed: PlacedEffect
    """Effect and place."""
    share: float
    """Of the squares of all predicted translations: part · whole / whole · whole. The shares of all effects add up to 1
    to first order; one that acts against the others has a negative share.
    """


def deflection_shares(robot: CompliantRobot, data: Observations) -> list[DeflectionShare]:
    """Return the share of each effect in the predicted translations of the targets, in the model's order.

    Parameters
    ----------
    robot : the fitted model.
    data : the observations, n states.

    Returns
    -------
    list of DeflectionShare
        Empty where no translation is predicted.
    """
    state = Linearised.about(robot, data)
    rows = data.layout.kind == TRANSLATION
    whole = np.where(data.measured_mask[rows], state.predicted[rows], 0.0)
    total = float(np.sum(whole**2))
    if total <= 0.0:
        return []
    shares = []
    for placed in robot.placed:
        regressor = state.regressor(placed.effect, placed.place, placed.shape())
        amplitudes = [placed.amplitude(symbol) for symbol in regressor.symbols]
        part = regressor.fixed[rows] + np.einsum("q,qmn->mn", amplitudes, regressor.columns[:, rows])
        shares.append(DeflectionShare(placed, float(np.sum(part * whole)) / total))
    return shares
