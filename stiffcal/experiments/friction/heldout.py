"""Friction at speeds, or in pieces of motion, that the fit has not used."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.experiments.friction.drive_law import initial_law
from stiffcal.experiments.friction.fitting import FrictionFit, fit_friction
from stiffcal.experiments.friction.rows import FrictionRows, UnknownKind, together
from stiffcal.experiments.friction.solving import PartFit
from stiffcal.mechanics.chain import Chain
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


@dataclass(frozen=True)
class JudgedFriction:
    """Error in rows of friction, k of them."""

    joint: Integers
    """(k,) from 1."""
    run: NDArray[np.str_]
    """(k,) name of the run."""
    residual: Floats
    """(k,) N·m, NaN where a row was not judged."""
    size: Floats
    """(k,) N·m of friction that was measured, weight and inertia taken out; NaN where a row was not fitted."""
    noise: float | None
    """N·m rms; None where it is not known."""
    scheme: str
    """What was left out, in words; "none" where too few speeds were measured."""
    warnings: tuple[str, ...]
    """What to know of it."""


def joints_without_law(rows: FrictionRows, chain: Chain) -> JudgedFriction:
    """Return the torque of joints that no effect of the model acts in: all but weight and inertia is error."""
    residual = np.zeros(len(rows))
    for group in together(rows):
        bare = PartFit(rows.select(group), [], chain).run()
        residual[group] = bare.rows.torque - bare.rows.nuisance @ bare.unknowns()
    known = np.isfinite(rows.sigma).all()
    noise = float(np.sqrt(np.mean(rows.sigma**2))) if known else None
    return JudgedFriction(rows.joint, rows.run, residual, residual, noise, "each speed left out in turn", ())


def heldout_friction(
    rows: FrictionRows,
    chain: Chain,
    placed: tuple[PlacedEffect, ...],
    fit: FrictionFit,
    fixed: frozenset[str],
    holdout: Booleans,
) -> HeldoutFriction:
    """Leave each speed, or each second of other motion, out in turn; rows held out by the fit of all others.

    A speed's own weight is estimated on itself, and the degree of freedom counted; in other motion weight and inertia
    come from the rest.

    Parameters
    ----------
    rows : equations, those held out among them. holdout : (k,) True for those.
    placed, chain, fixed : as for the fit.
    fit : of all rows that are not held out.
    """
    residual = np.full(len(rows), np.nan)
    for group in together(rows):
        fitted = np.flatnonzero(group & ~holdout)
        pieces = np.unique(rows.piece[fitted])
        if pieces.size >= LEAST_PIECES:
            for piece in pieces:
                out = fitted[rows.piece[fitted] == piece]
                residual[out] = _heldout_residual(rows, np.setdiff1d(fitted, out), out, (placed, chain, fit, fixed))
        kept_out = np.flatnonzero(group & holdout)
        for piece in np.unique(rows.piece[kept_out]):
            if fitted.size:
                out = kept_out[rows.piece[kept_out] == piece]
                residual[out] = _heldout_residual(rows, fitted, out, (placed, chain, fit, fixed))
    if not np.isfinite(residual).any():
        return HeldoutFriction("none", residual)
    kinds = ["each speed"] if rows.steady.any() else []
    kinds += ["each second of motion"] if not rows.steady.all() else []
    return HeldoutFriction(f"{' and '.join(kinds)} left out in turn", residual)


def _heldout_residual(
    rows: FrictionRows,
    fitted_rows: NDArray[np.int64],
    out: NDArray[np.int64],
    model: tuple[tuple[PlacedEffect, ...], Chain, FrictionFit, frozenset[str]],
) -> Floats:
    """Return (o,) residuals of rows left out; a constant that only they feel is estimated on them."""
    placed, chain, whole, fixed = model
    joints = set(rows.joint[fitted_rows].tolist())
    effects = tuple(placed_effect for placed_effect in placed if placed_effect.place.joints[0] in joints)
    in_use = np.zeros(len(rows), dtype=np.bool_)
    in_use[fitted_rows] = True
    used = rows.select(in_use)
    fit = fit_friction(used, effects, chain, fixed, whole)
    values = {name: value for part in fit.parts for name, value in part.values().items()}
    left = rows.select(out)
    laws = [initial_law(effect, fixed) for effect in fit.placed if effect.place.joints[0] in left.joint]
    for law in laws:
        law.shape |= {s: values[law.placed.parameter_name(s)] for s in law.shape}
    bare = PartFit(left, laws, chain)
    residual = left.torque.copy()
    for law in laws:
        for symbol, column in bare.columns(law.placed, law.shape).items():
            residual -= values[law.placed.parameter_name(symbol)] * column
    residual[~np.isin(left.joint, list(joints))] = np.nan
    known = dict(zip(used.unknown, fit.unknowns, strict=True))
    own = []
    for k, unknown in enumerate(bare.rows.unknown):
        if unknown in known:
            residual -= bare.rows.nuisance[:, k] * known[unknown]
        elif unknown.kind is UnknownKind.STRETCH:
            own.append(k)
    for k in own:
        felt = bare.rows.nuisance[:, k] != 0.0
        n = int(felt.sum())
        weight = 1.0 / bare.sigma[felt] ** 2
        residual[felt] -= float(np.sum(weight * residual[felt]) / weight.sum())
        residual[felt] *= np.sqrt(n / (n - 1.0)) if n > 1 else np.nan
    return np.asarray(residual)
