"""What experiments other than load states (clamped robots, friction runs) add to the documents of a campaign.

A campaign may hold load states, such experiments, or both. Each kind makes one part for `identify` and one for
`validate`; the parts go into the documents next to the results of the load states, or stand alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stiffcal.documents import Number
from stiffcal.measurements.rms import Rms
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.summary import Balance, ModelSummary
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.steps import Ingested, kept_table

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.kinds import ExperimentKind
    from stiffcal.kinds.measured import MeasuredRuns
    from stiffcal.kinds.results import ExperimentFit, ExperimentValidation
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.results.validate_result import ValidateResult


def fit_experiments(data: Ingested) -> list[ExperimentFit]:
    """Return the fits of the kinds of experiment that the campaign holds, for ``identify``."""
    fits = [kind.fit(measured_runs(data)) for kind in _kinds_of(data)]
    return [fit for fit in fits if fit is not None]


def validated_experiments(data: Ingested) -> list[ExperimentValidation]:
    """Return the validations of the kinds of experiment that the campaign holds, for ``validate``."""
    validations = [kind.validate(measured_runs(data)) for kind in _kinds_of(data)]
    return [validation for validation in validations if validation is not None]


def _kinds_of(data: Ingested) -> tuple[ExperimentKind, ...]:
    """Return the kinds of experiment that are asked; none where all runs gave load states alone.

    Kinds without tables of their own have no answers of their own, and what answers for the others is not imported.
    """
    from stiffcal.kinds import all_kinds

    return all_kinds() if data.non_load else ()


def measured_runs(data: Ingested) -> MeasuredRuns:
    """Return the kinds of experiment that are requested."""
    from stiffcal.kinds.measured import MeasuredRuns

    return MeasuredRuns(data.campaign, data.non_load, len(data.states), data.store.display_name)


def runs_with_fits(data: Ingested) -> MeasuredRuns:
    """Return the same with the tables of the present fit."""
    from stiffcal.kinds import tables_of_fits

    measured = measured_runs(data)
    fits = {name: data.store.read_table(name) for name in tables_of_fits() if name in data.store.tables}
    return replace(measured, tables={**measured.tables, **fits})


def kept_of_kinds(tables: Mapping[str, pa.Table], key: str) -> dict[str, pa.Table]:
    """Return those of a fit's tables that stay in the store for every fit of the history, under their lasting names.

    Parameters
    ----------
    tables : of the fit or its validation, by name. key : of the fit.
    """
    from stiffcal.kinds import tables_kept

    return {kept_table(name, key): tables[name] for name in tables_kept() if name in tables}


def robot_to_fit(data: Ingested) -> CompliantRobot:
    """Return the campaign's robot and effects, with the values that the model file or a kind of experiment gives."""
    robot = placed_robot(data.campaign)
    for kind in _kinds_of(data):
        robot = robot.with_values(kind.starting_values(measured_runs(data), robot))
    return robot


def merge_experiment_fits(result: IdentifyResult, fits: Sequence[ExperimentFit]) -> IdentifyResult:
    """Return the result of ``identify`` with the fits of experiments in it."""
    if not fits:
        return result
    noise = merged_measures(result.noise, [fit.noise for fit in fits])
    sources = (result.noise_source, *(fit.noise_source for fit in fits))
    covariance = result.covariance
    for fit in fits:
        covariance = _independent_fits(covariance, fit.covariance)
    warnings = [*result.warnings, *(text for fit in fits for text in fit.warnings)]
    return replace(
        result,
        warnings=list(dict.fromkeys(warnings)),
        model=replace(
            result.model, effects=[*result.model.effects, *(effect for fit in fits for effect in fit.effects)]
        ),
        parameters=[*result.parameters, *(parameter for fit in fits for parameter in fit.parameters)],
        not_identifiable=[*result.not_identifiable, *(group for fit in fits for group in fit.not_identifiable)],
        rms=merged_measures(result.rms, [fit.rms for fit in fits]),
        noise=noise if any(value is not None for _, value in noise.items()) else None,
        noise_source=next((source for source in sources if source != "none"), "none"),
        free_parameters=[*result.free_parameters, *(name for fit in fits for name in fit.free)],
        covariance=covariance,
        sections={fit.name: fit.section for fit in fits},
    )


