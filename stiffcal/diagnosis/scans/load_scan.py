"""The catalogue as additions to a model of load states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.scans.base_rows import BaseRows, bounds_of_candidate, in_order
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.drift import drift_of_states
from stiffcal.diagnosis.scans.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.scans.scan import Scan, Trial, scan_rows, try_candidate
from stiffcal.diagnosis.scans.scoring import score_variants
from stiffcal.diagnosis.scans.slips import best_slip, is_slip, load_stretches, score_in_run
from stiffcal.errors import Progress, no_progress
from stiffcal.estimation.unknowns import amplitudes
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import raw_whitening
from stiffcal.identification.fitting.regressors import Linearised, RegressorSource
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.measurements.load_states import members_of
from stiffcal.validation.heldout import search_folds

# A picometre, a picoradian: a fit that misses by less misses by rounding.
LEAST_RMS = 1e-12


@dataclass(frozen=True)
class LoadScan(Scan):
    """All candidates as additions to one model of load states."""

    fit: Fit
    """The model to which they are added."""
    space: Projection
    """Whitened rows."""
    fold_of_state: Integers
    """(n,) fold of each load state."""
    source: RegressorSource
    """Makes the regressors again that were not kept."""
    geometry: GeometryNuisance | None
    """Errors of the robot's geometry; None where they take no part."""

    @cached_property
    def own_rows(self) -> Floats:
        """(p, m · n) whitened rows of the base model's free parameters alone, for one forecast after the other."""
        return self.space.rows(self.own_columns)

    def known_before(self, kept: Booleans, k: int) -> Floats:
        """Return (r, k + 1) rows of what is known before of those of the model's own parameters (p,) that are fitted.

        They are the first of the k.
        """
        fit, p = self.fit, len(kept)
        # about neutral values of the others
        target = self.outside[:, -1] + self.outside[:, :p][:, ~kept] @ amplitudes(fit.robot, fit.columns)[~kept]
        rows = np.zeros((len(self.outside), k + 1))
        rows[:, : np.count_nonzero(kept)], rows[:, -1] = self.outside[:, :p][:, kept], target
        return rows

    def drift(self) -> tuple[float, float, float]:
        """Return `LackOfFit.drift`, its p-value and the correlation of successive residuals."""
        white = self.space.rows(self._without_sag()[None]).reshape(len(self.fit.data.measured), -1)
        found = drift_of_states(self.fit.data, white, self.residual_dof)
        return found.ratio, found.p_value, found.correlation[0]

    def _without_sag(self) -> Floats:
        """Return (m, n) the residual; where runs have a sag of their own, it and the model are fitted to them."""
        if self.geometry is None or not len(self.geometry.sag):
            return self.residual
        return np.asarray(self.residual - np.tensordot(self.base.solution, self.columns, axes=1))

    def mean_square(self) -> float:
        """Return the residuals' mean square over the first kind of readings, m² or rad²."""
        rows = self.fit.data.kind == self.fit.data.kind[0]
        return float(np.sum(np.where(self.fit.data.measured_mask[rows], self.fit.residual[rows], 0.0) ** 2))

    def release(self) -> None:
        """Let go of the model at rest."""
        self.source.release()


def fold_rows(data: Observations, fold: Integers) -> list[Integers]:
    """Return each fold's positions in whitened rows (m · n)."""
    return [_positions(data, members) for members in members_of(fold)]


def _positions(data: Observations, states: Integers) -> Integers:
    """Return the positions of states in whitened rows (m · n)."""
    return (np.arange(len(data.measured))[:, None] * data.n_states + states).ravel()


def weights_of(fit: Fit) -> Whitening:
    """Return the weights of the fit; where no noise is known, the residuals' own size by kind of row."""
    if fit.noise is not None:
        return fit.whitening
    data, size = fit.data, raw_whitening(fit.data, None).scale.copy()
    squares = np.where(data.measured_mask, fit.residual**2, 0.0)
    for kind in np.unique(data.kind):
        rows = data.kind == kind
        n_measured = max(1, int(np.count_nonzero(data.measured_mask[rows])))
        rms = max(float(np.sqrt(np.sum(squares[rows]) / n_measured)), LEAST_RMS)
        size[rows] = np.where(data.measured_mask[rows], 1.0 / rms, 0.0)
    return Whitening(size)


