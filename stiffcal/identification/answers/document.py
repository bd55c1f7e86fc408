"""The parts of a fit as ``identify`` answers them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from stiffcal.estimation.identifiability import Ambiguity
from stiffcal.estimation.parameters import Parameter
from stiffcal.identification.answers.fit_results import (
    CorrelatedParameters,
    IdentifiedParameter,
    NoisePerAxis,
    RejectedState,
    UnidentifiedParameters,
)
from stiffcal.identification.bodies.measured_links import MeasuredLink, measure_links
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.gauge import held_frames, included_in, redundant_geometry
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.identification.readings.row_layout import ROTATION
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.stated_spring import is_spring_modelled, spring_joint, stated_rate
from stiffcal.model.summary import EffectInModel, ModelSummary, Where
from stiffcal.quantity import is_drift
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import listing, significant

# So many springs of one effect in the noise are named in one line.
JOINTLY_UNIDENTIFIABLE = 4
# Reduced χ² from which an effect is missing, and below whose inverse the stated noise is too large.
MOST_CHI2 = 1.5
# Probability by chance below which so small a χ² is the stated noise's.
LEAST_P = 1e-3
# Of a parameter's variance, that another one makes: less than all the rest together, it does not decide.
HALF = 0.5


def finite(value: float | None) -> float | None:
    """Return the number, or None where JSON has none for it."""
    return value if value is not None and math.isfinite(value) else None


def identified_parameter(
    parameter: Parameter, in_fit: float | None = None, by_temperature: bool = False
) -> IdentifiedParameter:
    """Return one parameter as ``identify`` answers it; ``in_fit`` as there.

    Parameters
    ----------
    by_temperature : whether a drift in these data follows a temperature; else it follows the time.
    """
    interval, stiffness = parameter.interval, parameter.stiffness()
    return IdentifiedParameter(
        name=parameter.name,
        effect=parameter.effect,
        where=Where.of(parameter.place),
        value=finite(parameter.value),
        std=finite(parameter.std),
        interval=None if interval is None else [finite(interval[0]), finite(interval[1])],
        unit=parameter.spec.unit,
        fixed=parameter.fixed,
        identifiable=parameter.identifiable,
        at_bound=parameter.at_bound,
        poorly_known=parameter.poorly_known,
        stiffness=None if stiffness is None else _known_or_nan(stiffness.value),
        stiffness_std=None if stiffness is None else _known_or_nan(stiffness.std),
        stiffness_interval=None if stiffness is None else stiffness.interval,
        above_noise=parameter.above_noise,
        from_geometry=parameter.from_geometry,
        in_fit=in_fit,
        drift_follows=("temperature" if by_temperature else "time") if is_drift(parameter.spec.unit) else None,
    )


def _known_or_nan(value: float | None) -> float:
    """Return a number of a key that stands where it is not known, too."""
    return math.nan if value is None else value


def resting_on_limits(fit: Fit) -> dict[str, list[str]]:
    """Return name to the parameters at a limit of their range other than 0 that make half of its variance or more.

    At its limit a parameter has no uncertainty, and what is found of the others is found for that value of it.
    """
    places = {name: k for k, name in enumerate(fit.free_names)}
    limited = [one.name for one in fit.parameters if one.at_bound and one.value and one.name in places]
    std = np.sqrt(np.diagonal(fit.covariance))
    found: dict[str, list[str]] = {}
    for name, k in places.items():
        shares = {other: fit.covariance[k, places[other]] ** 2 for other in limited if other != name}
        own = [other for other, share in shares.items() if share >= HALF * (std[k] * std[places[other]]) ** 2 > 0.0]
        found |= {name: own} if own else {}
    return found


def rest_in_words(names: Sequence[str]) -> str:
    """Return that others hold for a value at a limit alone, to append to it; "" where there are none.

    Examples
    --------
    >>> rest_in_words(["a"]), rest_in_words(["a", "b"])
    (', and a holds for that value alone', ', and a and b hold for that value alone')
    """
    return f", and {listing(names)} {'holds' if len(names) == 1 else 'hold'} for that value alone" if names else ""


def included_by_convention(fit: Fit) -> dict[str, list[str]]:
    """Return name to the parameters that stay at 0 by convention and are included in its value; of absolute places."""
    if not fit.data.absolute.any():
        return {}
    fixed = fit.fixed | held_frames(fit.robot, fit.data, fit.fixed)
    return included_in(fit.robot, fit.data, fixed, redundant_geometry(fit.robot, fit.data, fixed))


def values_in_fit(fit: Fit) -> dict[str, float]:
    """Return name to value of parameters that are not identified alone but stand for what is known of several.

    Without a compliance of 0, as which an infinite stiffness is in the fit.
    """
    open_ones = {parameter.name for parameter in fit.parameters if parameter.value is None}
    return {
        name: value
        for placed in fit.robot.placed
        for symbol, value in placed.values.items()
        if (name := placed.parameter_name(symbol)) in open_ones and value and np.isfinite(value)
    }


def model_summary(robot: CompliantRobot) -> ModelSummary:
    """Return the content of the model: balance and effects with places."""
    places: dict[str, dict[str, list[Any]]] = {}
    for placed in robot.placed:
        if placed.place.kind == "frames":
            continue  # the manifest states which frames are found, not the model file
        of_effect = places.setdefault(placed.effect.name, {})
        for kind, items in Where.of(placed.place).items():
            of_effect.setdefault(kind, []).extend(items)
    effects = [EffectInModel(name, **of_effect) for name, of_effect in places.items()]
    return ModelSummary("deformed" if robot.deformed else "first-order", effects)


def unidentified_parameters(ambiguity: Ambiguity) -> UnidentifiedParameters:
    """Return the sets that these data do not distinguish, and what is known of them."""
    return UnidentifiedParameters(
        parameters=list(ambiguity.names),
        known=ambiguity.known or None,
        value=finite(ambiguity.value),
        std=finite(ambiguity.std),
        reason=ambiguity.cause.sentence,
        cause=ambiguity.cause,
    )


def rejected_states(states: LoadStates) -> list[RejectedState]:
    """Return the load states that were set aside."""
    return [
        RejectedState(run=states.runs[states.run[i]].name, row=int(states.row[i]), why=str(states.set_aside[i]))
        for i in range(len(states))
        if states.set_aside[i]
    ]


def noise_per_axis(fit: Fit) -> NoisePerAxis | None:
    """Return the scatter of a single reading; None where it is not known."""
    noise, layout = fit.noise, fit.data.layout
    if noise is None:
        return None
    force_clamped, moment_clamped = (None, None) if noise.clamped_wrench is None else noise.clamped_wrench
    mixed = noise.absolute is not None and not fit.data.absolute.all()
    translation_absolute, rotation_absolute = noise.absolute if mixed and noise.absolute is not None else (None, None)
    return NoisePerAxis(
        translation=noise.translation,
        rotation=noise.rotation,
        force=noise.force,
        moment=noise.moment,
        gauge=noise.gauge if layout.gauges is not None else None,
        length=noise.length if layout.rods else None,
        motor_angle=noise.motor_angle if layout.motors is not None else None,
        force_clamped=force_clamped,
        moment_clamped=moment_clamped,
        translation_absolute=translation_absolute,
        rotation_absolute=rotation_absolute,
    )


def measured_links(fit: Fit) -> tuple[MeasuredLink, ...]:
    """Return the results of the rods of a fitted campaign for their links."""
    sigma = None if fit.noise is None else fit.noise.length
    return measure_links(fit.data, fit.robot, sigma) if fit.data.layout.rods else ()


def correlated_parameters(fit: Fit) -> list[CorrelatedParameters]:
    """Return pairs of parameters whose estimates hang together noticeably (above 0.5), strongest first."""
    pairs = []
    for i in range(len(fit.free_names)):
        for j in range(i):
            value = float(fit.covariance[i, j] / math.sqrt(fit.covariance[i, i] * fit.covariance[j, j]))
            if abs(value) > 0.5:
                names = [fit.free_names[j], fit.free_names[i]]
                pairs.append(CorrelatedParameters(parameters=names, correlation=value))
    return sorted(pairs, key=lambda pair: -abs(pair.correlation))


def fit_warnings(fit: Fit) -> list[str]:
    """Return the warnings on the numbers, as sentences."""
    texts = []
    if not fit.robot.chain.masses_known:
        texts.append("link masses are unknown: the sag under weight is not modelled")
    if fit.last_step is not None:
        texts.append(
            f"the fit did not converge in {fit.iterations} steps: the last one still changed the parameters by "
            f"{significant(fit.last_step, 2)} standard uncertainties; do not use them before effects "
            f"are removed from the model"
        )
    geometry = fit.geometry
    if geometry is not None and geometry.contradicted(fit.robot.chain.masses_known):
        texts.append(wrong_geometry_in_words(geometry.misfit or 0.0, fit.robot))
    if fit.noise is None:
        texts.append(noise_not_known("whether the model is good enough cannot be judged", fit))
    if fit.scaled:
        texts.append("standard uncertainties are scaled by the reduced χ² of the fit")
    if fit.reduced_chi2 is not None and fit.reduced_chi2 > MOST_CHI2:
        stated = fit.noise is not None and fit.noise.source == "manifest"
        texts.append(
            f"residuals are {significant(math.sqrt(fit.reduced_chi2), 2)} times the noise: an effect is missing in the "
            f"model{' or the noise is larger than stated' if stated else ''}, and the stated uncertainties cover the "
            "instruments only"
        )
    if fit.noise is not None and fit.reduced_chi2 is not None:
        texts += overstated_noise_in_words(fit.noise, fit.reduced_chi2, float(fit.dof))
    in_noise = _jointly_unidentifiable(fit)
    texts += [
        f"{effect} at {', '.join(places)}: not significant, less than three standard uncertainties from zero"
        for effect, places in in_noise.items()
    ]
    for parameter in fit.parameters:
        if parameter.effect in in_noise and parameter.above_noise is False:
            continue
        if parameter.at_bound:
            resting = [name for name, limits in resting_on_limits(fit).items() if parameter.name in limits]
            texts.append(f"{parameter.name} is at the limit of its range{rest_in_words(resting)}")
        elif parameter.poorly_known:
            share_percent = 100.0 * NORMAL_95 * (parameter.std or 0.0) / abs(parameter.value or 1.0)
            texts.append(f"{parameter.name} is poorly determined: ± {share_percent:.0f} %")
    return texts


def noise_not_known(consequence: str, fit: Fit) -> str:
    """Return that nothing shows the instruments' noise, what follows from that, and what would show it."""
    turned = fit.data.measured_mask[fit.data.kind == ROTATION].any()
    sigma = f"{{ position = 0.015{', rotation = 0.00003' if turned else ''} }}"
    return (
        f"no repeats and no stated sigma: {consequence}; measure some loads twice in the same pose, or state the "
        f"instrument's sigma next to its units in campaign.toml, as sigma = {sigma}"
    )


