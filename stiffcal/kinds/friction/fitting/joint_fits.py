"""What the model file gives drives in free motion (paper 004, eq. 1, and what comes on top), fitted joint by joint.

Weight and inertia are projected out; the rest is a fit as any other (`stiffcal.estimation.solve`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.parameters import Parameter
from stiffcal.kinds.friction.fitting.identifiability import MotionLack, motion_lack
from stiffcal.kinds.friction.fitting.part_fit import PartFit
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, together
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.motion import as_motion


@dataclass(frozen=True)
class JointFrictionFit:
    """What was found of one joint."""

    joint: int
    """From 1."""
    parameters: tuple[Parameter, ...]
    """All parameters, in the order of the model and of each effect."""
    lacking: Mapping[str, MotionLack]
    """Full name to why the motion does not determine it."""
    values: Mapping[str, float]
    """Full name to the value that the fitted friction is computed with, SI."""
    free: tuple[str, ...]
    """Full names of those that were solved for."""
    covariance: Floats
    """(q, q) of ``free``, in that order, SI."""
    noise: float | None
    """N·m, rms over the means of bins, from the scatter of neighbouring samples; None where these do not show it."""
    n_rows: int
    """Number of equations."""
    n_speeds: int
    """Number of speeds; of other motion, of seconds."""
    lowest: float
    """rad/s, the lowest speed."""
    highest: float
    """rad/s, the highest speed."""


@dataclass(frozen=True)
class FrictionFit:
    """Friction of all joints."""

    joints: tuple[JointFrictionFit, ...]
    """Fits by joint, in order."""
    rows: FrictionRows
    """The equations that were fitted."""
    friction: Floats
    """(k,) N·m, the model's friction."""
    nuisance: Floats
    """(k,) N·m, weight, inertia and zeros as fitted."""
    unknowns: Floats
    """(m,) fitted weight, inertia and zero errors; of collinear ones the combination of least norm."""
    unknowns_std: Floats
    """(m,) standard uncertainties of ``unknowns``."""
    residual: Floats
    """(k,) N·m, measured minus ``friction`` and ``nuisance``."""
    sigma: Floats
    """(k,) N·m, standard uncertainty that each row was weighted with."""
    dof: int
    """Degrees of freedom."""
    reduced_chi2: float | None
    """Weighted sum of squares over degrees of freedom; None where the noise is not known."""
    condition: float
    """Condition number of the whitened friction columns of unit length."""
    scaled: bool
    """True where standard uncertainties come from the residuals."""
    placed: tuple[PlacedEffect, ...]
    """The effects with the estimated values."""
    parts: tuple[PartFit, ...]
    """The fits of rows that share unknowns."""

    @property
    def friction_measured(self) -> Floats:
        """(k,) N·m: measured torque less weight, inertia and zeros."""
        return np.asarray(self.rows.torque - self.nuisance)


def fit_friction(
    rows: FrictionRows, placed: tuple[PlacedEffect, ...], chain: Chain, fixed: frozenset[str] = frozenset()
) -> FrictionFit:
    """Fit what shows in motion of every joint that has an effect and rows.

    Parameters
    ----------
    rows : equations; those of joints without an effect are left out.
    placed : effects that show in motion, any number per joint, with the model file's values.
    chain : the robot.
    fixed : full names held at those values.

    Raises
    ------
    ValueError
        No row belongs to a joint with an effect.
    """
    rows = rows.select(np.isin(rows.joint, [effect.place.joints[0] for effect in placed]))
    if len(rows) == 0:
        raise ValueError("no reading of friction belongs to a joint of the model")
    groups = []
    for group in together(rows):
        group_rows = rows.select(group)
        own = tuple(effect for effect in placed if effect.place.joints[0] in group_rows.joint)
        groups.append((group, PartFit.of(group_rows, own, chain, fixed)))
    return _whole(rows, groups, placed)


