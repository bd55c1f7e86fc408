"""The model in poses left out of the fit.

Held out are *poses*: all runs whose joints agree within 1° fall into one fold, and a fold is left out whole.
Around the full fit the problem is linear to within a fraction of a standard uncertainty, so that leaving a fold out
needs no new fit (`stiffcal.estimation.leave_out`). An held-out run's constant offset (the error of its
reference) is the weighted mean of its own residuals, and the lost degree of freedom is counted by √(n/(n − 1)).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.constants import stretches
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Problem, fit_problem, raw_whitening
from stiffcal.identification.fitting.load_rows import LoadRows
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.noise.weights import without_offsets
from stiffcal.identification.readings.state_kinds import StateKind, kinds_of_observations
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.validation.schemes import HOLDOUT_RUNS, LEAVE_ONE_POSE_OUT


@dataclass(frozen=True)
class HeldoutResiduals:
    """Residuals in held-out poses."""

    scheme: str
    """One of `stiffcal.validation.schemes`, or "other campaign's model", or "none" (a single pose)."""
    residual: Floats
    """(m, n) measured minus predicted, the run's own offset taken out and √(n/(n − 1)) applied; base axes."""
    displacement: Floats
    """(m, n) measured displacement, its run's mean taken out in the same way: what no model at all leaves."""
    data: Observations
    """The observations judged."""
    fold: Integers
    """(n,) number of the pose."""


def joined_folds(data: Observations, folds_of: Callable[[StateKind], Callable[[Observations], Integers]]) -> Integers:
    """Return (n,) fold numbers of all states: those of each kind of experiment after those of the kind before.

    What a load moves is not what a place is off by: no fold holds states of two kinds.

    Parameters
    ----------
    folds_of : of a kind how its states are left out.
    """
    fold, first = np.zeros(data.n_states, dtype=np.int64), 0
    for kind, members in kinds_of_observations(data):
        own = folds_of(kind)(data if members.all() else data.subset(members))
        fold[members] = first + own
        first += int(own.max(initial=-1)) + 1
    return fold


def search_folds(data: Observations) -> Integers:
    """Return (n,) the folds over which effects are compared, numbered in the order of their first states.

    That order is the campaign's: resamplings draw by these numbers, whatever the kinds are called.
    """
    fold = joined_folds(data, lambda kind: kind.search_folds)
    _, first, number = np.unique(fold, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[number], dtype=np.int64)


def validation_folds(data: Observations) -> tuple[str, Integers]:
    """Return the scheme by which a campaign is validated, and (n,) its folds: each kind's own."""
    schemes = sorted({kind.scheme for kind, _ in kinds_of_observations(data)}, reverse=True)
    return "; ".join(schemes), joined_folds(data, lambda kind: kind.folds)


def heldout_residuals(states: LoadStates, fit: Fit) -> HeldoutResiduals:
    """Return the residuals in poses that were not used to fit.

    Parameters
    ----------
    states : the campaign's load states, runs held out among them.
    fit : the fit that is judged.
    """
    is_holdout = [info.holdout for info in states.runs]
    if any(is_holdout):
        return holdout_run_residuals(states, fit)
    scheme, fold = validation_folds(fit.data)
    if fold.max(initial=0) == 0:
        residual = corrected_for_freedom(fit.residual, fit.data)
        return HeldoutResiduals("none", residual, _without_model(fit.data, fit.whitening), fit.data, fold)
    return replace(left_out_residuals(fit, fold), scheme=scheme)


def holdout_run_residuals(states: LoadStates, fit: Fit) -> HeldoutResiduals:
    """Judge the runs that the manifest keeps back."""
    all_data = fit_problem(_all_runs(states), fit.robot).data
    in_holdout = np.array([info.holdout for info in states.runs], dtype=np.bool_)[all_data.run]
    data = all_data.subset(in_holdout)
    return _of_other(HOLDOUT_RUNS, fit, data)


def residuals_of_model(states: LoadStates, fit: Fit) -> HeldoutResiduals:
    """Judge every run by a model that was fitted elsewhere (``validate --model``)."""
    data = fit_problem(_all_runs(states), fit.robot).data
    return _of_other("other campaign's model", fit, data)


