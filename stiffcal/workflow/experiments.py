"""What experiments beside load states (clamped robots, friction runs) add to the documents of a campaign.

A campaign may hold load states, such experiments, or both. Each kind makes one part for `identify` and one for
`validate`; the parts go into the documents beside what the load states say, or stand alone.
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
    """Return what each kind of experiment that the campaign holds adds to ``identify``."""
    from stiffcal.experiments import all_kinds

    fits = [kind.fit(measured_runs(data)) for kind in all_kinds()]
    return [fit for fit in fits if fit is not None]


def validated_experiments(data: Ingested) -> list[ExperimentValidation]:
    """Return what each kind of experiment that the campaign holds adds to ``validate``."""
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


def merge_experiment_fits(result: IdentifyResult, parts: Sequence[ExperimentFit]) -> IdentifyResult:
    """Return what ``identify`` answers with the parts of experiments in it."""
    if not parts:
        return result
    noise = _merged(dict(NOTHING if result.noise is None else result.noise.items()), [part.noise for part in parts])
    sources = (result.noise_source, *(part.noise_source for part in parts))
    covariance = result.covariance
    for part in parts:
        covariance = _independent_fits(covariance, part.covariance)
    warnings = [*result.warnings, *(text for part in parts for text in part.warnings)]
    sections = {part.name: part.section for part in parts}
    clamped, friction = sections.pop("clamped", None), sections.pop("friction", None)
    return replace(
        result,
        warnings=list(dict.fromkeys(warnings)),
        model=replace(
            result.model, effects=[*result.model.effects, *(effect for part in parts for effect in part.effects)]
        ),
        parameters=[*result.parameters, *(parameter for part in parts for parameter in part.parameters)],
        not_identifiable=[*result.not_identifiable, *(group for part in parts for group in part.not_identifiable)],
        rms=Rms.of(_merged(dict(result.rms.items()), [part.rms for part in parts])),
        noise=Rms.of(noise) if any(value is not None for value in noise.values()) else None,
        noise_source=next((source for source in sources if source != "none"), "none"),
        free_parameters=[*result.free_parameters, *(name for part in parts for name in part.free)],
        covariance=covariance,
        clamped=cast("ClampedSection | None", clamped),
        friction=cast("FrictionSection | None", friction),
        other_kinds=sections,
    )


def identify_without_states(balance: Balance, parts: Sequence[ExperimentFit]) -> IdentifyResult:
    """Return what ``identify`` answers of a campaign that holds no load states."""
    empty = IdentifyResult(
        warnings=[],
        model=ModelSummary(balance, []),
        parameters=[],
        n_states=0,
        n_runs=sum(part.n_runs for part in parts),
        n_readings=sum(part.n_readings for part in parts),
        rms=Rms.of(NOTHING),
        noise=None,
        noise_source="none",
        reduced_chi2=next((part.reduced_chi2 for part in parts if part.reduced_chi2 is not None), None),
        condition=max((part.condition for part in parts if part.condition is not None), default=None),
        not_identifiable=[],
        rejected=[],
        free_parameters=[],
        covariance=[],
        correlation=[],
        expected_rms=None,
        expected_error="; ".join(part.expected for part in parts if part.expected),
    )
    return merge_experiment_fits(empty, parts)


def validation_with(document: Document, parts: Sequence[ExperimentValidation]) -> Document:
    """Return a ``validate`` document with the parts of experiments in it."""
    if not parts:
        return document
    merged = dict(document)
    for key, own in (("rms", "rms"), ("max", "largest"), ("relative", "relative"), ("zero_model", "zero_model")):
        merged[key] = _merged(document[key], [getattr(part, own) for part in parts])
    noise = _merged(document["noise"] or dict(NOTHING), [part.noise for part in parts])
    merged["noise"] = noise if any(value is not None for value in noise.values()) else None
    merged["warnings"] = [*document["warnings"], *(words for part in parts for words in part.warnings)]
    schemes = [document["scheme"] if document["n_states"] else "", *(f"{part.name}: {part.scheme}" for part in parts)]
    merged["scheme"] = "; ".join(one for one in schemes if one)
    for part in parts:
        for key, slices in part.by.items():
            merged[f"by_{key}"] = [*merged.get(f"by_{key}", []), *slices]
    return merged | {part.name: document_of(part.section) for part in parts}


def validation_of_experiments(parts: Sequence[ExperimentValidation]) -> Document:
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
    return validation_with(empty, parts)


def _merged(own: Document, others: Sequence[Document]) -> Document:
    """Join measures; where one measure comes from two kinds of experiment, the larger number stands."""
    found = dict(own)
    for other in others:
        for measure, value in other.items():
            present = found.get(measure)
            found[measure] = value if present is None else present if value is None else max(present, value)
    return found


def _independent_fits(first: Sequence[Sequence[Number]], second: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """Return the block-diagonal matrix of two square ones: separate experiments share no error."""
    wide = [[*row, *[0.0] * len(second)] for row in first]
    return wide + [[*[0.0] * len(first), *row] for row in second]
