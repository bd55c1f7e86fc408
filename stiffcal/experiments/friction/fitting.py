"""Friction of drives from free motion (paper 004, eq. 1): amplitudes, shapes, and whether there is Stribeck friction.

Amplitudes are linear and found inside, shapes outside (variable projection), weight and inertia are projected out. A
part of the law that an effect calls optional is kept where the information criterion asks for it and the 95 % interval
of its amplitude leaves zero out; its shape is then refined.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.experiments.friction.rows import FrictionRows, felt_columns, together
from stiffcal.experiments.friction.solving import FrictionLaw, PartFit, initial_friction_law
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import ParameterRole, ParameterSpec
from stiffcal.uncertainty import NORMAL_95


@dataclass(frozen=True)
class FrictionParameter:
    """One parameter of one joint."""

    name: str
    """Full name, as in model.toml."""
    effect: str
    """Name of its effect."""
    joint: int
    """From 1."""
    spec: ParameterSpec
    """Its symbol, unit and bounds."""
    value: float | None
    """SI; None where these data do not determine it."""
    std: float | None
    """Standard uncertainty, SI; None where not known or not estimated."""
    interval: tuple[float, float] | None
    """95 % limits, SI; None where not known or not estimated."""
    fixed: bool
    """True where it was not estimated: at the model file's value or at the usual one."""
    at_bound: bool
    """True where the value lies on a bound."""
    why: str = ""
    """What a reader must know of the value, "" where nothing."""


@dataclass(frozen=True)
class JointFrictionFit:
    """What was found of one joint."""

    joint: int
    """From 1."""
    parameters: tuple[FrictionParameter, ...]
    """All parameters, in the effect's order."""
    free: tuple[str, ...]
    """Symbols that were estimated."""
    covariance: Floats
    """(q, q) of ``free``, in that order, SI."""
    detected: Mapping[str, bool]
    """Symbol of each optional term's amplitude to whether the data show the term."""
    verdict: Mapping[str, str]
    """The reason for each, in words."""
    noise: float | None
    """N·m of one pass, from repeats; None where there are too few."""
    n_rows: int
    """Number of equations."""
    n_speeds: int
    """Number of speeds; of other motion, of seconds."""
    lowest: float
    """rad/s, the lowest speed."""
    highest: float
    """rad/s, the highest speed."""

    def values(self) -> dict[str, float]:
        """Return symbol to value of what is known."""
        return {parameter.spec.symbol: parameter.value for parameter in self.parameters if parameter.value is not None}


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

    @property
    def friction_measured(self) -> Floats:
        """(k,) N·m: measured torque less weight, inertia and zeros."""
        return np.asarray(self.rows.torque - self.nuisance)


