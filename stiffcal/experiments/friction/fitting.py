"""What the model file gives drives in free motion (paper 004, eq. 1, and what comes on top), fitted joint by joint.

Amplitudes are linear and found inside, shapes outside (variable projection: Golub and Pereyra 1973), weight and inertia
are projected out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.experiments.friction.drive_law import DriveLaw, initial_law
from stiffcal.experiments.friction.identifiability import MotionLack, undetermined
from stiffcal.experiments.friction.rows import FrictionRows, together
from stiffcal.experiments.friction.solving import PartFit
from stiffcal.mechanics.chain import Chain
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import ParameterRole, ParameterSpec
from stiffcal.uncertainty import NORMAL_95

NOT_IDENTIFIED = "not identifiable from these data; the usual value is used"


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
    lack: MotionLack | None = None
    """Why the motion does not determine it; None where it does, or where it was not estimated."""
    in_fit: float | None = None
    """SI, what the fitted friction was computed with; None where ``value`` is it."""


@dataclass(frozen=True)
class JointFrictionFit:
    """What was found of one joint."""

    joint: int
    """From 1."""
    parameters: tuple[FrictionParameter, ...]
    """All parameters, in the order of the model and of each effect."""
    free: tuple[str, ...]
    """Full names of those that were estimated."""
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

    def values(self) -> dict[str, float]:
        """Return full name to the value that the fitted friction is computed with."""
        used = {p.name: p.in_fit if p.value is None else p.value for p in self.parameters}
        return {name: value for name, value in used.items() if value is not None}


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
    rows: FrictionRows,
    placed: tuple[PlacedEffect, ...],
    chain: Chain,
    fixed: frozenset[str] = frozenset(),
    start: FrictionFit | None = None,
) -> FrictionFit:
    """Fit what shows in motion of every joint that has an effect and rows.

    Parameters
    ----------
    rows : equations; those of joints without an effect are left out.
    placed : effects that show in motion, any number per joint, with the model file's values.
    chain : the robot.
    fixed : full names held at those values.
    start : a fit of nearly the same rows, whose shapes are begun with.

    Raises
    ------
    ValueError
        No row belongs to a joint with an effect.
    """
    rows = rows.select(np.isin(rows.joint, [effect.place.joints[0] for effect in placed]))
    if len(rows) == 0:
        raise ValueError("no reading of friction belongs to a joint of the model")
    groups = []
    shapes = None
    if start is not None:
        shapes = {name: value for part in start.parts for name, value in part.values().items()}
    for group in together(rows):
        group_rows = rows.select(group)
        laws = [initial_law(effect, fixed) for effect in placed if effect.place.joints[0] in group_rows.joint]
        if start is not None:
            _hold_as_in(laws, start)
        groups.append((group, PartFit(group_rows, laws, chain).run(shapes)))
    return _whole(rows, groups, placed)


def _hold_as_in(laws: list[DriveLaw], start: FrictionFit) -> None:
    """Estimate no shape that another fit has held."""
    free = {law.placed.parameter_name(s) for part in start.parts for law in part.laws for s in law.free_nonlinear}
    for law in laws:
        law.free_nonlinear = [symbol for symbol in law.free_nonlinear if law.placed.parameter_name(symbol) in free]


def _whole(rows: FrictionRows, groups: list[tuple[Booleans, PartFit]], placed: tuple[PlacedEffect, ...]) -> FrictionFit:
    """Put the parts together in the order of the rows."""
    friction, nuisance, sigma = np.zeros(len(rows)), np.zeros(len(rows)), np.ones(len(rows))
    unknowns, spread = np.zeros(rows.nuisance.shape[1]), np.zeros(rows.nuisance.shape[1])
    joints: list[JointFrictionFit] = []
    condition, dof, chi2, scaled = 1.0, 0, 0.0, False
    for group, fit in groups:
        friction[group], sigma[group] = fit.friction(), fit.sigma
        own, own_std = fit.unknowns(), fit.unknowns_std()
        nuisance[group] = fit.rows.nuisance @ own
        for k, unknown in enumerate(fit.rows.unknown):
            number = rows.unknown.index(unknown)
            unknowns[number], spread[number] = own[k], own_std[k]
        condition = max(condition, fit.condition())
        estimated = sum(len(law.free_nonlinear) + len(law.chosen) for law in fit.laws) + fit.matrix.shape[1]
        dof += len(fit.rows) - fit.basis.shape[1] - estimated
        chi2 += float(fit.residual @ fit.residual)
        scaled = scaled or not fit.noise_known.all()
        joints += [joint_fit(fit, joint) for joint in fit.joints]
    values = {name: value for _, fit in groups for name, value in fit.values().items()}
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
        placed=tuple(_with_values(effect, values) for effect in placed),
        parts=tuple(fit for _, fit in groups),
    )


def _with_values(placed: PlacedEffect, values: dict[str, float]) -> PlacedEffect:
    """Return an effect with what was found of it."""
    own = {spec.symbol: placed.parameter_name(spec.symbol) for spec in placed.effect.parameters}
    found = {symbol: values[name] for symbol, name in own.items() if name in values}
    return replace(placed, values={**placed.values, **found})


def joint_fit(fit: PartFit, joint: int) -> JointFrictionFit:
    """Return what a fit of several joints found of one."""
    free, covariance = fit.covariance(joint)
    of_joint = fit.rows_of_joint[joint]
    speed = np.abs(fit.rows.velocity[of_joint])
    lacking = undetermined(fit)
    parameters = tuple(
        _parameter(fit, law, spec, (free, covariance), lacking)
        for law in fit.laws
        if law.joint == joint
        for spec in law.placed.effect.parameters
    )
    known = fit.noise_known[of_joint].all()
    return JointFrictionFit(
        joint=joint,
        parameters=parameters,
        free=tuple(free),
        covariance=covariance,
        noise=float(np.sqrt(np.mean(fit.sigma[of_joint] ** 2))) if known else None,
        n_rows=int(of_joint.sum()),
        n_speeds=int(np.unique(fit.rows.piece[of_joint]).size),
        lowest=float(speed.min()),
        highest=float(speed.max()),
    )


def _parameter(
    fit: PartFit,
    law: DriveLaw,
    spec: ParameterSpec,
    estimated: tuple[list[str], Floats],
    lacking: Mapping[str, MotionLack],
) -> FrictionParameter:
    free, covariance = estimated
    name = law.placed.parameter_name(spec.symbol)
    effect = law.placed.effect.name
    value = law.shape[spec.symbol] if spec.role is ParameterRole.NONLINEAR else fit.amplitude[name]
    if name not in free:
        why = "" if law.held(spec.symbol) or spec.symbol in law.chosen else NOT_IDENTIFIED
        held = spec.symbol not in law.chosen
        return FrictionParameter(name, effect, law.joint, spec, value, None, None, held, False, why)
    if name in lacking:
        lack = lacking[name]
        return FrictionParameter(
            name, effect, law.joint, spec, None, None, None, False, False, lack.sentence, lack, in_fit=value
        )
    k = free.index(name)
    std = float(np.sqrt(covariance[k, k]))
    interval = (max(value - NORMAL_95 * std, spec.lower), min(value + NORMAL_95 * std, spec.upper))
    at_bound = value <= spec.lower or value >= spec.upper
    return FrictionParameter(name, effect, law.joint, spec, value, std, interval, False, at_bound)


def friction_curve(
    joint_fit: JointFrictionFit, placed: tuple[PlacedEffect, ...], speed: Floats
) -> tuple[Floats, Floats]:
    """Return (n,) friction and its standard uncertainty at velocities (n,), N·m, of laws of velocity alone."""
    values = joint_fit.values()
    torque, slopes = np.zeros(speed.size), {name: np.zeros(speed.size) for name in joint_fit.free}
    for law in placed:
        full = {symbol: law.parameter_name(symbol) for symbol in (spec.symbol for spec in law.effect.parameters)}
        shape = law.shape() | {symbol: values[full[symbol]] for symbol in law.shape() if full[symbol] in values}
        columns = law.effect.torque_columns(speed, shape)
        for symbol, column in columns.items():
            torque += values.get(full[symbol], 0.0) * column
            if full[symbol] in slopes:
                slopes[full[symbol]] = column
        for symbol in shape:
            if columns and full[symbol] in slopes:
                small = 1e-4 * shape[symbol]
                ends = [
                    law.effect.torque_columns(speed, shape | {symbol: shape[symbol] + way * small}) for way in (1, -1)
                ]
                slopes[full[symbol]] = np.asarray(
                    sum(values.get(full[s], 0.0) * (ends[0][s] - ends[1][s]) / (2.0 * small) for s in columns)
                )
    matrix = np.stack(list(slopes.values()), axis=1) if slopes else np.zeros((speed.size, 0))
    variance = np.einsum("ni,ij,nj->n", matrix, joint_fit.covariance, matrix)
    return torque, np.sqrt(np.maximum(variance, 0.0))
