"""Whether one effect of the catalogue explains runs that stand apart better than a fault in each of them does.

An effect that shows in few poses, a play that only they cross or a cubic law under the largest torques, leaves runs
that stand apart just as a bumped target does. The difference is in the numbers: an effect explains the readings of all
those runs with one or two amplitudes and adds nothing to the other runs that they do not have; a bump explains one
reading with three. Both are compared by their squared misfit and what their free numbers cost: rank · log(1 + gain /
rank), a prior as broad as the effect found, and 2 log of how many there were to choose from.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate, list_candidates, variants
from stiffcal.diagnosis.slips import is_slip
from stiffcal.diagnosis.suspects.additive import Offset
from stiffcal.diagnosis.suspects.bench import Bench, Held
from stiffcal.diagnosis.suspects.influence import RIDGE
from stiffcal.identification.regressors import Linearised, Regressor
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.catalogue import built_in_effects

SMALLEST_SHARE = 1e-8  # of the largest direction of an effect's columns: below it they add nothing to the springs


@dataclass(frozen=True)
class RunFault:
    """A run as faulty."""

    run: int
    """Its number."""
    offset: Offset | None
    """The displacement that explains it; None where something else or nothing does."""
    cured_cost: float | None
    """Squared misfit with its mistake taken back, and what the choice of the mistake costs; None without a mistake."""


def explaining_effect(
    bench: Bench, held: Held, states: LoadStates, faults: Sequence[RunFault], unit: float
) -> Candidate | None:
    """Return the effect that explains these runs better than a fault in each does; None where none does.

    Parameters
    ----------
    bench : the model without these runs. held : all runs against it. states : of all runs.
    faults : the runs in question. unit : what one is in the scores, where the others are beyond their noise too.
    """
    limit = _cost_of_faults(held, faults, unit)
    state = Linearised.about(bench.robot, held.data)
    candidates, _ = list_candidates(bench.robot, states, built_in_effects())
    candidates = [candidate for candidate in candidates if not is_slip(candidate.effect)]
    springs = _Springs.of(held)
    best: Candidate | None = None
    for candidate in candidates:
        regressors = [one for one in variants(candidate, state, bench.robot.chain) if one.symbols]
        choice = 2.0 * log(max(len(regressors), 1)) + 2.0 * log(len(candidates))
        for cost in springs.costs(held, regressors, unit):
            if cost + choice < limit:
                best, limit = candidate, cost + choice
    return best


def _cost_of_faults(held: Held, faults: Sequence[RunFault], unit: float) -> float:
    """Return the squared misfit of all other runs, and what the faults leave and cost."""
    blocks, gone = held.blocks, [fault.run for fault in faults]
    kept = np.setdiff1d(np.arange(len(blocks.square)), gone)
    gram, right = blocks.gram[kept].sum(axis=0), blocks.right[kept].sum(axis=0)
    solved = np.linalg.solve(gram + RIDGE * np.eye(len(gram)), right)
    cost = float(blocks.square[kept].sum() - right @ solved) / unit**2
    deleted, freedom = blocks.deleted(gone) / unit**2, blocks.freedom(gone)
    for fault in faults:
        misfit, dof = float(deleted[fault.run]), max(int(freedom[fault.run]), 1)
        if fault.cured_cost is not None:
            cost += fault.cured_cost
        elif fault.offset is None:
            cost += dof * log(1.0 + misfit / dof)
        else:
            cost += max(misfit - fault.offset.gain / unit**2, 0.0) + fault.offset.penalty
    return cost + 2.0 * len(faults) * log(len(blocks.square))


@dataclass(frozen=True)
class _Springs:
    """What the present model can explain of all runs, as orthonormal rows, and what it leaves."""

    basis: Floats
    """(q, k) orthonormal rows of k whitened readings."""
    residual: Floats
    """(k,) what they leave of the readings."""

    @classmethod
    def of(cls, held: Held) -> _Springs:
        rows = np.einsum("pq,pmn->qmn", held.basis.combination, held.rows[:-1])
        basis = np.linalg.qr(rows.reshape(len(rows), -1).T)[0].T
        residual = held.rows[-1].ravel()
        return cls(basis, residual - (basis @ residual) @ basis)

    def costs(self, held: Held, regressors: Sequence[Regressor], unit: float) -> Iterator[float]:
        """Yield the squared misfit of all runs with each regressor fitted too, and the cost of its amplitudes."""
        for regressor in regressors:
            rows = held.projection.rows(np.concatenate([regressor.columns, regressor.fixed[None]]))
            rows = rows.reshape(len(rows), -1)
            rows = rows - (rows @ self.basis.T) @ self.basis
            columns, residual = rows[:-1], self.residual - rows[-1]
            amplitude, _, rank, _ = np.linalg.lstsq(columns.T, residual, rcond=SMALLEST_SHARE)
            if not rank or _impossible(regressor, amplitude):
                continue
            left = residual - amplitude @ columns
            misfit = float(left @ left) / unit**2
            gain = max(float(self.residual @ self.residual) / unit**2 - misfit, 0.0)
            yield misfit + rank * log(1.0 + gain / rank)


def _impossible(regressor: Regressor, amplitude: Floats) -> bool:
    """Return whether a compliance comes out negative."""
    return any(
        spec.compliance and spec.lower >= 0.0 and amplitude[regressor.symbols.index(spec.symbol)] < 0.0
        for spec in regressor.effect.parameters
        if spec.symbol in regressor.symbols
    )