def _of_other(scheme: str, fit: Fit, data: Observations) -> HeldoutResiduals:
    """Judge observations that are not those of the fit."""
    space, residual = fit.residual_of(data)
    return HeldoutResiduals(
        scheme,
        corrected_for_freedom(residual, data),
        _without_model(data, space.whitening),
        data,
        search_folds(data),
    )


def _all_runs(states: LoadStates) -> LoadStates:
    return replace(states, runs=tuple(replace(info, holdout=False) for info in states.runs))


def corrected_for_freedom(residual: Floats, data: Observations) -> Floats:
    """Scale each run's residuals by √(n/(n − 1)) where its own offset was taken out."""
    if not data.free_offset:
        return residual
    edges = stretches(data.run)
    counts = np.diff(np.append(edges, data.n_states))
    readings = np.add.reduceat(data.measured_mask.any(axis=0).astype(np.int64), edges)
    factor = np.sqrt(readings / np.maximum(readings - 1, 1))
    return np.asarray(residual * np.repeat(factor, counts))


def _without_model(data: Observations, whitening: Whitening) -> Floats:
    if not data.free_offset:
        return data.measured
    return corrected_for_freedom(without_offsets(data, None, whitening), data)


def left_out_residuals(fit: Fit, fold: Integers) -> HeldoutResiduals:
    """Leave each fold out in turn, about the full fit.

    Parameters
    ----------
    fit : the full fit.
    fold : (n,) fold numbers; states of a run share one.
    """
    data = fit.data
    rows, problem = _leave_out(fit, fold)
    centred = rows.space.centred(rows.stack)
    residual = centred[-1].copy()
    for members, step in zip(members_of(fold), problem.steps, strict=True):
        residual[:, members] -= np.einsum("pmn,p->mn", centred[:-1][:, :, members], step)
    residual = corrected_for_freedom(residual, data)
    return HeldoutResiduals(LEAVE_ONE_POSE_OUT, residual, _without_model(data, rows.space.whitening), data, fold)


def estimates_without_each(fit: Fit, fold: Integers, name: str) -> Floats:
    """Return (F,) one parameter as it is estimated without each fold, about the full fit.

    NaN where the other folds do not determine it. The others keep within their bounds, as in each fit; it itself has
    none: an estimate kept at its limit would seem surer than it is.

    Parameters
    ----------
    fit : the full fit. fold : (n,) fold numbers; states of a run share one. name : of a free parameter.

    Raises
    ------
    ValueError : no free parameter has this name.
    """
    rows, problem = _leave_out(fit, fold)
    number = rows.unknowns.names.index(name)
    steps = problem.without_bounds(number).steps[:, number]
    return np.asarray(np.where(problem.determined(number), rows.values[number] + steps, np.nan), dtype=np.float64)


def changes_without_each(fit: Fit, fold: Integers) -> Floats:
    """Return (F, p) how far the free parameters of a fit move without each fold, in the order of its rows' unknowns.

    NaN where the other folds do not determine a parameter.

    Parameters
    ----------
    fit : the full fit. fold : (n,) fold numbers; states of a run share one.
    """
    problem = _leave_out(fit, fold)[1]
    return np.where(problem.all_determined, problem.steps, np.nan)


def _leave_out(fit: Fit, fold: Integers) -> tuple[LoadRows, LeaveOut]:
    """Return a fit's rows about its estimates, where they are linear, and folds (n,) of its states left out."""
    # of an unknown noise kinds of readings count by their own size, which no model changes: models are compared
    rows = fit.linearised(raw_whitening(fit.data, None) if fit.noise is None else None)
    positions = np.arange(rows.measured.size).reshape(rows.measured.shape)
    return rows, LeaveOut.of(rows, [positions[:, members].ravel() for members in members_of(fold)])


__all__ = [
    "HeldoutResiduals",
    "Problem",
    "changes_without_each",
    "estimates_without_each",
    "heldout_residuals",
    "holdout_run_residuals",
    "joined_folds",
    "left_out_residuals",
    "search_folds",
    "validation_folds",
]
