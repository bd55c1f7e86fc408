"""Friction of the drives in the documents: fitted, judged at speeds that the fit has not used, drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.friction.answers.curves import FRICTION_FIT, FRICTION_HELDOUT
from stiffcal.kinds.friction.answers.documents import (
    bearing_frictions,
    effects_in_model,
    error_slice,
    expected_words,
    fit_table,
    friction_warnings,
    gaps,
    heldout_table,
    identified_friction,
    joint_friction,
    lacking_motion,
    noise_of_fit,
    rms_of,
    unknown_parameters,
)
from stiffcal.kinds.friction.answers.results import FrictionSection
from stiffcal.kinds.friction.reduction import FREE_MOTION, FRICTION, FRICTION_SAMPLES
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.kinds.results import ExperimentFit, ExperimentValidation
from stiffcal.measurements.rms import VarianceRatio
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.campaign_effects import moving_effects
from stiffcal.model.effect import Place

if TYPE_CHECKING:
    from stiffcal.identification.answers.fit_results import IdentifiedParameter
    from stiffcal.kinds.friction.fitting.heldout import JudgedFriction
    from stiffcal.kinds.friction.fitting.joint_fits import FrictionFit
    from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows
    from stiffcal.kinds.friction.logs.readings import FreeMotion, SteadyReadings
    from stiffcal.kinds.row_search import RowProblem
    from stiffcal.presentation.values import Picture


def friction_experiment_fit(data: MeasuredRuns) -> ExperimentFit | None:
    """Fit the friction of every drive that the model gives friction and that friction runs have moved.

    Returns None where the campaign contains no friction run.

    Raises
    ------
    InputError
        The model holds no friction and nothing else could be fitted.
    """
    from stiffcal.kinds.friction.fitting.joint_fits import fit_friction

    readings = friction_readings(data)
    if readings == (None, None):
        return None
    placed = moving_effects(data.campaign)
    if not placed:
        return _without_effect(data)
    rows = friction_rows(data)
    usable = rows is not None and bool(
        np.isin(rows.joint, [placed_effect.place.joints[0] for placed_effect in placed]).any()
    )
    if rows is None or not usable:
        return _nothing_identified(data, placed)
    fixed = _fixed(data)
    fit = fit_friction(rows.select(~heldout_runs(data, rows)), placed, data.campaign.chain, fixed)
    return _part(data, fit, placed)


def friction_readings(data: MeasuredRuns) -> tuple[SteadyReadings | None, FreeMotion | None]:
    """Return the friction runs that the store holds."""
    from stiffcal.kinds.friction.logs.readings import motion_from_table, steady_from_table

    return data.read(FRICTION, steady_from_table), data.read(FREE_MOTION, motion_from_table)


def friction_rows(data: MeasuredRuns) -> FrictionRows | None:
    """Return the equations of all friction runs, None where no reading is used."""
    from stiffcal.kinds.friction.fitting.torque_rows import motion_rows, stacked_rows, steady_rows
    from stiffcal.kinds.friction.logs.samples import samples_from_table

    motion = friction_readings(data)[1]
    samples = data.read(FRICTION_SAMPLES, samples_from_table)
    tables = []
    if samples is not None and len(samples):
        tables.append(steady_rows(samples))
    if motion is not None and motion.one_way.any():
        tables.append(motion_rows(motion, data.campaign.chain))
    return stacked_rows(tables) if tables else None


def friction_validation(data: MeasuredRuns) -> ExperimentValidation | None:
    """Judge friction at speeds that the fit has not used; None where the campaign contains no friction.

    What the model does not describe counts with all of its torque: an effect that is taken out raises the error.
    """
    from stiffcal.kinds.friction.fitting.heldout import joints_without_law

    rows, placed = friction_rows(data), moving_effects(data.campaign)
    if rows is None:
        return None
    modelled = np.isin(rows.joint, [placed_effect.place.joints[0] for placed_effect in placed])
    parts, tables = [], {}
    if modelled.any():
        with_law = rows.select(modelled)
        parts.append(_judged_friction(data, with_law, placed))
        tables[FRICTION_HELDOUT] = heldout_table(data, with_law, parts[0].residual)
    if not modelled.all():
        parts.append(joints_without_law(rows.select(~modelled), data.campaign.chain))
    names = data.joint_names
    residual, size, joint, run = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("residual", "size", "joint", "run")
    )
    judged = np.isfinite(residual)
    by_joint = [error_slice(names[j - 1], residual[judged & (joint == j)]) for j in np.unique(joint[judged])]
    by_run = [error_slice(str(r), residual[judged & (run == r)]) for r in dict.fromkeys(run[judged].tolist())]
    rms, zero = rms_of(residual[judged]), rms_of(size[np.isfinite(size)])
    squares = [part.noise**2 * len(part.joint) for part in parts if part.noise is not None]
    noise: dict[str, float | None] = {"torque": float(np.sqrt(sum(squares) / len(joint)))}
    return ExperimentValidation(
        name="friction",
        scheme=parts[0].scheme,
        rms={"torque": rms},
        max={"torque": float(np.abs(residual[judged]).max())},
        noise=noise if len(squares) == len(parts) else {},
        relative={"torque": rms / zero if zero else None},
        zero_model={"torque": zero},
        by={"run": by_run, "joint": by_joint},
        section_scheme=parts[0].scheme,
        n_readings=int(judged.sum()),
        warnings=[warning for part in parts for warning in part.warnings],
        tables=tables,
    )


def _judged_friction(data: MeasuredRuns, rows: FrictionRows, placed: tuple[PlacedEffect, ...]) -> JudgedFriction:
    """Return the error at speeds that the fit has not used, of joints with an effect."""
    from stiffcal.kinds.friction.fitting.heldout import JudgedFriction, heldout_friction
    from stiffcal.kinds.friction.fitting.joint_fits import fit_friction

    fixed, held_out = _fixed(data), heldout_runs(data, rows)
    chain = data.campaign.chain
    fit = fit_friction(rows.select(~held_out), placed, chain, fixed)
    heldout = heldout_friction(rows, fit, held_out)
    residual, warnings = heldout.residual, []
    if heldout.scheme == "none":
        warnings.append("friction: fewer than three speeds; this is the error of the fit")
        residual = np.full(len(rows), np.nan)
        residual[~held_out] = fit.residual
    size = np.full(len(rows), np.nan)
    size[~held_out] = fit.friction_measured
    return JudgedFriction(
        rows.joint, rows.run, residual, size, noise_of_fit(fit).get("torque"), heldout.scheme, tuple(warnings)
    )


def problems_of(data: MeasuredRuns) -> tuple[RowProblem, ...]:
    """Return the rows in which the diagnosis looks for missing effects, runs held out left aside."""
    from stiffcal.kinds.friction.answers.problem import friction_problems

    rows = friction_rows(data)
    if rows is None:
        return ()
    index = np.flatnonzero(~heldout_runs(data, rows))
    placed = moving_effects(data.campaign)
    if not len(index):
        return ()
    return friction_problems(rows.select(index), index, placed, data.campaign.chain, _fixed(data))


def friction_evidence(data: MeasuredRuns) -> list[Picture]:
    """Return the pictures of effects of moving joints that are missing, or in the model on top of joint-friction."""
    from stiffcal.campaign.model.model_file import default_model
    from stiffcal.kinds.friction.answers.evidence import evidence_pictures
    from stiffcal.model.catalogue.campaign_effects import all_effects
    from stiffcal.model.motion import Motion

    rows, placed = friction_rows(data), moving_effects(data.campaign)
    if rows is None:
        return []
    catalogue, _ = all_effects(data.campaign)
    missing = [
        PlacedEffect(catalogue[at.effect], Place("joints", (at.where.joints[0],)))
        for at in data.missing
        if at.effect in catalogue and isinstance(catalogue[at.effect], Motion) and at.where.joints
    ]
    basic = [entry.type for entry in default_model(data.campaign.chain.n_joints, {FRICTION}).effects]
    fitted = rows.select(~heldout_runs(data, rows))
    return evidence_pictures(fitted, data.campaign.chain, placed, missing, basic)


def _fixed(data: MeasuredRuns) -> frozenset[str]:
    from stiffcal.model.assembled.assembly import fixed_parameters

    return fixed_parameters(data.campaign.model)


def heldout_runs(data: MeasuredRuns, rows: FrictionRows) -> NDArray[np.bool_]:
    """Return (k,) True for the rows of runs that no fit uses."""
    runs = [run.id for run in data.campaign.manifest.runs if run.holdout]
    return np.isin(rows.run, runs)


def _without_effect(data: MeasuredRuns) -> ExperimentFit | None:
    """Say that friction was measured and is not in the model; where nothing else is measured, refuse."""
    from stiffcal.campaign.model.model_file import default_model

    first = default_model(data.campaign.chain.n_joints, {FRICTION}).effects[0].type
    mend = command_line("add", data.campaign.folder, first, "--all")
    if data.n_states == 0:
        raise InputError.at(
            FaultCode.MODEL_UNSUITABLE,
            "model.toml",
            "effects",
            "the campaign contains friction runs, but the model no friction",
            mend,
        )
    return ExperimentFit(
        name="friction",
        section=FrictionSection(joints=[]),
        warnings=[f"friction runs are not used: the model contains no friction ({mend})"],
    )


def _nothing_identified(data: MeasuredRuns, placed: tuple[PlacedEffect, ...]) -> ExperimentFit:
    return ExperimentFit(
        name="friction",
        section=FrictionSection(joints=[]),
        parameters=[parameter for effect in placed for parameter in unknown_parameters(effect)],
        not_identifiable=gaps(data, friction_readings(data)[0], placed, set()),
        effects=effects_in_model(placed),
        expected="no friction is identifiable from these runs",
    )


def _lack_of_fit(fit: FrictionFit) -> VarianceRatio | None:
    """Return the residual's variance over that of repeats; None where these are too few."""
    from scipy.special import chdtrc

    if fit.reduced_chi2 is None:
        return None
    p_value = float(chdtrc(fit.dof, fit.dof * fit.reduced_chi2))
    return VarianceRatio(statistic=fit.reduced_chi2, dof=[fit.dof, None], p_value=p_value)


