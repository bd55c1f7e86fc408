"""Friction at speeds, or in pieces of motion, that the fit has not used."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.experiments.friction.fitting import fit_friction
from stiffcal.experiments.friction.rows import FrictionRows, felt_columns, together
from stiffcal.model.composite import PlacedEffect

# Two unknowns of a straight line and one to spare.
LEAST_PIECES = 3


@dataclass(frozen=True)
class HeldoutFriction:
    """Residuals of rows that a fit has not used."""

    scheme: str
    """How it was done, in words; "none" where too few speeds were measured."""
    residual: Floats
    """(k,) N·m, NaN where a row could not be left out."""


def heldout_friction(
    rows: FrictionRows, placed: tuple[PlacedEffect, ...], fixed: frozenset[str], holdout: Booleans
) -> HeldoutFriction:
    """Leave each speed, or each second of other motion, out in turn; rows held out by the fit of all others.

    A speed's own weight is estimated on itself, and the degree of freedom counted; in other motion weight and inertia
    come from the rest.

    Parameters
    ----------
    rows : equations, those held out among them. holdout : (k,) True for those.
    placed, fixed : as for the fit.
    """
    residual = np.full(len(rows), np.nan)
    for group in together(rows):
        fitted = np.flatnonzero(group & ~holdout)
        pieces = np.unique(rows.piece[fitted])
        if pieces.size >= LEAST_PIECES:
            for piece in pieces:
                out = fitted[rows.piece[fitted] == piece]
                residual[out] = _heldout_residual(rows, np.setdiff1d(fitted, out), out, placed, fixed)
        kept_out = np.flatnonzero(group & holdout)
        for piece in np.unique(rows.piece[kept_out]):
            if fitted.size:
                out = kept_out[rows.piece[kept_out] == piece]
                residual[out] = _heldout_residual(rows, fitted, out, placed, fixed)
    if not np.isfinite(residual).any():
        return HeldoutFriction("none", residual)
    kinds = ["each speed"] if rows.steady.any() else []
    kinds += ["each second of motion"] if not rows.steady.all() else []
    return HeldoutFriction(f"{' and '.join(kinds)} left out in turn", residual)


def _heldout_residual(
    rows: FrictionRows,
    fitted_rows: NDArray[np.int64],
    out: NDArray[np.int64],
    placed: tuple[PlacedEffect, ...],
    fixed: frozenset[str],
) -> Floats:
    joints = set(rows.joint[fitted_rows].tolist())
    effects = tuple(placed_effect for placed_effect in placed if placed_effect.place.joints[0] in joints)
    in_use = np.zeros(len(rows), dtype=np.bool_)
    in_use[fitted_rows] = True
    fit = fit_friction(rows.select(in_use), effects, fixed)
    friction = np.full(out.size, np.nan)
    values = {placed_effect.joint: placed_effect.values() for placed_effect in fit.joints}
    for placed_effect in effects:
        joint = placed_effect.place.joints[0]
        of_joint = rows.joint[out] == joint
        shape = placed_effect.shape() | {
            symbol: values[joint][symbol] for symbol in placed_effect.shape() if symbol in values[joint]
        }
        columns = placed_effect.effect.torque_columns(rows.velocity[out][of_joint], shape)
        friction[of_joint] = sum(values[joint].get(symbol, 0.0) * column for symbol, column in columns.items())
    residual = np.asarray(rows.torque[out] - friction)
    steady = rows.steady[out]
    if steady.any():
        n = int(steady.sum())
        residual[steady] = (residual[steady] - residual[steady].mean()) * (np.sqrt(n / (n - 1.0)) if n > 1 else np.nan)
    if not steady.all():
        felt = felt_columns(rows.nuisance[in_use])
        residual[~steady] -= rows.nuisance[np.ix_(out[~steady], felt)] @ fit.unknowns
    return residual
