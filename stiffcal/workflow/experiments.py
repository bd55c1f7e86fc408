"""What experiments beside load states (clamped robots, friction runs) add to the documents of a campaign.

A campaign may hold load states, such experiments, or both. Each kind makes one part for `identify` and one for
`validate`; the parts go into the documents beside what the load states say, or stand alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stiffcal.documents import document_of
from stiffcal.workflow.steps import Document, Ingested

if TYPE_CHECKING:
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


def merge_experiment_fits(document: Document, parts: Sequence[ExperimentFit]) -> Document:
    """Return an ``identify`` document with the parts of experiments in it."""
    if not parts:
        return document
    merged = dict(document)
    merged["model"] = document["model"] | {
        "effects": document["model"]["effects"] + [effect for part in parts for effect in part.effects]
    }
    for key in ("parameters", "not_identifiable", "warnings"):
        merged[key] = [*document[key], *(item for part in parts for item in getattr(part, key))]
    merged["rms"] = _merged(document["rms"], [part.rms for part in parts])
    noise = _merged(document["noise"] or dict(NOTHING), [part.noise for part in parts])
    merged["noise"] = noise if any(value is not None for value in noise.values()) else None
    if merged["noise_source"] == "none":
        merged["noise_source"] = next((part.noise_source for part in parts if part.noise_source != "none"), "none")
    merged["warnings"] = list(dict.fromkeys(merged["warnings"]))
    merged["free_parameters"], merged["covariance"] = document["free_parameters"], document["covariance"]
    for part in parts:
        merged["covariance"] = _independent_fits(merged["covariance"], part.covariance)
        merged["free_parameters"] = [*merged["free_parameters"], *part.free]
    return merged | {part.name: document_of(part.section) for part in parts}


def identify_without_states(balance: str, parts: Sequence[ExperimentFit]) -> Document:
    """Return the ``identify`` document of a campaign that holds no load states."""
    from stiffcal.identification.document import SCHEMA

    empty: Document = {
        "schema": SCHEMA,
        "warnings": [],
        "model": {"balance": balance, "effects": []},
        "parameters": [],
        "n_states": 0,
        "n_runs": sum(part.n_runs for part in parts),
        "n_readings": sum(part.n_readings for part in parts),
        "rms": {"translation": None, "rotation": None},
        "noise": None,
        "noise_source": "none",
        "reduced_chi2": next((part.reduced_chi2 for part in parts if part.reduced_chi2 is not None), None),
        "condition": max((part.condition for part in parts if part.condition is not None), default=None),
        "not_identifiable": [],
        "rejected": [],
        "free_parameters": [],
        "covariance": [],
        "correlation": [],
        "expected_rms": None,
        "expected_error": "; ".join(part.expected for part in parts if part.expected),
    }
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


def _independent_fits(one: list[list[float]], other: list[list[float]]) -> list[list[float]]:
    """Return the block-diagonal matrix of two square ones: separate experiments share no error."""
    wide = [row + [0.0] * len(other) for row in one]
    return wide + [[0.0] * len(one) + row for row in other]
