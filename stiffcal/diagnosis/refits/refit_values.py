"""The values of a linear refit with one more effect, with their 95 % intervals.

The columns' inner products, whitened and taken over all poses, are the information of what was refitted: their inverse
is the covariance of its steps, as of any weighted least squares. Where the noise is not known, what the refit leaves
stands for it, with Student's quantile, as in a fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.scan import Scan, Trial
from stiffcal.documents import NOT_PROMISED, Number
from stiffcal.estimate import Estimate
from stiffcal.estimation.parameters import interval_within, on_bounds, student_95
from stiffcal.estimation.unknowns import amplitude_bounds
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import ParameterSpec
from stiffcal.uncertainty import NORMAL_95

UNDETERMINED = 1e-8
"""Smallest eigenvalue over the largest, of columns scaled to one: below it a step is not determined."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RefitValue:
    """A parameter's value in a refit."""

    name: str
    """``effect.place.symbol``."""
    value: Number
    """SI; null where it is not known."""
    interval: list[Number] | None = None
    """Both ends of the 95 % interval, null where one is open; null where none is known, as of a shape."""
    at_bound: Annotated[bool, NOT_PROMISED] = False
    """Whether the value is at the limit of its range."""

    @property
    def estimate(self) -> Estimate:
        """The value with its interval."""
        return Estimate(value=self.value, interval=self.interval, at_bound=self.at_bound)


def refit_values(robot: CompliantRobot, scan: Scan, trial: Trial, own: Sequence[str]) -> list[RefitValue]:
    """Return the value and the interval of every parameter of the model with a candidate.

    Parameters
    ----------
    robot : the model with the candidate as its last effect, with the values that were found with all poses.
    scan : of the present model. trial : the candidate.
    own : full names of the present model's free parameters, in the order of the scan's first columns.
    """
    halves = _half_intervals(scan, trial)
    added = robot.placed[-1]
    names = [*own, *(added.parameter_name(symbol) for symbol in trial.regressor.symbols)]
    last = halves[len(halves) - len(trial.regressor.symbols) :]
    known = dict(zip(names, [*halves[: len(own)], *last], strict=True))
    values = robot.values()
    return [
        RefitValue(
            name=name,
            value=float(values[name]),
            interval=_interval(spec, placed.amplitude(spec.symbol), known.get(name, np.nan)),
            at_bound=_at_bound(spec, placed.amplitude(spec.symbol), known.get(name, np.nan)),
        )
        for placed in robot.placed
        for spec in placed.effect.parameters
        if (name := placed.parameter_name(spec.symbol)) in values
    ]


def _half_intervals(scan: Scan, trial: Trial) -> Floats:
    """Return (k,) half the 95 % interval of each step of the refit; NaN where it is not determined."""
    normal = trial.score.normal
    scale = np.sqrt(np.diagonal(normal))
    if not (scale > 0.0).all():
        return np.full(len(normal), np.nan)
    squares, axes = np.linalg.eigh(normal / np.outer(scale, scale))
    if squares[0] < UNDETERMINED * squares[-1]:
        return np.full(len(normal), np.nan)
    std = np.sqrt(np.sum(axes**2 / squares, axis=1)) / scale
    if scan.fit.noise is not None:
        return np.asarray(NORMAL_95 * std)
    dof = scan.residual_dof - len(trial.regressor.symbols)
    return np.asarray(student_95(dof) * np.sqrt(trial.score.sum_of_squares / max(dof, 1)) * std)


def _at_bound(spec: ParameterSpec, amplitude: float, half: float) -> bool:
    """Return whether a parameter that was refitted is at a limit of its range."""
    return bool(np.isfinite(half)) and any(on_bounds(amplitude, half, amplitude_bounds(spec)))


def _interval(spec: ParameterSpec, amplitude: float, half: float) -> list[Number] | None:
    """Return the ends of a parameter's interval, kept within what is possible; None where it is not known."""
    if not np.isfinite(half):
        return None
    ends = interval_within(spec, amplitude, half, amplitude_bounds(spec))
    return [float(end) if np.isfinite(end) else None for end in ends]