@dataclass(frozen=True)
class LoadGround:
    """A fit of load states to which candidates are added, one at a time."""

    scan: LoadScan
    """Without any candidate."""
    rows: BaseRows
    """The model's rows, fold after fold."""
    state: Linearised
    """The model at rest."""

    @classmethod
    def of(cls, fit: Fit, whitening: Whitening | None = None, geometry: GeometryNuisance | None = None) -> LoadGround:
        """Prepare; parameters as in `scan_candidates`."""
        data = fit.data
        source = RegressorSource(fit.robot, data)
        state = source.state()
        about = fit.linearised(weights_of(fit) if whitening is None else whitening, state)
        space, base_columns, residual = about.space, about.derivative, about.residual
        fold = search_folds(data)
        folds = fold_rows(data, fold)
        low, high = about.steps_within
        outside = about.prior
        if geometry is not None:
            nuisance = geometry.directions(space, base_columns)
            p, q = len(base_columns), len(nuisance)
            base_columns = np.concatenate([base_columns, nuisance])
            outside = np.insert(outside, [p] * q, 0.0, axis=1)
            outside = np.concatenate([outside, np.eye(q, p + q + 1, p)])
            free = np.full(q, np.inf)
            low, high = np.append(low, -free), np.append(high, free)
        stack = np.concatenate([base_columns, residual[None]])
        rows = BaseRows.of(state, space, stack, folds, low, high, outside)
        scan = LoadScan(
            fit=fit, base=in_order(rows.base, rows.order), trials=(), folds=tuple(folds), groups=rows.groups,
            dof=about.dof, n_columns=len(about.values), n_tried=1, space=space, columns=base_columns, residual=residual,
            bounds=(rows.low, rows.high), fold_of_state=fold, source=source, outside=outside,
            geometry=geometry,
        )  # fmt: skip
        return cls(scan, rows, state)

    def try_one(self, candidate: Candidate) -> Trial | None:
        """Try one candidate; None where it does not show."""
        return self._slip(candidate) if is_slip(candidate.effect) else try_candidate(candidate, self.rows)

    def _slip(self, candidate: Candidate) -> Trial | None:
        """Find the state where a slip explains most, and score it with everything else refitted."""
        scan, ground, data = self.scan, self.rows, self.scan.space.data
        first = best_slip(scan.space, scan.residual) if len(data.order.number) else None
        if first is None:
            return None
        regressor = self.state.regressor(candidate.effect, candidate.place, {"state": float(data.order.number[first])})
        products, bounds = ground.products(ground.rows_of(regressor)), ground.bounds(regressor)
        score = in_order(score_variants([products], *bounds, ground.groups, ground.base), ground.order)
        in_its_run = np.flatnonzero(data.run == data.run[first])
        stretches = load_stretches(data, in_its_run)
        plain = scan.leave_out([_positions(data, stretch) for stretch in stretches])
        *columns, fixed = scan.space.rows(np.concatenate([regressor.columns, regressor.fixed[None]]))
        slipped = plain.with_columns(np.array(columns), *bounds_of_candidate(regressor), fixed)
        number = int(np.searchsorted(np.unique(scan.fold_of_state), scan.fold_of_state[first]))
        score = score_in_run(score, ground.base, (plain, slipped), number, ground.groups)
        return Trial(candidate, regressor, score, data.n_states)


def scan_candidates(
    fit: Fit,
    candidates: Sequence[Candidate],
    whitening: Whitening | None = None,
    geometry: GeometryNuisance | None = None,
    progress: Progress = no_progress,
) -> LoadScan:
    """Try every candidate as an addition to the present fit.

    Parameters
    ----------
    fit : the present model's fit.
    candidates : who is tried.
    whitening : weights to use in place of the fit's own.
    geometry : errors of the robot's geometry, whose part of the residual no candidate explains.
    progress : receives each candidate.
    """
    ground = LoadGround.of(fit, whitening, geometry)
    trials, n_tried = scan_rows(ground.rows, candidates, ground.scan.source.kept, ground.try_one, progress)
    return replace(ground.scan, trials=trials, n_tried=n_tried)
