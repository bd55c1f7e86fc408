"""What experiments other than load states (clamped robots, friction runs) add to the documents of a campaign.

A campaign may hold load states, such experiments, or both. Each kind makes one part for `identify` and one for
`validate`; the parts go into the documents next to the results of the load states, or stand alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from stiffcal.documents import Number, document_of
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Balance, ModelSummary
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.workflow.steps import Document, Ingested

if TYPE_CHECKING:
    from stiffcal.experiments.clamped.results import ClampedSection
    from stiffcal.experiments.friction.results import FrictionSection
    from stiffcal.experiments.measured import MeasuredRuns
    from stiffcal.experiments.results import ExperimentFit, ExperimentValidation

NOTHING: dict[str, float | None] = {"translation": None, "rotation": None}


def fit_experiments(data: Ingested) -> list[ExperimentFit]:
    """Return the fits of the kinds of experiment that the campaign holds, for ``identify``."""
    from stiffcal.experiments import all_kinds

    fits = [kind.fit(measured_runs(data)) for kind in all_kinds()]
    return [fit for fit in fits if fit is not None]


def validated_experiments(data: Ingested) -> list[ExperimentValidation]:
    """Return the validations of the kinds of experiment that the campaign holds, for ``validate``."""
    from stiffcal.experiments import all_kinds

    validations = [kind.validate(measured_runs(data)) for kind in all_kinds()]
    return [validation for validation in validations if validation is not None]


def measured_runs(data: Ingested) -> MeasuredRuns:
    """Return what kinds of experiment are asked about."""
    from stiffcal.experiments.measured import MeasuredRuns

    return MeasuredRuns(data.campaign, data.non_load, len(data.states), data.store.display_name)


def runs_with_fits(data: Ingested) -> MeasuredRuns:
    """Return the same with the tables of the present fit."""
    from stiffcal.experiments import tables_of_fits

    measured = measured_runs(data)
    fits = {name: data.store.read_table(name) for name in tables_of_fits() if name in data.store.tables}
    return replace(measured, tables={**measured.tables, **fits})


def merge_experiment_fits(result: IdentifyResult, fits: Sequence[ExperimentFit]) -> IdentifyResult:
    """Return the result of ``identify`` with the fits of experiments in it."""
    if not fits:
        return result
    noise = _merged(dict(NOTHING if result.noise is None else result.noise.items()), [fit.noise for fit in fits])
    sources = (result.noise_source, *(fit.noise_source for fit in fits))
    covariance = result.covariance
    for fit in fits:
        covariance = _independent_fits(covariance, fit.covariance)
    warnings = [*result.warnings, *(text for fit in fits for text in fit.warnings)]
    sections = {fit.name: fit.section for fit in fits}
    clamped, friction = sections.pop("clamped", None), sections.pop("friction", None)
    return replace(
        result,
        warnings=list(dict.fromkeys(warnings)),
        model=replace(
            result.model, effects=[*result.model.effects, *(effect for fit in fits for effect in fit.effects)]
        ),
        parameters=[*result.parameters, *(parameter for fit in fits for parameter in fit.parameters)],
        not_identifiable=[*result.not_identifiable, *(group for fit in fits for group in fit.not_identifiable)],
        rms=Rms.of(_merged(dict(result.rms.items()), [fit.rms for fit in fits])),
        noise=Rms.of(noise) if any(value is not None for value in noise.values()) else None,
        noise_source=next((source for source in sources if source != "none"), "none"),
        free_parameters=[*result.free_parameters, *(name for fit in fits for name in fit.free)],
        covariance=covariance,
        clamped=cast("ClampedSection | None", clamped),
        friction=cast("FrictionSection | None", friction),
        other_kinds=sections,
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
        rms=Rms.of(NOTHING),
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


def validation_with(document: Document, validations: Sequence[ExperimentValidation]) -> Document:
    """Return a ``validate`` document with the parts of experiments in it."""
    if not validations:
        return document
    merged = dict(document)
    for key, own in (("rms", "rms"), ("max", "largest"), ("relative", "relative"), ("zero_model", "zero_model")):
        merged[key] = _merged(document[key], [getattr(validation, own) for validation in validations])
    noise = _merged(document["noise"] or dict(NOTHING), [validation.noise for validation in validations])
    merged["noise"] = noise if any(value is not None for value in noise.values()) else None
    merged["warnings"] = [
        *document["warnings"],
        *(words for validation in validations for words in validation.warnings),
    ]
    schemes = [
        document["scheme"] if document["n_states"] else "",
        *(f"{validation.name}: {validation.scheme}" for validation in validations),
    ]
    merged["scheme"] = "; ".join(scheme for scheme in schemes if scheme)
    for validation in validations:
        for key, slices in validation.by.items():
            merged[f"by_{key}"] = [*merged.get(f"by_{key}", []), *slices]
    return merged | {validation.name: document_of(validation.section) for validation in validations}


def validation_of_experiments(validations: Sequence[ExperimentValidation]) -> Document:
    """Return the ``validate`` document of a campaign that holds no load states."""
    from stiffcal.validation.document import SCHEMA

    nothing: dict[str, Any] = {"translation": None, "rotation": None}
    empty: Document = {
        "schema": SCHEMA,
        "warnings": [],
        "scheme": "",
        "n_states": 0,
        "n_poses": 0,
        **{key: dict(nothing) for key in ("rms", "max", "relative", "zero_model")},
        "noise": None,
        **{f"by_{key}": [] for key in ("run", "direction", "load", "branch", "joint_angle")},
        "worst": [],
    }
    return validation_with(empty, validations)


def _merged(own: Document, additions: Sequence[Document]) -> Document:
    """Join measures; where one measure comes from two kinds of experiment, the larger number stands."""
    merged = dict(own)
    for addition in additions:
        for measure, value in addition.items():
            present = merged.get(measure)
            merged[measure] = value if present is None else present if value is None else max(present, value)
    return merged


def _independent_fits(first: Sequence[Sequence[Number]], second: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """Return the block-diagonal matrix of two square ones: separate experiments share no error."""
    wide = [[*row, *[0.0] * len(second)] for row in first]
    return wide + [[*[0.0] * len(first), *row] for row in second]
