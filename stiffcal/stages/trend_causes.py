"""What has changed between campaigns: what each worn joint and each change of the set-up would do to the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.diagnosis.scans.candidates import list_candidates
from stiffcal.diagnosis.scans.load_scan import scan_candidates
from stiffcal.estimation.unknowns import ParameterColumn
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.model.catalogue.campaign_effects import all_effects
from stiffcal.model.effect import Kind, ParameterRole
from stiffcal.stages.fit import fit_now
from stiffcal.validation.change_causes import USUAL_CHANGE, Hypothesis, cause_of, grew, grown_since, held_to_residuals

GAIN = "wrench-scale"
"""The effect that a gain of the force sensor is."""
USUAL_GAIN = 0.02
"""Sensors are calibrated to 1 or 2 % of full scale."""

if TYPE_CHECKING:
    from stiffcal.arrays import Floats
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.model.effect import Effect
    from stiffcal.stages.fitted_campaign import FittedCampaign
    from stiffcal.stages.steps import RunContext
    from stiffcal.validation.charted_parameter import ChartedParameter
    from stiffcal.validation.trend_result import ChangeCause


def change_cause(
    campaigns: Sequence[FittedCampaign],
    charted: Sequence[ChartedParameter],
    since: int,
    alarmed: set[int],
    context: RunContext,
) -> ChangeCause | None:
    """Return what a change of the parameters can come from; None where nothing can be compared.

    Parameters
    ----------
    campaigns : in order of time.
    charted : the parameters that all of them know.
    since : number of the first campaign after the change.
    alarmed : joints of which a parameter raised an alarm.
    context : progress.
    """
    fit = fit_now(campaigns[-1].data, campaigns[-1].fit.loss, context)
    if fit is None:
        return None
    columns = fit.columns
    free = [_name(fit, column) for column in columns]
    of_fit = [one for one in charted if one.name in free and one.name in campaigns[-1].fit.free_parameters]
    names = [one.name for one in of_fit]
    sizes = np.array([_mean_size(one) for one in of_fit])
    change = np.array([_amplitudes(one)[since:].mean() - _amplitudes(one)[:since].mean() for one in of_fit])
    hypotheses = _of_joints(campaigns[-1], names, sizes, alarmed)
    hypotheses += _of_own_set_up(fit, names)
    where = [free.index(name) for name in names]
    effects = _set_up_effects(campaigns[-1], fit)
    hypotheses += [Hypothesis(rows[:, where], effect=name) for name, rows in _taken_up(fit, columns, effects).items()]
    if not hypotheses:
        return None
    covariance = _covariance(campaigns, of_fit, sizes, since)
    # in units of each parameter's own size: numbers near one
    scaled = [Hypothesis(h.directions / sizes, h.joints, h.effect) for h in hypotheses]
    misfit = [campaign.fit.reduced_chi2 for campaign in campaigns]
    grown = grown_since(misfit, since)
    cause = cause_of(change / sizes, covariance / np.outer(sizes, sizes), scaled, since, grown is not None)
    if grown is None:
        return cause
    before = [value for value in misfit[:grown] if value is not None]
    return held_to_residuals(cause, *_restoring(campaigns[-1], fit, before))


def _restoring(
    campaign: FittedCampaign, fit: Fit, before: Sequence[float]
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the χ² that effects leave which the model lacks and with which the residuals have not grown.

    First of the set-up, by effect, then of joints and links, by effect and place. General laws take no part: their many
    values mimic what a change of the set-up does.

    Parameters
    ----------
    campaign : the last one. fit : its fit.
    before : reduced χ² of the campaigns before the change.
    """
    catalogue, _ = all_effects(campaign.data.campaign)
    candidates, _ = list_candidates(fit.robot, campaign.data.states, catalogue)
    scan = scan_candidates(fit, [candidate for candidate in candidates if not candidate.effect.general])
    set_up: dict[str, float] = {}
    elsewhere: dict[str, float] = {}
    for trial in scan.trials:
        left = trial.score.sum_of_squares
        dof = scan.residual_dof - trial.candidate.n_parameters
        if dof < 1 or grew([*before, left / dof], len(before)):
            continue
        if trial.candidate.place.kind == "setup":
            set_up[trial.candidate.effect.name] = left
        else:
            elsewhere[trial.candidate.name] = left
    return set_up, elsewhere


def _name(fit: Fit, column: ParameterColumn) -> str:
    return fit.robot.placed[column.placed].parameter_name(column.symbol)


def _amplitudes(one: ChartedParameter) -> Floats:
    return np.exp(one.values) if one.relative else one.values


def _mean_size(one: ChartedParameter) -> float:
    return float(np.mean(np.abs(_amplitudes(one)))) or 1.0


