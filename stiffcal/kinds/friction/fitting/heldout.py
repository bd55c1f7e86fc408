"""Friction at speeds, or in pieces of motion, that the fit has not used.

About the fit its rows are linear, so that leaving a speed out needs no new fit (`stiffcal.estimation.leave_out`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.kinds.friction.fitting.drive_space import first_sigma
from stiffcal.kinds.friction.fitting.joint_fits import FrictionFit
from stiffcal.kinds.friction.fitting.part_fit import PartFit
from stiffcal.kinds.friction.fitting.source import MotionSource
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, UnknownKind, together
from stiffcal.mechanics.chain import Chain

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
        bare = PartFit.of(rows.select(group), (), chain)
        residual[group] = bare.rows.torque - bare.rows.nuisance @ bare.unknowns
    known = np.isfinite(rows.sigma).all()
    noise = float(np.sqrt(np.mean(rows.sigma**2))) if known else None
    return JudgedFriction(rows.joint, rows.run, residual, residual, noise, "each speed left out in turn", ())


def heldout_friction(rows: FrictionRows, fit: FrictionFit, holdout: Booleans) -> HeldoutFriction:
    """Leave each speed, or each second of other motion, out in turn; rows held out by the fit of all others.

    A speed's own weight is estimated on itself, and the degree of freedom counted; in other motion weight and inertia
    come from the rest.

    Parameters
    ----------
    rows : equations of joints with an effect, those held out among them. holdout : (k,) True for those.
    fit : of all rows that are not held out.
    """
    residual = np.full(len(rows), np.nan)
    fitted, kept_out = np.flatnonzero(~holdout), np.flatnonzero(holdout)
    for group, part in zip(together(fit.rows), fit.parts, strict=True):
        if np.unique(part.rows.piece).size >= LEAST_PIECES:
            residual[fitted[group]] = left_out(part)
        out = kept_out[np.isin(rows.joint[kept_out], part.joints)]
        if out.size:
            residual[out] = _residual_of(part, rows.select(out))
    if not np.isfinite(residual).any():
        return HeldoutFriction("none", residual)
    kinds = ["each speed"] if rows.steady.any() else []
    kinds += ["each second of motion"] if not rows.steady.all() else []
    return HeldoutFriction(f"{' and '.join(kinds)} left out in turn", residual)


def left_out(part: PartFit) -> Floats:
    """Return (k,) N·m that a fit leaves of rows whose piece of motion, or passes at one speed, it has not used.

    NaN where a row is the only one of its speed, or a joint moved in no other piece.
    """
    rows, piece = part.linearised(), part.rows.piece
    folds = [np.flatnonzero(piece == number) for number in np.unique(piece)]
    residual = np.asarray(LeaveOut.of(rows, folds).residual * part.sigma)
    for joint in part.joints:
        of_joint = part.rows.joint == joint
        if np.unique(piece[of_joint]).size == 1:
            residual[of_joint] = np.nan
    for k, unknown in enumerate(part.rows.unknown):
        if unknown.kind is UnknownKind.STRETCH:
            felt = part.rows.nuisance[:, k] != 0.0
            residual[felt] *= _freedom(int(felt.sum()))
    return residual


def _residual_of(part: PartFit, rows: FrictionRows) -> Floats:
    """Return (o,) N·m that a fit leaves of other rows; a constant that only they feel is estimated on them."""
    placed = tuple(effect for effect in part.robot.placed if effect.place.joints[0] in rows.joint)
    source = MotionSource.of(rows, placed, part.source.made.chain, part.source.fixed)
    residual = rows.torque - sum((source.torque_of(effect) for effect in placed), np.zeros(len(rows)))
    known = dict(zip(part.rows.unknown, part.unknowns.tolist(), strict=True))
    weight = 1.0 / first_sigma(rows) ** 2
    own = []
    for k, unknown in enumerate(source.rows.unknown):
        if unknown in known:
            residual -= source.rows.nuisance[:, k] * known[unknown]
        elif unknown.kind is UnknownKind.STRETCH:
            own.append(source.rows.nuisance[:, k] != 0.0)
    for felt in own:
        residual[felt] -= float(np.sum(weight[felt] * residual[felt]) / weight[felt].sum())
        residual[felt] *= _freedom(int(felt.sum()))
    return np.asarray(residual)


def _freedom(n: int) -> float:
    """Return what n residuals about their own mean are short of; NaN of a single one."""
    return float(np.sqrt(n / (n - 1.0))) if n > 1 else np.nan