def fit_friction(
    rows: FrictionRows, placed: tuple[PlacedEffect, ...], fixed: frozenset[str] = frozenset()
) -> FrictionFit:
    """Fit the friction of every joint that has an effect and rows.

    Parameters
    ----------
    rows : equations; those of joints without an effect are left out.
    placed : effects that show in motion, one per joint, with the model file's values.
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
        laws = [initial_friction_law(effect, fixed) for effect in placed if effect.place.joints[0] in group_rows.joint]
        groups.append((group, PartFit(group_rows, laws).run()))
    return _whole(rows, groups)


def _whole(rows: FrictionRows, groups: list[tuple[Booleans, PartFit]]) -> FrictionFit:
    """Put the parts together in the order of the rows."""
    friction, nuisance, sigma = np.zeros(len(rows)), np.zeros(len(rows)), np.ones(len(rows))
    unknowns, spread = np.zeros(rows.nuisance.shape[1]), np.zeros(rows.nuisance.shape[1])
    joints: list[JointFrictionFit] = []
    condition, dof, chi2, scaled = 1.0, 0, 0.0, False
    for group, fit in groups:
        friction[group], sigma[group] = fit.friction(), fit.sigma
        felt = felt_columns(rows.nuisance[group])
        unknowns[felt], spread[felt] = fit.unknowns(), fit.unknowns_std()
        nuisance[group] = rows.nuisance[np.ix_(group, felt)] @ unknowns[felt]
        condition = max(condition, fit.condition())
        estimated = sum(len(law.free_nonlinear) for law in fit.laws) + fit.matrix.shape[1]
        dof += len(fit.rows) - fit.basis.shape[1] - estimated
        chi2 += float(fit.residual @ fit.residual)
        scaled = scaled or any(fit.noise[law.joint] is None for law in fit.laws)
        joints += [_joint_fit(fit, law) for law in fit.laws]
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
    )


def _joint_fit(fit: PartFit, law: FrictionLaw) -> JointFrictionFit:
    free, covariance = fit.covariance(law)
    speed = np.abs(fit.rows.velocity[fit.rows_of_joint[law.joint]])
    of_joint = fit.rows_of_joint[law.joint]
    parameters = tuple(_parameter(fit, law, spec, free, covariance) for spec in law.placed.effect.parameters)
    return JointFrictionFit(
        joint=law.joint,
        parameters=parameters,
        free=tuple(free),
        covariance=covariance,
        detected=dict(law.detected),
        verdict=dict(law.verdict),
        noise=fit.noise[law.joint],
        n_rows=int(of_joint.sum()),
        n_speeds=int(np.unique(fit.rows.piece[of_joint]).size),
        lowest=float(speed.min()),
        highest=float(speed.max()),
    )


def _parameter(
    fit: PartFit, law: FrictionLaw, spec: ParameterSpec, free: list[str], covariance: Floats
) -> FrictionParameter:
    name = law.placed.parameter_name(spec.symbol)
    effect = law.placed.effect.name
    unmeasured = [symbol for symbol, shapes in law.placed.effect.optional.items()
              if spec.symbol in (symbol, *shapes) and symbol not in law.amplitudes]  # fmt: skip
    if unmeasured:
        why = f"{unmeasured[0]} friction is not detected: {law.verdict.get(unmeasured[0], '')}"
        return FrictionParameter(name, effect, law.joint, spec, None, None, None, False, False, why)
    shape = spec.role is ParameterRole.NONLINEAR
    value = law.shape[spec.symbol] if shape else fit.amplitude[law.joint, spec.symbol]
    if spec.symbol not in free:
        why = "" if law.held(spec.symbol) else "these data do not identify it; the usual value is taken"
        return FrictionParameter(name, effect, law.joint, spec, value, None, None, True, False, why)
    k = free.index(spec.symbol)
    std = float(np.sqrt(covariance[k, k]))
    interval = (max(value - NORMAL_95 * std, spec.lower), min(value + NORMAL_95 * std, spec.upper))
    at_bound = value <= spec.lower or value >= spec.upper
    return FrictionParameter(name, effect, law.joint, spec, value, std, interval, False, at_bound)


def friction_curve(joint_fit: JointFrictionFit, placed: PlacedEffect, speed: Floats) -> tuple[Floats, Floats]:
    """Return (n,) friction and its standard uncertainty at velocities (n,), N·m, as fitted."""
    values = joint_fit.values()
    shape = placed.shape() | {s: values[s] for s in placed.shape() if s in values}
    columns = placed.effect.torque_columns(speed, shape)
    torque = np.asarray(sum(values.get(symbol, 0.0) * column for symbol, column in columns.items()))
    slopes = []
    for symbol in joint_fit.free:
        if symbol in columns:
            slopes.append(columns[symbol])
            continue
        small = 1e-4 * shape[symbol]
        ends = [
            placed.effect.torque_columns(speed, shape | {symbol: shape[symbol] + direction * small})
            for direction in (1, -1)
        ]
        slope = sum(values.get(s, 0.0) * (ends[0][s] - ends[1][s]) / (2.0 * small) for s in columns)
        slopes.append(np.asarray(slope))
    matrix = np.stack(slopes, axis=1) if slopes else np.zeros((speed.size, 0))
    variance = np.einsum("ni,ij,nj->n", matrix, joint_fit.covariance, matrix)
    return torque, np.sqrt(np.maximum(variance, 0.0))
