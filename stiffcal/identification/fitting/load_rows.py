"""Rows of observations about a robot's values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.estimation.rows import Rows
from stiffcal.estimation.unknowns import ParameterColumn, Unknowns, amplitudes
from stiffcal.identification.derivatives.observation import ModelAtRest, Observations, evaluate
from stiffcal.identification.fitting.priors import prior_rows
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Noise, Whitening, whiten
from stiffcal.identification.noise.weights import along_the_sweep
from stiffcal.model.assembled.composite import CompliantRobot


@dataclass(frozen=True)
class LoadRows(Rows):
    """Load states, absolute places and clamped motors about the values of a robot's free parameters."""

    space: Projection
    """Noise and the runs' offsets."""
    columns: tuple[ParameterColumn, ...]
    """The p free parameters."""

    @classmethod
    def about(
        cls,
        robot: CompliantRobot,
        data: Observations,
        columns: Sequence[ParameterColumn],
        weights: Whitening | Noise,
        at_rest: ModelAtRest | None = None,
    ) -> LoadRows:
        """Linearise a robot about its values.

        Parameters
        ----------
        robot : with a value of every parameter.
        data : the observations.
        columns : the p parameters by which the readings are differentiated.
        weights : the weights, or the noise from which they are made with the robot as it is.
        at_rest : the robot at rest in all states, where it is at hand; it is found anew where not.

        Raises
        ------
        NoBalanceError : the robot finds no balance under a load.
        """
        of_noise = isinstance(weights, Noise) and weights.of_wrench
        if at_rest is None:
            blocks = list(evaluate(robot, data, columns, with_sensitivity=of_noise))
        else:
            blocks = [at_rest.evaluated(slice(0, data.n_states), columns, of_noise)]
        if isinstance(weights, Noise):
            carried = [block.sensitivity for block in blocks if block.sensitivity is not None]
            sensitivity = along_the_sweep(np.concatenate(carried, axis=2), data) if of_noise else None
            weights = whiten(weights, data, sensitivity)
        unknowns = Unknowns.of(robot, columns)
        return cls(
            unknowns=unknowns,
            values=amplitudes(robot, columns),
            derivative=np.concatenate([block.columns for block in blocks], axis=2),
            predicted=np.concatenate([block.predicted for block in blocks], axis=1),
            measured=data.measured,
            mask=data.measured_mask,
            space=Projection.of(data, weights),
            prior=prior_rows(robot, columns, unknowns, data),
            columns=tuple(columns),
        )
