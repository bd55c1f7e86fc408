"""Rows: a model's readings about one set of values of its unknowns, and what was measured.

The one thing that estimation, validation, diagnosis and planning know of an experiment: predicted readings and their
derivative by the unknowns, what was measured, its noise, constants of runs, what is known before, and bounds. Rows of
several experiments stand together where they share unknowns (`together`); readings become equations of them
(`Rows.equations`), and a mistake in them is a change of the readings with unknowns of its own (`Rows.with_change`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.prior import Prior
from stiffcal.estimation.triangular import Reduced, triangular_of_rows
from stiffcal.estimation.unknowns import OpenBefore, Unknowns


class RowSpace(Protocol):
    """The noise of readings and their free constants."""

    @property
    def n_constants(self) -> int:
        """How many constants are free: readings that tell nothing else."""

    def rows(self, stack: Floats) -> Floats:
        """Return (k, m · n) independent rows of unit variance of (k, m, n), free constants taken out."""


@dataclass(frozen=True)
class Rows:
    """Readings about one set of values of p unknowns."""

    unknowns: Unknowns
    """The unknowns with their bounds."""
    values: Floats
    """(p,) about which the readings are predicted."""
    derivative: Floats
    """(p, m, n) of the predicted readings by the unknowns."""
    predicted: Floats
    """(m, n)."""
    measured: Floats
    """(m, n) readings."""
    mask: Booleans
    """(m, n) True where something was read."""
    space: RowSpace
    """Noise and free constants."""
    prior: Floats
    """(r, p + 1) what is known before, as rows of ``prior[:, :p] step ≈ prior[:, p]``."""

    @cached_property
    def residual(self) -> Floats:
        """(m, n) measured minus predicted, constants left in; 0 where nothing was read."""
        return np.where(self.mask, self.measured - self.predicted, 0.0)

    @cached_property
    def stack(self) -> Floats:
        """(p + 1, m, n) the derivative and, last, the residual."""
        return np.concatenate([self.derivative, self.residual[None]])

    @cached_property
    def white(self) -> Floats:
        """(p + 1, m · n) independent rows of unit variance of `stack`."""
        return self.space.rows(self.stack)

    @property
    def steps_within(self) -> tuple[Floats, Floats]:
        """(p,) and (p,) how far down and up each unknown can go from its value."""
        return self.unknowns.steps_within(self.values)

    @property
    def dof(self) -> int:
        """How many readings there are, less their free constants."""
        return int(np.count_nonzero(self.mask)) - self.space.n_constants

    def reduced(self) -> Reduced:
        """Return the problem of the step from the values in triangular form, with what is known before."""
        p = len(self.values)
        triangle = triangular_of_rows(self.white)
        bare = Reduced(triangle[:p, :p], triangle[:p, p], float(triangle[p, p] ** 2), self.dof, self.predicted)
        return bare.with_prior(self.prior)

    def equations(self, value: Floats, slope: Floats, wanted: Floats, space: RowSpace) -> Rows:
        """Return rows of scalar equations of the readings: a touched plane, the length of a ball bar.

        Parameters
        ----------
        value : (q,) of the equations at the predicted readings.
        slope : (q, m, n) derivative of these values by the readings.
        wanted : (q,) what they were measured or known to be.
        space : noise of the equations, which are (1, q) readings.
        """
        derivative = np.einsum("qmn,pmn->pq", slope, self.derivative)[:, None]
        mask = np.ones((1, len(value)), dtype=np.bool_)
        return replace(
            self, derivative=derivative, predicted=value[None], measured=wanted[None], mask=mask, space=space
        )

    def with_change(self, change: ReadingChange) -> Rows:
        """Return the rows with a mistake in the readings taken back, its own unknowns after those of the model.

        Raises
        ------
        ValueError : the model has an unknown of the same name.
        """
        if set(self.unknowns.names) & set(change.unknowns.names):
            raise ValueError("a mistake has unknowns of its own")
        p, q = len(self.values), len(change.values)
        of_change = Prior.independent(change.unknowns.prior).rows(change.values)
        prior = np.zeros((len(self.prior) + len(of_change), p + q + 1))
        prior[: len(self.prior), :p], prior[: len(self.prior), -1] = self.prior[:, :p], self.prior[:, -1]
        prior[len(self.prior) :, p:] = of_change
        return replace(
            self,
            unknowns=joined(self.unknowns, change.unknowns),
            values=np.append(self.values, change.values),
            derivative=np.concatenate([self.derivative, change.derivative]),
            predicted=self.predicted + change.readings,
            prior=prior,
        )


@dataclass(frozen=True)
class ReadingChange:
    """What a mistake does to readings: as it is now, and with its own q unknowns."""

    unknowns: Unknowns
    """How large it is."""
    values: Floats
    """(q,) at which ``readings`` are."""
    readings: Floats
    """(m, n) by how much they are off."""
    derivative: Floats
    """(q, m, n) of that by its unknowns."""


def joined(first: Unknowns, second: Unknowns) -> Unknowns:
    """Return the unknowns of both, those of the first before; a name in both is one unknown.

    Open before any reading is a shared one only where it is so in both.

    Raises
    ------
    ValueError : a shared unknown has two pairs of bounds.
    """
    place = {name: number for number, name in enumerate(first.names)}
    for number, name in enumerate(second.names):
        if name in place and (first.lower[place[name]], first.upper[place[name]]) != (
            second.lower[number],
            second.upper[number],
        ):
            raise ValueError(f"the shared unknown {name} has two pairs of bounds")
    new = np.array([name not in first.names for name in second.names], dtype=np.bool_)
    more = tuple(name for name in second.names if name not in first.names)
    one, other = first.open_before, second.open_before
    causes = {
        name: cause
        for name, cause in {**other.causes, **one.causes}.items()
        if (name in one.causes or name not in first.names) and (name in other.causes or name not in second.names)
    }
    before = OpenBefore(causes, one.common_scale if one.common_scale == other.common_scale else ())
    return Unknowns(
        (*first.names, *more),
        np.append(first.lower, second.lower[new]),
        np.append(first.upper, second.upper[new]),
        np.append(first.nonlinear, second.nonlinear[new]),
        np.append(first.tolerance, second.tolerance[new]),
        np.append(first.prior, second.prior[new]),
        before,
    )


def together(parts: Sequence[Rows]) -> tuple[Unknowns, Floats, Reduced]:
    """Return the unknowns of several experiments, their values, and the problem of all of them in triangular form.

    Unknowns of the same name are shared, the others are each experiment's own: two campaigns with one robot are the
    rows of both. What is known before of a shared unknown counts once, however many of them state it.

    Parameters
    ----------
    parts : at least one; shared unknowns have the same value in all of them.

    Raises
    ------
    ValueError : a shared unknown has two values.
    """
    unknowns = parts[0].unknowns
    for part in parts[1:]:
        unknowns = joined(unknowns, part.unknowns)
    p = len(unknowns)
    values = np.full(p, np.nan)
    rows: list[Floats] = []
    known_before: list[Floats] = []
    remainder, dof = 0.0, 0
    for part in parts:
        place = np.array([unknowns.names.index(name) for name in part.unknowns.names], dtype=np.int64)
        known = np.isfinite(values[place])
        if not np.array_equal(values[place][known], part.values[known]):
            raise ValueError("a shared unknown has two values")
        values[place] = part.values
        reduced = replace(part, prior=part.prior[:0]).reduced()
        own = np.zeros((len(reduced.factor), p + 1))
        own[:, place], own[:, p] = reduced.factor, reduced.target
        rows.append(own)
        remainder, dof = remainder + reduced.remainder, dof + reduced.dof
        before = np.zeros((len(part.prior), p + 1))
        before[:, place], before[:, p] = part.prior[:, :-1], part.prior[:, -1]
        known_before += [row for row in before if not any(np.array_equal(row, other) for other in known_before)]
    triangle = triangular_of_rows(np.concatenate(rows).T)
    whole = Reduced(triangle[:p, :p], triangle[:p, p], remainder + float(triangle[p, p] ** 2), dof)
    return unknowns, values, whole.with_prior(np.array(known_before).reshape(-1, p + 1))
