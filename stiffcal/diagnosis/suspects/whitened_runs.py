"""All runs against a fit of some of them: residuals, columns and noise, run by run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.suspects.influence import Basis, RunBlocks
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import Observations, observe
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.fitting.nonlinear_start import lacks_nonlinear_value
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Noise, stated_noise
from stiffcal.identification.noise.weights import raw_whitening, residual_noise
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole


@dataclass(frozen=True)
class WhitenedRuns:
    """Readings against a model: whitened rows, run by run."""

    data: Observations
    """The observations."""
    members: tuple[Integers, ...]
    """Per run the indices of its states among the n of ``data``."""
    projection: Projection
    """Whitens, and takes the runs' offsets out."""
    rows: Floats
    """(p + 1, m, n) whitened columns of the free parameters, then the residual."""
    residual: Floats
    """(m, n) measured minus predicted, offsets left in."""
    basis: Basis
    """Basis of the parameters."""
    blocks: RunBlocks
    """The rows in this basis, summed over each run."""

    def scores(self, left_out: Sequence[int]) -> Floats:
        """Return (R,) the deleted residual of each run over its uncertainty; zero where a run has no influence."""
        freedom = self.blocks.freedom(left_out)
        deleted = self.blocks.deleted(left_out)
        return np.asarray(np.sqrt(np.where(freedom > 0, deleted / np.maximum(freedom, 1), 0.0)))


@dataclass(frozen=True)
class Bench:
    """A model and a noise against which states can be compared."""

    robot: CompliantRobot
    """With a value of every parameter."""
    fixed: frozenset[str]
    """Full names of parameters that are not free."""
    noise: Noise
    """Of the readings."""
    basis: Basis
    """Combinations of the free parameters."""
    noise_known: bool
    """False where the noise is what the fit left."""

    @classmethod
    def of(cls, fit: Fit, fixed: frozenset[str], states: LoadStates) -> tuple[Bench, WhitenedRuns]:
        """Return the bench of a fit, and all states against it, whitened."""
        noise = fit.noise or residual_noise(fit.data, fit.predicted)
        bench = cls(fit.robot, fixed | fit.left_at_neutral, noise, Basis(np.zeros((0, 0))), fit.noise is not None)
        data, about = bench._rows(states)
        basis = Basis.of(about.white[:-1])
        bench = cls(bench.robot, bench.fixed, noise, basis, bench.noise_known)
        return bench, _whitened_runs(data, about.space, about.white, about.residual, basis, len(states.runs))

    def whiten(self, states: LoadStates) -> WhitenedRuns:
        """Whiten other states against the same model, in the same combinations of its parameters.

        Raises
        ------
        NoBalanceError : the robot finds no balance under a load.
        """
        data, about = self._rows(states)
        return _whitened_runs(data, about.space, about.white, about.residual, self.basis, len(states.runs))

    def _rows(self, states: LoadStates) -> tuple[Observations, LoadRows]:
        data = observe(states, self.robot.chain)
        return data, LoadRows.about(self.robot, data, free_columns(self.robot, self.fixed), self.noise)


def first_order(states: LoadStates, robot: CompliantRobot, fixed: frozenset[str]) -> WhitenedRuns:
    """Hold states against no model but the columns of the undeformed chain: what no faulty run has pulled yet."""
    data = observe(states, robot.chain)
    unshaped = [placed for placed in robot.placed if lacks_nonlinear_value(placed)]
    columns = [
        column
        for column in free_columns(robot, fixed)
        if column.role is ParameterRole.AMPLITUDE and robot.placed[column.placed] not in unshaped
    ]
    weights = raw_whitening(data, stated_noise(states.setup.sigma, data))
    about = LoadRows.about(replace(robot, deformed=False), data, columns, weights)
    basis = Basis.of(about.white[:-1])
    return _whitened_runs(data, about.space, about.white, about.residual, basis, len(states.runs))


def _whitened_runs(
    data: Observations, projection: Projection, rows: Floats, residual: Floats, basis: Basis, n_runs: int
) -> WhitenedRuns:
    rows = rows.reshape(len(rows), *data.measured.shape)
    members = members_of(data.run, n_runs)
    counts = [data.measured_mask[:, own] for own in members]
    offsets = [int(mask.any(axis=1).sum()) if data.free_offset else 0 for mask in counts]
    dof = np.array(
        [int(mask.sum()) - n_offsets for mask, n_offsets in zip(counts, offsets, strict=True)], dtype=np.int64
    )
    blocks = RunBlocks.of(rows, basis, members, dof)
    return WhitenedRuns(data, tuple(members), projection, rows, residual, basis, blocks)
