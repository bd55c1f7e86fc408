"""Whether one effect of the catalogue explains runs that stand apart better than a fault in each of them does.

An effect that shows in few poses, a play that only they cross or a cubic law under the largest torques, leaves runs
that stand apart just as a bumped target does. The difference is in the numbers: an effect explains the readings of all
those runs with one or two amplitudes and adds nothing to the other runs that they do not have; a bump explains one
reading with three. Both are compared by their squared misfit and what their free numbers cost: rank · log(1 + gain /
rank), a prior as broad as the effect found, and 2 log of how many there were to choose from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.diagnosis.scans.candidates import Candidate, list_candidates, variants
from stiffcal.diagnosis.scans.slips import is_slip
from stiffcal.diagnosis.suspects.additive import Offset
from stiffcal.diagnosis.suspects.whitened_runs import Bench, WhitenedRuns
from stiffcal.identification.fitting.regressors import Linearised, Regressor
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.catalogue.catalogue import built_in_effects

# Two amplitudes explain most of what one row of three readings may show: an effect has fewer than half as many as the
# runs in question have readings.
AMPLITUDES_PER_READING = 2
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
    bench: Bench, whitened: WhitenedRuns, states: LoadStates, faults: Sequence[RunFault], unit: float
) -> Candidate | None:
    """Return the effect that explains these runs better than a fault in each does; None where none does.

    What counts is the misfit of these runs against the others, with the effect in the model: an effect that improves
    all other runs and leaves these as they are explains no fault. Its amplitudes are free of cost as far as the other
    runs support them.

    Parameters
    ----------
    bench : the model without these runs. whitened : all runs against it. states : of all runs.
    faults : the runs in question. unit : what one is in the scores, where the others are beyond their noise too.
    """
    gone = np.isin(whitened.data.run, [fault.run for fault in faults])
    everything, others = _Springs.of(whitened, np.ones(len(gone), dtype=np.bool_)), _Springs.of(whitened, ~gone)
    state = Linearised.about(bench.robot, whitened.data)
    candidates, _ = list_candidates(bench.robot, states, built_in_effects())
    # a step in one run is a fault and an effect at once; a joint's whole compliance explains one run of anything
    candidates = [one for one in candidates if not (is_slip(one.effect) or one.effect.general)]
    best, least = None, _cost_of_faults(whitened, faults, unit)
    most = int(whitened.blocks.freedom([fault.run for fault in faults])[[fault.run for fault in faults]].sum())
    for candidate in candidates:
        regressors = [one for one in variants(candidate, state) if one.symbols]
        choice = 2.0 * log(max(len(regressors), 1)) + 2.0 * log(len(candidates))
        for regressor in regressors:
            rows = whitened.projection.rows(np.concatenate([regressor.columns, regressor.fixed[None]]))
            rows = rows.reshape(len(rows), *whitened.rows.shape[1:])
            fitted = everything.fitted(rows, regressor)
            if fitted is None:
                continue
            misfit, rank = fitted
            if AMPLITUDES_PER_READING * rank >= most:
                continue
            elsewhere = others.fitted(rows, regressor)
            misfit_elsewhere = others.misfit if elsewhere is None else elsewhere[0]
            gain = max(everything.misfit - misfit, 0.0) / unit**2
            supported = max(others.misfit - misfit_elsewhere, 0.0) / unit**2
            price = max(rank * log(1.0 + gain / rank) + choice - supported, 0.0)
            cost = max(misfit - misfit_elsewhere, 0.0) / unit**2 + price
            if cost < least:
                best, least = candidate, cost
    return best


def _cost_of_faults(whitened: WhitenedRuns, faults: Sequence[RunFault], unit: float) -> float:
    """Return what these runs leave with their faults taken back, and what the faults cost.

    A run that nothing explains counts as one with a noise of its own: dof (1 + log(misfit / dof)).
    """
    gone = [fault.run for fault in faults]
    deleted, freedom = whitened.blocks.deleted(gone) / unit**2, whitened.blocks.freedom(gone)
    cost = 2.0 * len(faults) * log(len(whitened.blocks.square))
    for fault in faults:
        misfit, dof = float(deleted[fault.run]), max(int(freedom[fault.run]), 1)
        if fault.cured_cost is not None:
            cost += fault.cured_cost
        elif fault.offset is not None:
            cost += max(misfit - fault.offset.gain / unit**2, 0.0) + fault.offset.penalty
        else:
            cost += dof * (1.0 + log(max(misfit / dof, 1.0)))
    return cost


@dataclass(frozen=True)
class _Springs:
    """What the present model can explain of some states, as orthonormal rows, and what it leaves."""

    chosen: Booleans
    """(n,) the states."""
    basis: Floats
    """(q, k) orthonormal rows of k whitened readings."""
    residual: Floats
    """(k,) what they leave of the readings."""

    @classmethod
    def of(cls, whitened: WhitenedRuns, chosen: Booleans) -> _Springs:
        rows = np.einsum("pq,pmn->qmn", whitened.basis.combination, whitened.rows[:-1][:, :, chosen])
        basis = np.linalg.qr(rows.reshape(len(rows), -1).T)[0].T
        residual = whitened.rows[-1][:, chosen].ravel()
        return cls(chosen, basis, residual - (basis @ residual) @ basis)

    @property
    def misfit(self) -> float:
        """Squared, without an effect."""
        return float(self.residual @ self.residual)

    def fitted(self, rows: Floats, regressor: Regressor) -> tuple[float, int] | None:
        """Return the squared misfit with an effect's whitened rows (q + 1, m, n) fitted too, and their rank.

        None where they add nothing to the model here, or only with a negative compliance.
        """
        own = rows[:, :, self.chosen].reshape(len(rows), -1)
        own = own - (own @ self.basis.T) @ self.basis
        columns, residual = own[:-1], self.residual - own[-1]
        amplitude, _, rank, _ = np.linalg.lstsq(columns.T, residual, rcond=SMALLEST_SHARE)
        if not rank or _impossible(regressor, amplitude):
            return None
        left = residual - amplitude @ columns
        return float(left @ left), int(rank)


def _impossible(regressor: Regressor, amplitude: Floats) -> bool:
    """Return whether a compliance comes out negative."""
    return any(
        spec.compliance and spec.lower >= 0.0 and amplitude[regressor.symbols.index(spec.symbol)] < 0.0
        for spec in regressor.effect.parameters
        if spec.symbol in regressor.symbols
    )