def identify_without_states(balance: Balance, fits: Sequence[ExperimentFit]) -> IdentifyResult:
    """Return the result of ``identify`` for a campaign that holds no load states."""
    empty = IdentifyResult(
        warnings=[],
        model=ModelSummary(balance, []),
        parameters=[],
        n_states=0,
        n_runs=sum(fit.n_runs for fit in fits),
        n_readings=sum(fit.n_readings for fit in fits),
        rms=Rms(None, None),
        noise=None,
        noise_source="none",
        reduced_chi2=next((fit.reduced_chi2 for fit in fits if fit.reduced_chi2 is not None), None),
        condition=max((fit.condition for fit in fits if fit.condition is not None), default=None),
        not_identifiable=[],
        rejected=[],
        free_parameters=[],
        covariance=[],
        correlation=[],
        expected_rms=None,
        expected_error="; ".join(fit.expected for fit in fits if fit.expected),
    )
    return merge_experiment_fits(empty, fits)


def merge_experiment_validations(result: ValidateResult, validations: Sequence[ExperimentValidation]) -> ValidateResult:
    """Return the result of ``validate`` with the validations of experiments in it."""
    if not validations:
        return result
    noise = merged_measures(result.noise, [validation.noise for validation in validations])
    schemes = [
        result.scheme if result.n_states else "",
        *(f"{validation.name}: {validation.scheme}" for validation in validations),
    ]
    return replace(
        _with_slices(result, validations),
        warnings=[*result.warnings, *(text for validation in validations for text in validation.warnings)],
        scheme="; ".join(scheme for scheme in schemes if scheme),
        rms=merged_measures(result.rms, [validation.rms for validation in validations]),
        max=merged_measures(result.max, [validation.max for validation in validations]),
        noise=noise if any(value is not None for _, value in noise.items()) else None,
        relative=merged_measures(result.relative, [validation.relative for validation in validations]),
        zero_model=merged_measures(result.zero_model, [validation.zero_model for validation in validations]),
        sections={validation.name: validation.section for validation in validations},
    )


def _with_slices(result: ValidateResult, validations: Sequence[ExperimentValidation]) -> ValidateResult:
    """Return the result with the slices of experiments after those of the load states."""
    for validation in validations:
        for by, slices in validation.by.items():
            name = f"by_{by}"
            changed: dict[str, Any] = {name: [*(getattr(result, name) or []), *slices]}
            result = replace(result, **changed)
    return result


def validate_without_states(validations: Sequence[ExperimentValidation]) -> ValidateResult:
    """Return the result of ``validate`` for a campaign that holds no load states."""
    from stiffcal.results.validate_result import ValidateResult

    nothing = Rms(None, None)
    empty = ValidateResult(
        warnings=[],
        scheme="",
        n_states=0,
        n_poses=0,
        rms=nothing,
        max=nothing,
        noise=None,
        relative=nothing,
        zero_model=nothing,
        by_run=[],
        by_direction=[],
        by_load=[],
        by_branch=[],
        by_joint_angle=[],
        worst=[],
    )
    return merge_experiment_validations(empty, validations)


def merged_measures(own: Rms | None, additions: Sequence[Mapping[str, Number]]) -> Rms:
    """Join measures; where one measure comes from two kinds of experiment, the larger number stands."""
    merged = dict((Rms(None, None) if own is None else own).items())
    for addition in additions:
        for measure, value in addition.items():
            present = merged.get(measure)
            merged[measure] = value if present is None else present if value is None else max(present, value)
    return Rms.of(merged)


def _independent_fits(first: Sequence[Sequence[Number]], second: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """Return the block-diagonal matrix of two square ones: separate experiments share no error."""
    wide = [[*row, *[0.0] * len(second)] for row in first]
    return wide + [[*[0.0] * len(first), *row] for row in second]