def _whole(rows: FrictionRows, groups: list[tuple[Booleans, PartFit]], placed: tuple[PlacedEffect, ...]) -> FrictionFit:
    """Put the parts together in the order of the rows."""
    friction, nuisance, sigma = np.zeros(len(rows)), np.zeros(len(rows)), np.ones(len(rows))
    unknowns, spread = np.zeros(rows.nuisance.shape[1]), np.zeros(rows.nuisance.shape[1])
    joints: list[JointFrictionFit] = []
    condition, dof, chi2, scaled = 1.0, 0, 0.0, False
    for group, fit in groups:
        friction[group], sigma[group] = fit.friction, fit.sigma
        own, own_std = fit.unknowns, fit.unknowns_std
        nuisance[group] = fit.rows.nuisance @ own
        for k, unknown in enumerate(fit.rows.unknown):
            number = rows.unknown.index(unknown)
            unknowns[number], spread[number] = own[k], own_std[k]
        condition = max(condition, fit.settled.checked.condition)
        dof += fit.dof
        chi2 += float(fit.residual @ fit.residual)
        scaled = scaled or fit.source.lasting_weights
        joints += [joint_fit(fit, joint) for joint in fit.joints]
    found = {effect.parameter_name(""): effect for _, fit in groups for effect in fit.robot.placed}
    return FrictionFit(
        joints=tuple(sorted(joints, key=lambda joint_fit: joint_fit.joint)),
        rows=rows,
        friction=friction,
        nuisance=nuisance,
        unknowns=unknowns,
        unknowns_std=spread,
        residual=rows.torque - friction - nuisance,
        sigma=sigma,
        dof=max(dof, 0),
        reduced_chi2=None if scaled or dof <= 0 else chi2 / dof,
        condition=condition,
        scaled=scaled,
        placed=tuple(found.get(effect.parameter_name(""), effect) for effect in placed),
        parts=tuple(fit for _, fit in groups),
    )


def joint_fit(fit: PartFit, joint: int) -> JointFrictionFit:
    """Return what a fit of several joints found of one."""
    of_joint = fit.rows.joint == joint
    velocity = fit.rows.velocity[of_joint]
    placed = tuple(effect for effect in fit.robot.placed if effect.place.joints[0] == joint)
    names = fit.solved.unknowns.names
    own = [k for k, column in enumerate(fit.solved.columns) if fit.robot.placed[column.placed] in placed]
    lack = motion_lack(velocity) or MotionLack.COLLINEAR
    stems = tuple(effect.parameter_name("") for effect in placed)
    causes = dict.fromkeys(sorted(fit.unidentified), lack) | dict.fromkeys(sorted(fit.usual), MotionLack.SHAPE)
    known = fit.source.noise_known[of_joint].all()
    speed = np.abs(velocity)
    return JointFrictionFit(
        joint=joint,
        parameters=tuple(p for p in fit.parameters if p.place.joints[0] == joint),
        lacking={name: cause for name, cause in causes.items() if name.startswith(stems)},
        values={name: value for name, value in fit.values.items() if name.startswith(stems)},
        free=tuple(names[k] for k in own),
        covariance=fit.covariance[np.ix_(own, own)],
        noise=float(np.sqrt(np.mean(fit.sigma[of_joint] ** 2))) if known else None,
        n_rows=int(of_joint.sum()),
        n_speeds=int(np.unique(fit.rows.piece[of_joint]).size),
        lowest=float(speed.min()),
        highest=float(speed.max()),
    )


def friction_curve(
    joint_fit: JointFrictionFit, placed: tuple[PlacedEffect, ...], speed: Floats
) -> tuple[Floats, Floats]:
    """Return (n,) friction and its standard uncertainty at velocities (n,), N·m, of laws of velocity alone."""
    values = joint_fit.values
    torque, slopes = np.zeros(speed.size), {name: np.zeros(speed.size) for name in joint_fit.free}
    for law in placed:
        full = {symbol: law.parameter_name(symbol) for symbol in (spec.symbol for spec in law.effect.parameters)}
        shape = law.shape() | {symbol: values[full[symbol]] for symbol in law.shape() if full[symbol] in values}
        effect = as_motion(law.effect)
        columns = effect.torque_columns(speed, shape)
        for symbol, column in columns.items():
            torque += values.get(full[symbol], 0.0) * column
            if full[symbol] in slopes:
                slopes[full[symbol]] = column
        for symbol in shape:
            if columns and full[symbol] in slopes:
                small = 1e-4 * shape[symbol]
                ends = [effect.torque_columns(speed, shape | {symbol: shape[symbol] + way * small}) for way in (1, -1)]
                slopes[full[symbol]] = np.asarray(
                    sum(values.get(full[s], 0.0) * (ends[0][s] - ends[1][s]) / (2.0 * small) for s in columns)
                )
    matrix = np.stack(list(slopes.values()), axis=1) if slopes else np.zeros((speed.size, 0))
    variance = np.einsum("ni,ij,nj->n", matrix, joint_fit.covariance, matrix)
    return torque, np.sqrt(np.maximum(variance, 0.0))