def _covariance(
    campaigns: Sequence[FittedCampaign], charted: Sequence[ChartedParameter], sizes: Floats, since: int
) -> Floats:
    """Return the (p, p) covariance of the difference of both means: of the fits, and what varies between campaigns."""
    from stiffcal.validation.charted_parameter import deviation_of

    of_fits = []
    for campaign in campaigns:
        free = campaign.fit.free_parameters
        pick = [free.index(one.name) for one in charted]
        matrix = np.array(campaign.fit.covariance, dtype=np.float64).reshape(len(free), len(free))
        of_fits.append(matrix[np.ix_(pick, pick)])
    within = np.mean(of_fits, axis=0)
    total = np.array([deviation_of(one, since) for one in charted])
    total = np.where([one.relative for one in charted], total * sizes, total)
    between = np.maximum(total**2 - np.diag(within), 0.0)
    means = 1.0 / since + 1.0 / (len(campaigns) - since)
    return np.asarray((within + np.diag(between)) * means)


def _of_joints(campaign: FittedCampaign, names: Sequence[str], sizes: Floats, alarmed: set[int]) -> list[Hypothesis]:
    """Return each joint alone, each two of them, and all those with an alarm together."""
    joint_of = {
        p.name: p.where.joints[0] for p in campaign.fit.parameters if p.where.joints and len(p.where.joints) == 1
    }
    joints = sorted(set(joint_of.values()))
    groups: list[tuple[int, ...]] = [(joint,) for joint in joints]
    groups += combinations(joints, 2)
    if len(alarmed) > 2:
        groups.append(tuple(sorted(alarmed)))
    hypotheses = []
    for group in groups:
        rows = [number for number, name in enumerate(names) if joint_of.get(name) in group]
        if rows:
            hypotheses.append(Hypothesis(USUAL_CHANGE * np.diag(sizes)[rows], joints=group))
    return hypotheses


def _of_own_set_up(fit: Fit, names: Sequence[str]) -> list[Hypothesis]:
    """Return the effects of the set-up that the model holds: their own parameters would change."""
    hypotheses = []
    for placed in fit.robot.placed:
        specs = {placed.parameter_name(spec.symbol): spec for spec in placed.effect.parameters}
        rows = [number for number, name in enumerate(names) if name in specs]
        if placed.place.kind != "setup" or not rows:
            continue
        usual = [abs(specs[name].amplitude_of(specs[name].typical)) if name in specs else 0.0 for name in names]
        hypotheses.append(Hypothesis(np.diag(usual)[rows], effect=placed.effect.name))
    return hypotheses


def _set_up_effects(campaign: FittedCampaign, fit: Fit) -> list[Effect]:
    """Return the effects of the set-up that the model does not hold and that have a size and no further shape."""
    catalogue, _ = all_effects(campaign.data.campaign)
    candidates, _ = list_candidates(fit.robot, campaign.data.states, catalogue)
    return [
        candidate.effect
        for candidate in candidates
        if candidate.place.kind == "setup"
        and all(spec.role is not ParameterRole.NONLINEAR for spec in candidate.effect.parameters)
    ]


def _taken_up(fit: Fit, columns: Sequence[ParameterColumn], effects: Sequence[Effect]) -> dict[str, Floats]:
    """Return by effect the (q, p) change of all free parameters per usual size of each of its q parameters.

    Least squares without the effect's columns E gives β̂ = β + (XᵀWX)⁻¹XᵀWE γ: the bias of an omitted variable. A gain
    of the whole load, which no residual shows, makes every compliance grow by the same share.
    """
    state = Linearised.about(fit.robot, fit.data)
    about = fit.linearised(at_rest=state)
    design = about.white[:-1]
    found = {GAIN: _of_gain(fit, columns)}
    for effect in effects:
        regressor = state.regressor(effect, effect.places(fit.robot.chain)[0], {})
        if not regressor.symbols:
            continue
        usual = np.array([abs(effect.spec(s).amplitude_of(effect.spec(s).typical)) for s in regressor.symbols])
        shift = np.linalg.lstsq(design.T, about.space.rows(regressor.columns).T, rcond=None)[0].T
        found[effect.name] = np.concatenate([found.get(effect.name, shift[:0]), usual[:, None] * shift])
    return found


def _of_gain(fit: Fit, columns: Sequence[ParameterColumn]) -> Floats:
    row = np.zeros((1, len(columns)))
    for number, column in enumerate(columns):
        placed = fit.robot.placed[column.placed]
        if placed.effect.kind is Kind.NODE_LAW and column.role is ParameterRole.AMPLITUDE:
            row[0, number] = USUAL_GAIN * placed.amplitude(column.symbol)
    return row
