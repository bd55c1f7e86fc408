"""Load states, absolute places and clamped motors as rows of a fit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.unknowns import OpenBefore, ParameterColumn, Unknowns, free_columns, with_estimates
from stiffcal.identification.derivatives.observation import Evaluation, Observations, evaluate
from stiffcal.identification.fitting.least_squares import reduce_blocks
from stiffcal.identification.fitting.priors import prior_rows
from stiffcal.identification.fitting.problem import Problem
from stiffcal.identification.fitting.settings import Settings
from stiffcal.identification.noise.corrected_wrenches import corrected_wrenches
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.noise.weights import (
    Weights,
    estimate_weights,
    huber_whitening,
    needs_wrench_sensitivity,
    weighed_alike,
    without_offsets,
)
from stiffcal.model.assembled.composite import CompliantRobot


@dataclass(frozen=True)
class LoadWeights:
    """Observations with their weights."""

    data: Observations
    """The observations, with their present correction."""
    weights: Weights
    """As the noise makes them."""
    lowered: Whitening | None = None
    """Lower for wild readings (Huber); None where every reading counts by its noise."""

    @property
    def whitening(self) -> Whitening:
        """What the rows are weighed with."""
        return self.lowered or self.weights.whitening

    def sums_as(self, other: LoadWeights) -> bool:
        """Return whether a sum of squares compares with that under others: the same readings and weights."""
        one, another = self.whitening, other.whitening
        if self.data is not other.data:
            return False
        alike = one.lower is None and another.lower is None and np.array_equal(one.scale, another.scale)
        return one is another or alike


@dataclass(frozen=True)
class LoadSource:
    """Makes the rows of observations about a robot's free parameters (`stiffcal.estimation.solve.RowSource`)."""

    problem: Problem
    """What is known of the observations' repeats and noise."""
    data: Observations
    """The observations, with their present correction."""
    robot: CompliantRobot
    """Chain and effects; the values of its free parameters do not matter."""
    columns: Sequence[ParameterColumn]
    """Its p free parameters."""
    unknowns: Unknowns
    """The same, as the fit knows them."""
    settings: Settings
    """How to identify."""
    stated: Weights | None = None
    """Weights whose noise is taken over; None: it is estimated."""

    @classmethod
    def of(
        cls,
        problem: Problem,
        robot: CompliantRobot,
        settings: Settings,
        open_before: OpenBefore,
        stated: Weights | None = None,
    ) -> LoadSource:
        """Return the source of all free parameters; arguments as the fields."""
        columns = free_columns(robot, settings.fixed)
        unknowns = Unknowns.of(robot, columns, open_before)
        return cls(problem, problem.data, robot, columns, unknowns, settings, stated)

    @property
    def curved(self) -> bool:
        """Whether the rows or their weights change with the parameters."""
        return self.robot.deformed or self.lasting_weights

    @property
    def lasting_weights(self) -> bool:
        """Whether wild readings count less, by what the fit leaves of them."""
        return self.settings.loss == "huber"

    def robot_at(self, values: Floats) -> CompliantRobot:
        """Return the robot with values (p,) of its free parameters."""
        return with_estimates(self.robot, self.columns, values)

    def reduced(self, values: Floats, weights: LoadWeights | None, renew: bool) -> tuple[Reduced, LoadWeights]:
        """Return the rows about values (p,), and their weights; see `stiffcal.estimation.solve.RowSource`."""
        robot, lowered = self.robot_at(values), None if weights is None else weights.lowered
        made, blocks = self._weighed(robot, None if weights is None else weights.weights, renew)
        if self.lasting_weights:
            blocks = list(blocks)
            predicted = np.concatenate([block.predicted for block in blocks], axis=1)
            lowered = huber_whitening(made.whitening, lowered or made.whitening, self.data, predicted)
        under = LoadWeights(self.data, made, lowered)
        reduced = reduce_blocks(blocks, self.data, under.whitening)
        return reduced.with_prior(prior_rows(robot, self.columns, self.unknowns, self.data)), under

    def squares(self, values: Floats, reduced: Reduced, weights: LoadWeights) -> float:
        """Return the sum of squares of the rows about values (p,) under other weights."""
        residual = without_offsets(self.data, reduced.predicted, weights.whitening)
        before = prior_rows(self.robot_at(values), self.columns, self.unknowns, self.data)
        return float(np.sum(weights.whitening.apply(residual) ** 2) + np.sum(before[:, -1] ** 2))

    def corrected(self, values: Floats, reduced: Reduced, weights: LoadWeights) -> tuple[LoadSource, float]:
        """Return the source with clamped states' wrenches where they lie most probably, and how far they moved."""
        data, moved = corrected_wrenches(self.robot_at(values), self.data, reduced, weights.weights)
        return (self if data is self.data else replace(self, data=data)), moved

    def _weighed(
        self, robot: CompliantRobot, weights: Weights | None, renew: bool
    ) -> tuple[Weights, Iterable[Evaluation]]:
        """Return weights and the model's rows; ``weights`` are those of the last step, None where there are none."""
        data, columns, stated = self.data, self.columns, self.stated
        if stated is not None and not self.lasting_weights:
            blocks: Iterable[Evaluation] = evaluate(robot, data, columns, with_sensitivity=stated.carried and renew)
            return weighed_alike(stated, data, blocks) if renew or weights is None else (weights, blocks)
        sensitive = renew and needs_wrench_sensitivity(self.settings.noise)
        rows = list(evaluate(robot, data, columns, with_sensitivity=sensitive))
        return (self._estimated(rows) if renew or weights is None else weights), rows

    def weights_at(self, robot: CompliantRobot) -> Weights:
        """Return the weights that follow from the noise with this robot."""
        sensitive = needs_wrench_sensitivity(self.settings.noise)
        return self._estimated(list(evaluate(robot, self.data, with_sensitivity=sensitive)))

    def _estimated(self, blocks: Sequence[Evaluation]) -> Weights:
        groups, known, settings = self.problem.groups, self.problem.stated, self.settings
        return estimate_weights(self.data, blocks, groups, known, settings.noise, settings.equal_weights)
