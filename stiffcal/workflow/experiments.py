"""What experiments beside load states (clamped robots, friction runs) add to the documents of a campaign.

A campaign may hold load states, such experiments, or both. Each kind makes one part for `identify` and one for
`validate`; the parts go into the documents beside what the load states say, or stand alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stiffcal.documents import document_of
from stiffcal.experiments.results import HeldoutSection
from stiffcal.workflow.steps import Document, Ingested

if TYPE_CHECKING:
    import pyarrow as pa

NOTHING: dict[str, float | None] = {"translation": None, "rotation": None}


@dataclass(frozen=True)
class ExperimentFit:
    """What one kind of experiment adds to the answer of ``identify``.

    Attributes
    ----------
    name : of its section in the document: "clamped", "friction".
    section : that section, a result.
    parameters, not_identifiable : as in the document, to be added there.
    effects : of the model, as the document writes them, that this experiment alone tells.
    rms, noise : measure ("torque", "motor_angle") to number; ``noise`` empty where it is not known.
    n_runs : runs it rests on. n_readings : readings. reduced_chi2, condition : of its own fit.
    expected : one sentence on what error to expect.
    warnings : in words. tables : to be stored, by name.
    free : names of the parameters that were estimated. covariance : of these, square.
    """

    name: str
    section: object
    parameters: list[Document] = field(default_factory=list)
    not_identifiable: list[Document] = field(default_factory=list)
    effects: list[Document] = field(default_factory=list)
    rms: dict[str, float | None] = field(default_factory=dict)
    noise: dict[str, float | None] = field(default_factory=dict)
    noise_source: str = "none"
    n_runs: int = 0
    n_readings: int = 0
    reduced_chi2: float | None = None
    condition: float | None = None
    expected: str = ""
    warnings: list[str] = field(default_factory=list)
    tables: dict[str, pa.Table] = field(default_factory=dict)
    free: list[str] = field(default_factory=list)
    covariance: list[list[float]] = field(default_factory=list)


@dataclass(frozen=True)
class ExperimentValidation:
    """What one kind of experiment adds to the answer of ``validate``.

    Attributes
    ----------
    scheme : how it was judged, in words.
    rms, largest, noise, relative, zero_model : measure to number.
    by : "run", "joint" and so on to slices as in the document.
    section_scheme : the same in the experiment's section of ``validate``. n_readings : how many were judged.
    """

    name: str
    scheme: str
    rms: dict[str, float | None]
    largest: dict[str, float | None]
    noise: dict[str, float | None]
    relative: dict[str, float | None]
    zero_model: dict[str, float | None]
    by: dict[str, list[Document]] = field(default_factory=dict)
    section_scheme: str = ""
    n_readings: int = 0
    warnings: list[str] = field(default_factory=list)
    tables: dict[str, pa.Table] = field(default_factory=dict)

    @property
    def section(self) -> HeldoutSection:
        """The experiment's section of ``validate``."""
        return HeldoutSection(
            scheme=self.section_scheme,
            n_readings=self.n_readings,
            rms=self.rms,
            noise=self.noise,
            zero_model=self.zero_model,
        )


def fit_experiments(data: Ingested) -> list[ExperimentFit]:
    """Return what each kind of experiment that the campaign holds adds to ``identify``."""
    from stiffcal.workflow.clamped import clamped_experiment_fit
    from stiffcal.workflow.friction import friction_experiment_fit

    return [part for part in (clamped_experiment_fit(data), friction_experiment_fit(data)) if part is not None]


def validated_experiments(data: Ingested) -> list[ExperimentValidation]:
    """Return what each kind of experiment that the campaign holds adds to ``validate``."""
    from stiffcal.workflow.clamped import clamped_validation
    from stiffcal.workflow.friction import friction_validation

    return [part for part in (clamped_validation(data), friction_validation(data)) if part is not None]


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
