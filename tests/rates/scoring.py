"""What the tool makes of a hidden campaign, in words that can be counted."""

from __future__ import annotations

import time
from collections.abc import Container
from dataclasses import dataclass

import numpy as np

from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.judgement.found import FoundEffect
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import ParameterRole
from tests.rates.measuring import Player
from tests.rates.playing import Hidden


@dataclass(frozen=True)
class Verdict:
    """One campaign's outcome.

    Attributes
    ----------
    kind, settings : of the campaign.
    hidden, found : names; found with alternatives in brackets.
    outcome : "right", "look-alike", "wrong", "nothing", "exact", "incomplete" …; see `verdict_of`.
    good : counts towards the rate.
    before, after : held-out error over noise.
    within : after adding, within five per cent of the noise.
    p_parameters : χ² p of the hidden parameters, None where the found set is not the hidden one.
    unexplained : the tool says that something is left.
    seconds : of the search.
    """

    kind: str
    settings: str
    hidden: str
    found: str
    outcome: str
    good: bool
    before: float
    after: float
    within: bool
    p_parameters: float | None
    unexplained: bool
    seconds: float
    firm_wrong: bool
    """The first name is not in the truth, nor the truth among its alternatives, and no doubt is stated; or a crash."""
    player: Player
    crash: str = ""
    """The traceback of a crash."""


def crashed(kind: str, player: Player, traceback: str) -> Verdict:
    """Return the verdict on a campaign without an answer."""
    nan = float("nan")
    return Verdict(kind, "", "", "", "crash", False, nan, nan, False, None, False, nan, True, player, traceback)


def name_of(one: PlacedEffect) -> str:
    """Return ``effect at place`` as candidates are named."""
    return f"{one.effect.name} {one.place.label}"


def judge_campaign(campaign: Hidden, without: Container[str] = ()) -> Verdict:
    """Diagnose a campaign, some effects of the catalogue left out, and compare with its truth."""
    start = time.perf_counter()
    catalogue = {name: effect for name, effect in built_in_effects().items() if name not in without}
    search = diagnose_states(campaign.states, campaign.model, catalogue)
    seconds = time.perf_counter() - start
    outcome, good = _outcome_of(campaign, search)
    before = search.before.ratio if search.before else np.nan
    after = search.after.ratio if search.after else np.nan
    return Verdict(
        kind=campaign.kind,
        settings=campaign.settings,
        hidden=", ".join(
            f"{name_of(one)} {size:.1f}x{_numbers(one)}"
            for one, size in zip(campaign.hidden, campaign.sizes, strict=True)
        ),
        found=found_in_words(search),
        outcome=outcome,
        good=good,
        before=before,
        after=after,
        within=bool(after <= 1.05),
        p_parameters=_parameter_p(campaign, search),
        unexplained=bool(search.unexplained),
        seconds=seconds,
        firm_wrong=_is_firm_and_wrong(campaign, search),
        player=campaign.player,
    )


def found_in_words(search: DiagnosedStates) -> str:
    """Return what is missing, each with its probability."""
    return "; ".join(_identified(one) for one in search.found)


def is_firm(search: DiagnosedStates) -> bool:
    """Return whether something is named without a doubt."""
    return any(one.group.firm for one in search.found)


def _is_firm_and_wrong(campaign: Hidden, search: DiagnosedStates) -> bool:
    """Return whether a wrong name is given without doubt; where nothing of the catalogue is hidden every name is."""
    outside = campaign.kind.startswith("outside")
    truth = set[str]() if outside else {name_of(one) for one in campaign.hidden}
    return any(one.group.firm and not truth.intersection(names_of(one)) for one in search.found)


def names_of(one: FoundEffect) -> list[str]:
    """Return the name of an effect and those of its look-alikes."""
    return [one.candidate.name, *(candidate.name for candidate, _ in one.alternatives)]


def _numbers(one: PlacedEffect) -> str:
    return "(" + ",".join(f"{s}={v:.2g}" for s, v in one.values.items()) + ")"


def _identified(one: FoundEffect) -> str:
    name, *others = names_of(one)
    alike = f" [{', '.join(others)}]" if others else ""
    return f"{name}{alike} {one.group.probability:.3f}{' firm' if one.group.firm else ''}"


def _outcome_of(campaign: Hidden, search: DiagnosedStates) -> tuple[str, bool]:
    truth = [name_of(one) for one in campaign.hidden]
    named = search.found
    if not truth and not campaign.kind.startswith("outside"):
        quiet = not named and not search.unexplained
        return ("quiet" if quiet else "false alarm" if named else "not adequate"), quiet
    if campaign.kind.startswith("outside"):
        if search.unexplained:
            return ("unexplained, named too" if named else "unexplained"), True
        return ("wrong name alone" if named else "nothing"), False
    if len(truth) > 1:
        return _several(truth, search)
    if named and not named[0].decided:
        among = truth[0] in names_of(named[0])
        return f"undecided, truth {'' if among else 'not '}among them", among
    if not named:
        return ("unexplained" if search.unexplained else "nothing"), False
    first = named[0]
    more = "" if len(named) == 1 else " + more"
    if first.candidate.name == truth[0]:
        return "right" + more, True
    if truth[0] in names_of(first):
        return "look-alike" + more, True
    return ("right, not first" if any(truth[0] == one.candidate.name for one in named) else "wrong"), False


def _several(truth: list[str], search: DiagnosedStates) -> tuple[str, bool]:
    left, exact, strange = list(truth), True, 0
    for one in search.found:
        if one.candidate.name in left:
            left.remove(one.candidate.name)
            continue
        alike = [name for name in names_of(one) if name in left]
        if alike:
            left.remove(alike[0])
            exact = False
        else:
            strange += 1
    if not left and not strange:
        return ("exact" if exact else "look-alikes"), True
    return f"{len(left)} missed, {strange} wrong", False


def _parameter_p(campaign: Hidden, search: DiagnosedStates) -> float | None:
    """Return the χ² p of the hidden effects' parameters, where all of them were found themselves."""
    from scipy.special import chdtrc

    found = {one.candidate.name for one in search.found}
    if not campaign.hidden or {name_of(one) for one in campaign.hidden} != found:
        return None
    fit = search.last.fit
    picked, off = [], []
    for one in campaign.hidden:
        valued = next(p for p in fit.robot.placed if p.effect.name == one.effect.name and p.place == one.place)
        for spec in one.effect.parameters:
            name = one.parameter_name(spec.symbol)
            if name in fit.free_names and not spec.discrete:
                picked.append(fit.free_names.index(name))
                true = one.amplitude(spec.symbol) if spec.symbol in one.values else 0.0
                off.append(valued.amplitude(spec.symbol) - true)
                if spec.role is ParameterRole.NONLINEAR:
                    off[-1] = valued.values[spec.symbol] - one.values[spec.symbol]
    if not picked:
        return None
    covariance = fit.covariance[np.ix_(picked, picked)]
    scale = np.sqrt(np.diag(covariance))
    distance = np.array(off) / scale
    chi2 = float(distance @ np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True) @ distance)
    return float(chdtrc(len(picked), chi2))