def _part(data: MeasuredRuns, fit: FrictionFit, placed: tuple[PlacedEffect, ...]) -> ExperimentFit:
    """Return the part of a fit."""
    by_joint = {joint_result.joint: joint_result for joint_result in fit.joints}
    found = {one.name: one for joint_result in fit.joints for one in identified_friction(joint_result)}
    parameters: list[IdentifiedParameter] = []
    for placed_effect in placed:
        names = [placed_effect.parameter_name(spec.symbol) for spec in placed_effect.effect.parameters]
        if placed_effect.place.joints[0] not in by_joint:
            parameters += unknown_parameters(placed_effect)
        else:
            parameters += [found[name] for name in names]
    section = FrictionSection(
        effects=[effect.type for effect in effects_in_model(placed)],
        joints=[joint_friction(data, fit, joint_result, placed) for joint_result in fit.joints],
        lack_of_fit=_lack_of_fit(fit),
        bearings=bearing_frictions(fit),
    )
    free = [name for joint_result in fit.joints for name in joint_result.free]
    covariance = np.zeros((len(free), len(free)))
    done = 0
    for one_joint in fit.joints:
        span = slice(done, done + len(one_joint.free))
        covariance[span, span] = one_joint.covariance
        done = span.stop
    unidentified = gaps(data, friction_readings(data)[0], placed, set(by_joint)) + lacking_motion(data, fit)
    return ExperimentFit(
        name="friction",
        section=section,
        parameters=parameters,
        not_identifiable=unidentified,
        effects=effects_in_model(placed),
        rms={"torque": rms_of(fit.residual)},
        noise=noise_of_fit(fit),
        noise_source="neighbours" if any(joint_result.noise is not None for joint_result in fit.joints) else "none",
        n_runs=len(set(fit.rows.run.tolist())),
        n_readings=len(fit.rows),
        reduced_chi2=fit.reduced_chi2,
        condition=fit.condition,
        expected=expected_words(fit),
        warnings=friction_warnings(data, fit),
        tables={FRICTION_FIT: fit_table(data, fit)},
        free=free,
        covariance=covariance.tolist(),
    )
