"""Profiles of parameters: the least sum of squares with a parameter held at one value after another.

An interval of value ± so many standard uncertainties is that of a parabola. A parameter that bends its law, or that is
near the edge of what is possible, has a sum of squares of another form; the interval in which it rises by no more than
the 95 % level allows holds whatever the form is (Bates and Watts 1988, section 6.1).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.parameters import student_95
from stiffcal.estimation.step import solve_step
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.unknowns import (
    ParameterColumn,
    Unknowns,
    amplitude_bounds,
    amplitudes,
    free_columns,
    with_estimates,
)
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.fitting.priors import prior_rows
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.no_balance import NoBalanceError
from stiffcal.model.effect import ParameterRole, ParameterSpec
from stiffcal.uncertainty import NORMAL_95

MOST_PROFILES = 6
"""Parameters that bend their law first, then those closest to a bound."""
NEAR_BOUND = 3.0
"""Standard uncertainties from a bound within which a parabola reaches beyond what is possible."""
REACH, STEPS = 3.6, 3
"""How far a profile goes to each side, in standard uncertainties, and in how many values it is computed."""
BETWEEN = 12
"""Values to each side that are stated, between those that are computed too."""


@dataclass(frozen=True)
class Profile:
    """The least sum of squares over the values of one parameter, all others free."""

    name: str
    """Its full name."""
    spec: ParameterSpec
    """Its unit and bounds."""
    bends: bool
    """Whether it bends its law: else it is near a bound."""
    values: Floats
    """(k,) as the parameter is stated, ascending."""
    rise: Floats
    """(k,) of the sum of squares above its least, in variances of the noise."""
    parabola: Floats
    """(k,) what the standard uncertainty stands for."""
    level: float
    """Rise at the ends of the 95 % interval."""
    estimate: float
    """The value that the fit states."""
    low: float | None
    """Lower end of the interval by the profile; None where it is not reached."""
    high: float | None
    """Its upper end."""


def profiled(robot: CompliantRobot, spread: Mapping[str, float]) -> list[ParameterColumn]:
    """Return the parameters that have a profile, `MOST_PROFILES` at most.

    Parameters
    ----------
    robot : with the estimates. spread : full name to standard uncertainty, as the fit counts, of those that are known.
    """
    chosen: list[tuple[bool, float, int]] = []
    columns = free_columns(robot)
    values = amplitudes(robot, columns)
    for k, column in enumerate(columns):
        std = spread.get(_name(robot, column), 0.0)
        if std > 0.0:
            low, high = amplitude_bounds(_spec(robot, column))
            is_straight, distance = column.role is not ParameterRole.NONLINEAR, min(values[k] - low, high - values[k])
            if not is_straight or distance < NEAR_BOUND * std:
                chosen.append((is_straight, float(distance / std), k))
    return [columns[k] for *_, k in sorted(chosen)[:MOST_PROFILES]]


def profiles(fit: Fit) -> list[Profile]:
    """Return the profiles of parameters that bend their law or are near a bound.

    Parameters
    ----------
    fit : whose weights stay as they are.
    """
    spread = dict(zip(fit.free_names, np.sqrt(np.diag(fit.covariance)).tolist(), strict=True))
    chosen = profiled(fit.robot, spread)
    if not chosen:
        return []
    whole = fit.linearised()
    reduced = whole.reduced()
    found, _checked = solve_step(reduced, whole.unknowns, whole.values)
    least = reduced.cost(found - whole.values)
    variance = least / max(fit.dof, 1) if fit.scaled else 1.0
    level = (student_95(fit.dof) if fit.scaled else NORMAL_95) ** 2
    return [
        _profile(whole, fit, column, spread[_name(fit.robot, column)], (least, variance, level)) for column in chosen
    ]


def _name(robot: CompliantRobot, column: ParameterColumn) -> str:
    return robot.placed[column.placed].parameter_name(column.symbol)


def _spec(robot: CompliantRobot, column: ParameterColumn) -> ParameterSpec:
    return robot.placed[column.placed].effect.spec(column.symbol)


def _profile(
    whole: LoadRows, fit: Fit, column: ParameterColumn, std: float, scale: tuple[float, float, float]
) -> Profile:
    """Return the profile of an unknown.

    Parameters
    ----------
    whole : the rows about the estimates, by all unknowns. std : standard uncertainty of this one.
    scale : the least sum, the variance of the noise and the level.
    """
    least, variance, level = scale
    spec, others = _spec(fit.robot, column), _Others(fit, whole, column)
    estimate = float(amplitudes(fit.robot, [column])[0])
    low, high = amplitude_bounds(spec)
    parts = [(np.array([estimate]), np.zeros(1))]
    for end in (max(low, estimate - REACH * std), min(high, estimate + REACH * std)):
        if end == estimate:
            continue
        nodes = np.linspace(estimate, end, STEPS + 1)[1:]
        rise = (np.array(others.least_sums(nodes.tolist())) - least) / variance
        parts.append(_between(estimate, nodes, np.maximum(rise, 0.0)))
    grid, rise = (np.concatenate(both) for both in zip(*parts, strict=True))
    values = np.array([spec.value_of(value) if value or not spec.inverse else np.inf for value in grid.tolist()])
    parabola = ((grid - estimate) / std) ** 2
    order = np.argsort(values)
    values, rise, parabola = values[order], rise[order], parabola[order]
    middle = int(np.argmin(parabola))
    return Profile(
        _name(fit.robot, column), spec, column.role is ParameterRole.NONLINEAR, values, rise, parabola, level,
        float(values[middle]),
        _reached(values[middle::-1], rise[middle::-1], level), _reached(values[middle:], rise[middle:], level),
    )  # fmt: skip


class _Others:
    """All unknowns but one, which is held.

    They are solved for with the derivative at the estimates: what each value that is held asks for is the readings that
    the model predicts there, without their derivative, which takes most of the time and changes a least sum in third
    order only.
    """

    def __init__(self, fit: Fit, whole: LoadRows, held: ParameterColumn) -> None:
        self._fit, self._held = fit, held
        self._columns = [one for one in fit.columns if one != held]
        self._unknowns = Unknowns.of(fit.robot, self._columns)
        of_others = np.array([one != held for one in fit.columns], dtype=np.bool_)
        white = whole.white[:-1]
        self._basis, self._factor = np.linalg.qr(white[of_others].T)
        self._slope = white[~of_others][0]
        self._readings = whole.white[-1]

    def least_sums(self, values: Sequence[float]) -> list[float]:
        """Return the least sum of squares with each of these values held; infinite where there is no balance."""
        robot, readings, before = self._fit.robot, self._readings, float(amplitudes(self._fit.robot, [self._held])[0])
        sums: list[float] = []
        for value in values:
            # the others go on from where they were at the value before, on the straight line of the derivative
            straight, _ = self._solved(robot, readings - self._slope * (value - before))
            moved = with_estimates(straight, [self._held], np.array([value]))
            try:
                rows = LoadRows.about(moved, self._fit.data, (), self._fit.whitening)
            except NoBalanceError:
                return sums + [np.inf] * (len(values) - len(sums))
            robot, readings, before = moved, rows.white[-1], value
            robot, least = self._solved(robot, readings)
            readings = readings - self._basis @ (self._factor @ self._moved(moved, robot))
            sums.append(least)
        return sums

    def _solved(self, robot: CompliantRobot, readings: Floats) -> tuple[CompliantRobot, float]:
        """Return the others as they fit readings (k,) that a robot leaves, and the sum of squares then."""
        of_basis = self._basis.T @ readings
        bare = Reduced(self._factor, of_basis, max(float(readings @ readings - of_basis @ of_basis), 0.0), 0)
        reduced = bare.with_prior(prior_rows(robot, self._columns, self._unknowns, self._fit.data))
        start = amplitudes(robot, self._columns)
        found, _checked = solve_step(reduced, self._unknowns, start)
        return with_estimates(robot, self._columns, found), reduced.cost(found - start)

    def _moved(self, before: CompliantRobot, after: CompliantRobot) -> Floats:
        return amplitudes(after, self._columns) - amplitudes(before, self._columns)


def _between(estimate: float, nodes: Floats, rise: Floats) -> tuple[Floats, Floats]:
    """Return `BETWEEN` values from the estimate to the last node, and the rise at each; infinite where there is none.

    The rise over the distance is interpolated: it is straight for every parabola, also for one whose least lies beyond
    a bound.
    """
    values = np.linspace(estimate, nodes[-1], BETWEEN + 1)[1:]
    away, computed = np.abs(nodes - estimate), np.isfinite(rise)
    away, slope = away[computed], (rise / away)[computed]
    if not away.size:
        return values, np.full(BETWEEN, np.inf)
    at_estimate = max(2.0 * slope[0] - slope[1], 0.0) if away.size > 1 else 0.0
    far = np.abs(values - estimate)
    risen = far * np.interp(far, np.append(0.0, away), np.append(at_estimate, slope))
    return values, np.where(far <= away[-1] * (1.0 + 1e-9), risen, np.inf)


def _reached(values: Floats, rise: Floats, level: float) -> float | None:
    """Return where the rise first reaches a level, on the way from the estimate; None where it does not."""
    beyond = np.flatnonzero(rise >= level)
    if not beyond.size or beyond[0] == 0:
        return None
    last = int(beyond[0])
    # the root of the rise is nearly straight
    below, above = np.sqrt(rise[last - 1]), np.sqrt(min(float(rise[last]), 1e300))
    share = (np.sqrt(level) - below) / (above - below)
    return float(values[last - 1] + share * (values[last] - values[last - 1]))
