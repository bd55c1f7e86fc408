"""A diagnosis as the JSON interface writes it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import chosen_in_every_fold, confidence
from stiffcal.diagnosis.heldout_error import fitted_rms, left_out_rms, size_at_tool
from stiffcal.diagnosis.judge import LackOfFit, alike, fitted_values, judge, judge_choice, near_best
from stiffcal.diagnosis.scan import ROUNDING, Scan, Trial
from stiffcal.diagnosis.search import MissingEffect, Search
from stiffcal.diagnosis.structure import what_it_follows
from stiffcal.diagnosis.thresholds import PAIRS_PLANNED, REPORTED_LINGERING
from stiffcal.diagnosis.words import candidate_in_words, explain
from stiffcal.identification.document import finite, parameter_document
from stiffcal.measurements.load_states import LoadStates

SCHEMA = "stiffcal/diagnose/1"

Rms = dict[str, float | None]


def candidate_document(candidate: Candidate) -> dict[str, Any]:
    """Return effect and place."""
    return {"effect": candidate.effect.name, "where": candidate.place.as_where()}


def _lack(lack: LackOfFit | None) -> dict[str, Any] | None:
    if lack is None:
        return None
    dof = [lack.dof[0], finite(lack.dof[1])]
    return {"statistic": lack.statistic, "dof": dof, "p_value": lack.p_value}


def _missing(found: MissingEffect) -> dict[str, Any]:
    alternatives = [candidate_document(one) for one in found.alternatives]
    return {**candidate_document(found.candidate), "alternatives": alternatives}


def _by_effect(candidates: tuple[Candidate, ...]) -> list[dict[str, Any]]:
    """Return effects, each with all its places."""
    places: dict[str, dict[str, list[Any]]] = {}
    for one in candidates:
        where = places.setdefault(one.effect.name, {})
        for kind, items in one.place.as_where().items():
            where.setdefault(kind, []).extend(items)
    return [{"effect": name, "where": {k: sorted(v) for k, v in where.items()}} for name, where in places.items()]


def diagnosis_document(states: LoadStates, search: Search) -> dict[str, Any]:
    """Return the document of ``diagnose``.

    Parameters
    ----------
    states : the campaign's load states.
    search : what was found.

    Returns
    -------
    dict
        The document; ``next_measurement`` is left for who can plan measurements (`look_alike_pairs`).
    """
    scan = search.first
    noise = search.final.noise_length if search.final.noise is not None else None
    before = left_out_rms(scan, None)
    adequate = None if search.before is None else not search.tried and search.before.adequate
    remainder = what_it_follows(search.final_scan if search.found else scan, states)
    with_missing = fitted_rms(states, search.final) if search.found else before
    document = {
        "schema": SCHEMA,
        "warnings": _warnings(search),
        "adequate": adequate,
        "noise": noise,
        "rms": before,
        "lack_of_fit": _lack(search.before),
        "missing": [_missing(one) for one in search.found],
        "could_be": _by_effect(search.could_be),
        "findings": _findings(search, before, noise),
        "next_measurement": None,
        "not_tried": [{"effect": one.effect, "needs": one.needs} for one in search.not_tried],
        "unexplained": search.unexplained if search.after is not None else None,
        "structure": [{"follows": one.what, "share": one.share, "seen": one.words} for one in remainder]
        if search.unexplained or search.after is None
        else [],
        "explained_by_missing": _explained(search, before, with_missing) if search.tried else None,
        "heldout_rms_with_missing": with_missing,
        "heldout_rms_after_choosing": _after_choosing(scan, before),
        "parameters_with_missing": [parameter_document(one) for one in search.final.parameters] if search.found else [],
        "n_candidates": len(scan.trials),
        "n_signatures": scan.n_tried,
        "pace": {
            "models": search.pace.models,
            "candidates": search.pace.candidates,
            "signatures": search.pace.regressors,
            "seconds": search.pace.seconds,
            "candidates_per_second": search.pace.candidates / search.pace.seconds,
        },
    }
    document["summary"] = summary(search, before, noise)
    return document


def _explained(search: Search, before: Rms, after: Rms) -> float | None:
    """Return the share of the avoidable error that goes; of all the error where no noise is known to be unavoidable."""
    if search.after is not None:
        return search.explained
    first, last = before["translation"], after["translation"]
    return 1.0 - (last / first) ** 2 if first and last is not None else None


def _warnings(search: Search) -> list[str]:
    words = []
    if search.before is None:
        words.append("no repeats and no stated sigma: whether the model is good enough cannot be judged")
    if len(search.first.folds) < 6:
        words.append(f"only {len(search.first.folds)} poses: what holds in unseen poses is known poorly")
    now = search.after
    if now is not None and now.lingers > REPORTED_LINGERING and not now.wanders and not search.unexplained:
        words.append(
            f"successive readings are off alike (correlation {now.lingers:.2g}): noise that lingers (air, temperature, "
            "a filter), so that uncertainties are larger than those given; wait longer between readings"
        )
    if now is not None and not now.adequate and not search.unexplained:
        words.append(
            f"what is left is {now.ratio:.2g} times the noise that the manifest states, and follows nothing: look at "
            "sigma in campaign.toml, or repeat loads, which tells the noise itself"
        )
    return words


def _after_choosing(scan: Scan, before: Rms) -> Rms:
    """Return the unseen error with the choice repeated in every fold, scaled from whitened squares."""
    squares, base = float(chosen_in_every_fold(scan).sum()), float(np.trace(scan.base.nested))
    factor = math.sqrt(max(squares, 0.0) / base) if base > 0.0 else 1.0
    return {kind: None if value is None else value * factor for kind, value in before.items()}


def _findings(search: Search, before: Rms, noise: Rms | None) -> list[dict[str, Any]]:
    """Return the ranking for the next single step, best first."""
    scan = search.first
    near = near_best(scan)
    names = [one.candidate.name for one in near]
    shares = confidence(scan)
    after_choosing = _after_choosing(scan, before)
    ranked = sorted(
        scan.trials, key=lambda one: names.index(one.candidate.name) if one.candidate.name in names else len(names)
    )
    documents = []
    for place, trial in enumerate(ranked):
        judgement = judge(scan, trial)
        leads = place == 0 and bool(near)
        if leads:
            judgement = judge_choice(scan, trial)
        verdict = "rejected"
        if judgement.supported:
            verdict = "supported" if leads else "possible"
        after = left_out_rms(scan, trial)
        alternatives = [
            one.candidate for one in near if one.candidate.name in names and one.candidate.name != trial.candidate.name
        ] if trial.candidate.name in names else []  # fmt: skip
        explanation = None
        if verdict != "rejected":
            explanation = explain(scan, trial, before["translation"], after["translation"], alternatives)
        documents.append(
            {
                **candidate_document(trial.candidate),
                "verdict": verdict,
                "explains": _explains(scan, trial),
                "size_m": size_at_tool(scan, trial),
                "p_value": judgement.p_value,
                "heldout_rms_before": before,
                "heldout_rms_after": after,
                "heldout_rms_after_choosing": after_choosing if leads else None,
                "confidence": shares.get(trial.candidate.name, 0.0),
                "parameters": [
                    {"symbol": symbol, "value": finite(value), "unit": trial.candidate.effect.spec(symbol).unit}
                    for symbol, value in fitted_values(trial).items()
                ],
                "alternatives": [candidate_document(one) for one in alternatives],
                "why": explanation.text if explanation is not None else _why_rejected(scan, trial),
                "evidence": {
                    "seen": explanation.seen,
                    "means": explanation.means,
                    "alike": explanation.alike,
                    "check": explanation.check,
                }
                if explanation is not None
                else None,
            }
        )
    return documents


def _explains(scan: Scan, trial: Trial) -> float | None:
    """Return the share of the avoidable error that goes, whitened."""
    before, after = float(scan.base.heldout.sum()), float(trial.score.heldout.sum())
    floor = float(scan.dof) if scan.fit.noise is not None else 0.0
    if before <= floor * (1.0 + ROUNDING):
        return None
    # What is left of equal errors is rounding.
    return (before - after) / (before - floor) if abs(before - after) > ROUNDING * before else 0.0


def _why_rejected(scan: Scan, trial: Trial) -> str:
    judgement = judge(scan, trial)
    if not judgement.possible:
        return "its values would have to be impossible (negative, or nothing)"
    if judgement.fall <= 0.0:
        return "the error in unseen poses does not fall"
    if not alike(scan, trial, scan.trials[0]):
        return "the error in unseen poses falls too little, or others explain more"
    return f"too little to be sure: {judgement.errors:.2g} standard errors over poses, p {judgement.p_value:.2g}"


def look_alike_pairs(search: Search) -> list[tuple[Trial, Trial]]:
    """Return the first missing effect with each of its foremost look-alikes."""
    near = near_best(search.first) if search.tried else []
    return [(near[0], other) for other in near[1 : 1 + PAIRS_PLANNED]]


def _named(found: MissingEffect) -> str:
    """Return a missing effect as one says it, with how many others would look the same."""
    alike = len(found.alternatives)
    if not alike:
        return candidate_in_words(found.candidate)
    if alike == 1:
        return (
            f"{candidate_in_words(found.candidate)} (or {candidate_in_words(found.alternatives[0])}, which looks alike)"
        )
    return f"{candidate_in_words(found.candidate)} (or one of {alike} others that look alike in these poses)"


def summary(search: Search, before: Rms, noise: Rms | None) -> str:
    """Return the answer in one or two sentences."""
    error = before["translation"] or 0.0
    floor = noise["translation"] if noise is not None else None
    against = f"{1e3 * error:.3g} mm in unseen poses" + (f", noise {1e3 * floor:.3g} mm" if floor else "")
    if not search.tried and search.before is None:
        return f"Nothing is supported; without a known noise nobody can say whether that is good enough ({against})."
    if not search.tried and not search.unexplained and search.before is not None and not search.before.adequate:
        return (
            f"No effect is missing: what is left follows nothing, as if the noise were larger than stated ({against})."
        )
    if not search.tried and not search.unexplained:
        return f"Nothing is missing: the error is that of the instruments ({against})."
    names = " and ".join(_named(one) for one in search.found)
    if search.found and search.before is None:
        return f"Missing: {names} ({against}); without a known noise nobody can say whether that is all."
    if search.found and not search.unexplained:
        return f"Missing: {names} ({against})."
    if search.found:
        return f"Missing: {names}; and something else that nothing in the catalogue accounts for ({against})."
    if search.could_be:
        n = len(search.could_be)
        who = f"each of {n} effects alone fits" if n > 1 else f"{candidate_in_words(search.could_be[0])} alone fits"
        return (
            f"Something is missing, and these {len(search.first.folds)} poses are too few to tell what: "
            f"{who} them all, so that leaving poses out cannot choose among them ({against})."
        )
    return f"Something is missing, and it is none of these: no effect in the catalogue accounts for it ({against})."
