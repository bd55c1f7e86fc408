"""A fit as the JSON interface writes it, and back to a valued robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from stiffcal.identification.fit import Ambiguity, Fit, Parameter
from stiffcal.identification.identify import fit_rms
from stiffcal.identification.measured_links import MeasuredLink, links_document, measure_links
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot

SCHEMA = "stiffcal/identify/1"
# So many springs of one effect in the noise are named in one line.
JOINTLY_UNIDENTIFIABLE = 4


def finite(value: float | None) -> float | None:
    """Return the number, or None where JSON has none for it."""
    return value if value is not None and math.isfinite(value) else None


def parameter_document(parameter: Parameter) -> dict[str, Any]:
    """Return one parameter; SI, null where not identifiable."""
    interval = parameter.interval
    document: dict[str, Any] = {
        "name": parameter.name,
        "effect": parameter.effect,
        "where": parameter.place.as_where(),
        "value": finite(parameter.value),
        "std": finite(parameter.std),
        "interval": None if interval is None else [finite(interval[0]), finite(interval[1])],
        "unit": parameter.spec.unit,
        "fixed": parameter.fixed,
        "identifiable": parameter.identifiable,
        "at_bound": parameter.at_bound,
        "poorly_known": parameter.poorly_known,
    }
    if parameter.spec.compliance:
        document |= {"stiffness": None, "stiffness_std": None, "stiffness_interval": None, **parameter.stiffness()}
    if parameter.above_noise is not None:
        document["above_noise"] = parameter.above_noise
    return document


def model_document(robot: CompliantRobot) -> dict[str, Any]:
    """Return what the model holds: balance and effects with places."""
    effects: dict[str, dict[str, Any]] = {}
    for one in robot.placed:
        entry = effects.setdefault(one.effect.name, {"type": one.effect.name})
        for kind, places in one.place.as_where().items():
            entry.setdefault(kind, []).extend(places)
    return {"balance": "deformed" if robot.deformed else "first-order", "effects": list(effects.values())}


def ambiguity_document(ambiguity: Ambiguity) -> dict[str, Any]:
    """Return what cannot be told apart, and what is known of it."""
    return {
        "parameters": list(ambiguity.names),
        "known": ambiguity.known or None,
        "value": finite(ambiguity.value),
        "std": finite(ambiguity.std),
        "reason": ambiguity.reason,
    }


def fit_document(fit: Fit, states: LoadStates) -> dict[str, Any]:
    """Return the document of ``identify``.

    Parameters
    ----------
    fit : the fit.
    states : all load states of the campaign, those set aside among them.
    """
    aside = [
        {"run": states.runs[states.run[i]].name, "row": int(states.row[i]), "why": str(states.set_aside[i])}
        for i in range(len(states))
        if states.set_aside[i]
    ]
    noise = fit.noise
    correlation = _correlation(fit)
    links = measured_links(fit)
    return {
        "schema": SCHEMA,
        "warnings": fit_warnings(fit) + [fault.sentence for link in links for fault in link.faults],
        "model": model_document(fit.robot),
        "parameters": [parameter_document(one) for one in fit.parameters],
        "n_states": fit.data.n_measured,
        "n_runs": len(set(fit.data.run.tolist())),
        "rms": fit_rms(fit),
        "noise": fit.noise_length if noise is not None else None,
        "noise_source": "none" if noise is None else noise.source,
        "noise_per_axis": None
        if noise is None
        else {
            "translation": noise.translation,
            "rotation": noise.rotation,
            "force": noise.force,
            "moment": noise.moment,
        }
        | ({"gauge": noise.gauge} if fit.data.layout.gauges is not None else {})
        | ({"length": noise.length} if fit.data.layout.rods else {})
        | ({"motor_angle": noise.motor_angle} if fit.data.layout.motors is not None else {})
        | ({} if noise.held is None else {"force_clamped": noise.held[0], "moment_clamped": noise.held[1]}),
        "reduced_chi2": finite(fit.reduced_chi2),
        "dof": fit.dof,
        "std_scaled_by_reduced_chi2": fit.scaled,
        "condition": finite(fit.condition),
        "not_identifiable": [ambiguity_document(one) for one in fit.ambiguities],
        "rejected": aside,
        "free_parameters": list(fit.free_names),
        "covariance": fit.covariance.tolist(),
        "correlation": correlation,
        "iterations": fit.iterations,
    } | ({"links": links_document(links)} if links else {})


def measured_links(fit: Fit) -> tuple[MeasuredLink, ...]:
    """Return what the rods of a fitted campaign say of their links."""
    sigma = None if fit.noise is None else fit.noise.length
    return measure_links(fit.data, fit.robot, sigma) if fit.data.layout.rods else ()


def _correlation(fit: Fit) -> list[dict[str, Any]]:
    """Return pairs of parameters whose estimates hang together noticeably (above 0.5), strongest first."""
    pairs = []
    for i in range(len(fit.free_names)):
        for j in range(i):
            value = float(fit.covariance[i, j] / math.sqrt(fit.covariance[i, i] * fit.covariance[j, j]))
            if abs(value) > 0.5:
                pairs.append({"parameters": [fit.free_names[j], fit.free_names[i]], "correlation": value})
    return sorted(pairs, key=lambda pair: -abs(float(pair["correlation"])))


def fit_warnings(fit: Fit) -> list[str]:
    """Return what a reader of the numbers must know, in words."""
    words = []
    if not fit.robot.chain.masses_known:
        words.append("link masses are not known: the sag under weight is left out")
    if fit.left is not None:
        words.append(
            f"the fit did not settle in {fit.iterations} steps: the last one still moved the parameters by "
            f"{fit.left:.2g} standard uncertainties; do not rely on them before the model holds fewer effects"
        )
    if fit.noise is None:
        words.append("no repeats and no stated sigma: whether the model is good enough cannot be judged")
    if fit.scaled:
        words.append("standard uncertainties are scaled by the reduced chi-square of the fit")
    if fit.reduced_chi2 is not None and fit.reduced_chi2 > 1.5:
        stated = fit.noise is not None and fit.noise.source == "manifest"
        words.append(
            f"residuals are {math.sqrt(fit.reduced_chi2):.2g} times the noise: something is missing in the model"
            f"{' or the noise is larger than stated' if stated else ''}, "
            "and the stated uncertainties cover the instruments only"
        )
    in_noise = _jointly_unidentifiable(fit)
    words += [
        f"{effect} at {', '.join(places)}: within the noise, told from none at all by less than three standard "
        "uncertainties"
        for effect, places in in_noise.items()
    ]
    for one in fit.parameters:
        if one.effect in in_noise and one.above_noise is False:
            continue
        if one.at_bound:
            words.append(f"{one.name} lies on the edge of what is possible")
        elif one.poorly_known:
            words.append(
                f"{one.name} is poorly known: ± {100.0 * 1.96 * (one.std or 0.0) / abs(one.value or 1.0):.0f} %"
            )
    return words


def _jointly_unidentifiable(fit: Fit) -> dict[str, list[str]]:
    """Return the effects of which several springs are lost in the noise, with the places where they are."""
    in_noise: dict[str, list[str]] = {}
    for one in fit.parameters:
        if one.above_noise is False:
            in_noise.setdefault(one.effect, []).append(one.place.label)
    return {
        effect: list(dict.fromkeys(places))
        for effect, places in in_noise.items()
        if len(places) >= JOINTLY_UNIDENTIFIABLE
    }


def values_of(document: Mapping[str, Any]) -> dict[str, float]:
    """Return parameter values by full name from an ``identify`` document; those not identifiable are left out."""
    return {one["name"]: float(one["value"]) for one in document["parameters"] if one["value"] is not None}