def overstated_noise_in_words(noise: Noise, reduced_chi2: float, dof: float) -> list[str]:
    """Return the warning where the residuals are significantly less than the noise that the manifest states.

    Parameters
    ----------
    reduced_chi2 : of the fit, ``dof`` its degrees of freedom.
    """
    # without a degree of freedom it is not a number
    if noise.source != "manifest" or not reduced_chi2 < 1.0 / MOST_CHI2:
        return []
    from scipy.special import chdtr

    if chdtr(dof, dof * reduced_chi2) >= LEAST_P:
        return []
    text = (
        f"residuals are {significant(math.sqrt(reduced_chi2), 2)} times the noise that campaign.toml "
        f"states: sigma is too large "
        "there; uncertainties are then too large, and effects that are missing may not be found"
    )
    return [text]


def wrong_geometry_in_words(misfit: float, robot: CompliantRobot) -> str:
    """Return the warning where absolute places contradict the robot file, with the causes that the file leaves open.

    Parameters
    ----------
    misfit : in tolerances of lengths and angles. robot : the model.
    """
    found = (
        f"absolute positions differ by {significant(misfit, 2)} times the tolerance of lengths and "
        f"angles, after fitting the "
        "tracker frame and the target: "
    )
    consequence = "this may affect stiffnesses and missing effects"
    if is_spring_modelled(robot):
        return f"{found}robot.toml or the joint zeros are probably wrong, and {consequence}"
    add = f"add gravity-compensator at joint {spring_joint(robot.chain)} to the model"
    if stated_rate(robot.chain) is not None:
        spring = "the rate or the preload that robot.toml states for its balancing spring"
    elif robot.chain.masses_known:
        spring = "the balancing spring of robot.toml, whose rate is not stated and which the model lacks,"
    else:
        spring = "the balancing spring of robot.toml, which does not count as long as the links' masses are unknown,"
    return f"{found}{spring} may be the cause ({add}), or robot.toml and the joint zeros are wrong, and {consequence}"


def _jointly_unidentifiable(fit: Fit) -> dict[str, list[str]]:
    """Return the effects of which several springs are lost in the noise, with the places where they are.

    With their symbols where other springs of the effect at the place are not.
    """
    in_noise: dict[str, dict[str, list[str]]] = {}
    others = set[tuple[str, str]]()
    for parameter in fit.parameters:
        effect, place = parameter.effect, parameter.place.label
        if parameter.above_noise is False:
            in_noise.setdefault(effect, {}).setdefault(place, []).append(parameter.spec.symbol)
        elif parameter.above_noise:
            others.add((effect, place))
    return {
        effect: [
            f"{place} ({', '.join(symbols)})" if (effect, place) in others else place
            for place, symbols in places.items()
        ]
        for effect, places in in_noise.items()
        if sum(map(len, places.values())) >= JOINTLY_UNIDENTIFIABLE
    }
