"""Add effects to model.toml and take them out."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NoReturn

from stiffcal.campaign.loading import Campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.summary import Where

if TYPE_CHECKING:
    from stiffcal.model.effect import Effect


def model_with(
    campaign: Campaign,
    text: str,
    effect: str,
    *,
    where: Where,
    curved: bool,
    start: Mapping[str, float] | None = None,
) -> str:
    """Return model.toml with an effect added, as `edit_model` would write it; the campaign's folder stays as it is.

    Parameters
    ----------
    campaign : its model is the one that `text` holds.
    text : model.toml before; "": the default model holds.
    effect, where, curved, start : as in `edit_model`.

    Raises
    ------
    InputError : as `edit_model`.
    """
    return _edited(campaign, text, "add", effect, Wanted(where, False, curved, start or {}))


def model_without(campaign: Campaign, text: str, effect: str, *, where: Where) -> str:
    """Return model.toml with an effect removed, as `edit_model` would write it; the campaign's folder stays as it is.

    Parameters
    ----------
    campaign : its model is the one that `text` holds.
    text : model.toml before; "": the default model holds.
    effect, where : as in `edit_model`.

    Raises
    ------
    InputError : as `edit_model`.
    """
    return _edited(campaign, text, "remove", effect, Wanted(where, False, False, {}))


def _edited(campaign: Campaign, text: str, action: Literal["add", "remove"], effect: str, wanted: Wanted) -> str:
    from stiffcal.campaign.model.model_editing import default_text

    text = text.removeprefix("\ufeff") or default_text(campaign.folder, campaign.chain.n_joints)
    edited, _ = edit_text(campaign, text, action, effect, wanted)
    return edited.replace("\r\n", "\n").replace("\r", "\n")


@dataclass(frozen=True)
class Wanted:
    """Where an effect is to be added or removed, and in which form."""

    where: Where
    """The places."""
    everywhere: bool
    """At every place."""
    curved: bool
    """In the law's curved form."""
    start: Mapping[str, float]
    """Values by symbol from which the fit starts."""


def edit_text(
    campaign: Campaign, text: str, action: Literal["add", "remove"], effect: str, wanted: Wanted
) -> tuple[str, list[str]]:
    """Return a model file with an effect added or removed, and the changes in words.

    Parameters
    ----------
    campaign : its model is the one that `text` holds. text : of the model file.

    Raises
    ------
    InputError : no such effect or place; or no place given, with the places that there are.
    """
    from stiffcal.campaign.model.model_editing import add_effect, remove_effect
    from stiffcal.model.catalogue.campaign_effects import effects_with
    from stiffcal.model.forms import curve_of

    catalogue = effects_with(campaign, effect)
    if effect not in catalogue:
        suggestions = difflib.get_close_matches(effect, catalogue, n=1)
        mend = f"did you mean {suggestions[0]}?" if suggestions else f"choose one of: {', '.join(sorted(catalogue))}"
        raise InputError.at(FaultCode.EFFECT_UNKNOWN, "command line", "EFFECT", f"unknown effect {effect}", mend)
    if wanted.curved and curve_of(catalogue[effect]) is None:
        _no_curve(effect, catalogue)
    law = _form_of(catalogue[effect], tuple(wanted.start))
    kind = catalogue[effect].place_kind
    possible = [place.label for place in catalogue[effect].places(campaign.chain)]
    given = _given(wanted.where, kind, campaign)
    if wanted.everywhere and action == "add":
        given = _every_place(catalogue[effect].places(campaign.chain), kind)
    if kind != "setup" and not any(given.values()) and not wanted.everywhere:
        option = f"--{kind}"
        places = catalogue[effect].places(campaign.chain)
        present = set(_held(campaign, effect))
        there = [place for place in places if action == "add" or place.label in present]
        # joints and pairs as the option takes them: "2", "5-6"
        named = [place.label if kind == "links" else "-".join(map(str, place.joints)) for place in there]
        mend = f"give {option} with one or more of {', '.join(named)}, or --all"
        if not named:
            mend = f"{effect} is not in the model" if action == "remove" else "this robot has no such place"
        raise InputError.at(
            FaultCode.PLACE_INVALID, "command line", option, f"{effect} acts at {kind}, and none is given", mend
        )
    _check_possible(catalogue[effect], given, possible, campaign.chain.prismatic_joints)
    n_joints = campaign.chain.n_joints
    if action == "add":
        _check_not_included(campaign, catalogue, effect, given)
        text, changes = _remove_replaced(text, campaign, law, given)
        text, new = add_effect(text, effect, **given, n_joints=n_joints)
        if new or not wanted.curved:
            changes.append(
                f"added {effect}: {', '.join(new)}" if new else f"{effect} is already in the model: nothing changed"
            )
        if wanted.start:
            text = _set_start(text, campaign, effect, wanted.start, given)
        if wanted.curved:
            text, bent = _bend(text, campaign, catalogue[effect], given)
            changes.append(bent)
    else:
        text, removed = remove_effect(text, effect, **given, n_joints=n_joints)
        text, held = _add_held(text, campaign, catalogue[effect], removed)
        changes = [f"removed {effect}: {', '.join(removed)}", *held]
    return text, changes


def _add_held(text: str, campaign: Campaign, effect: Effect, removed: Sequence[str]) -> tuple[str, list[str]]:
    """Add the springs that a removed law held at its places as a part of its curve, and report it."""
    from stiffcal.campaign.model.model_editing import add_effect
    from stiffcal.campaign.model.model_file import place_names
    from stiffcal.model.forms import TorqueCurve, form_of

    settings, changes = campaign.model.parameter_settings(), []
    for joint in range(1, campaign.chain.n_joints + 1):
        (label,) = place_names([joint])
        stem = f"{effect.name}.{label}."
        form = form_of(effect, [name.removeprefix(stem) for name in settings if name.startswith(stem)])
        if label not in removed or not isinstance(form, TorqueCurve):
            continue
        for held in form.includes:
            text, new = add_effect(text, held, joints=[joint], n_joints=campaign.chain.n_joints)
            if new:
                changes.append(f"added {held}: {', '.join(new)} (it was a part of {effect.name})")
    return text, changes


def _form_of(effect: Effect, symbols: Sequence[str]) -> Effect:
    """Return the form of an effect that has these symbols."""
    from stiffcal.model.forms import form_of, symbols_of

    form = form_of(effect, symbols)
    known = symbols_of(form)
    if set(symbols) <= set(known):
        return form
    unknown = ", ".join(symbol for symbol in symbols if symbol not in known)
    mend = f"its usual form has {', '.join(spec.symbol for spec in effect.parameters)}"
    reason = f"{effect.name} has no form with the parameters {unknown}"
    raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--start", reason, mend)


def _set_start(
    text: str, campaign: Campaign, effect: str, start: Mapping[str, float], given: Mapping[str, Sequence[Any]]
) -> str:
    """Write values from which an effect's fit starts at these places: the file then holds the form that they are of."""
    from stiffcal.campaign.model.model_editing import set_starts
    from stiffcal.campaign.model.model_file import place_names

    labels = place_names(given["joints"], given["links"], given["pairs"]) or ["setup"]
    values = {f"{effect}.{label}.{symbol}": value for label in labels for symbol, value in start.items()}
    return set_starts(text, effect, values, campaign.chain.n_joints)[0]


def _bend(text: str, campaign: Campaign, effect: Effect, given: Mapping[str, Sequence[Any]]) -> tuple[str, str]:
    """Name the amplitudes of the effect's curved form at these places, and report it."""
    from stiffcal.campaign.model.model_editing import set_starts
    from stiffcal.campaign.model.model_file import place_names
    from stiffcal.model.forms import curve_of, symbols_of

    labels = place_names(given["joints"], given["links"], given["pairs"])
    curve = curve_of(effect) or effect
    bends = [symbol for symbol in symbols_of(curve) if symbol not in symbols_of(effect)]
    values = {f"{effect.name}.{label}.{symbol}": 0.0 for label in labels for symbol in bends}
    text, new = set_starts(text, effect.name, values, campaign.chain.n_joints)
    new_labels = [label for label in labels if any(name.split(".")[1] == label for name in new)]
    change = f"{effect.name} is already curved there: nothing changed"
    return text, f"curved: {', '.join(new_labels)}" if new_labels else change


def _no_curve(effect: str, catalogue: Mapping[str, Effect]) -> NoReturn:
    from stiffcal.model.forms import curve_of

    curves = ", ".join(name for name, effect_type in sorted(catalogue.items()) if curve_of(effect_type))
    mend = f"those that have: {curves}; a drive's curve is cubic-stiffness"
    raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--curved", f"{effect} has no curved form", mend)


def places_at(
    campaign: Campaign,
    joints: Iterable[int | str] = (),
    links: Iterable[str] = (),
    pairs: Iterable[Sequence[int | str]] = (),
) -> Where:
    """Return places whose joints are given by number or by name.

    Raises
    ------
    InputError : the robot has no such joint, or a pair has not two.
    """
    return Where(
        joints=[_joint(joint, campaign, "joints") for joint in joints] or None,
        links=list(links) or None,
        pairs=[list(_pair(pair, campaign)) for pair in pairs] or None,
    )


def _held(campaign: Campaign, effect: str) -> list[str]:
    """Return the places at which the model holds an effect, as parameter names have them."""
    entries = [entry for entry in campaign.model.effects if entry.type == effect]
    joints = [f"j{joint}" for entry in entries for joint in entry.joints or []]
    pairs = ["-".join(f"j{joint}" for joint in pair) for entry in entries for pair in entry.pairs or []]
    return [*joints, *(link for entry in entries for link in entry.links or []), *pairs]


def _given(where: Where, kind: str, campaign: Campaign) -> dict[str, Sequence[Any]]:
    """Return the places by kind, checked against the robot's joints and the kind of place at which the effect acts."""
    places: dict[str, Sequence[Any]] = {"joints": (), "links": (), "pairs": ()}
    for name, given in where.items():
        if name != kind:
            at, mend = (kind, f"use --{kind} instead") if kind in places else ("the set-up", "leave the place out")
            raise InputError.at(FaultCode.PLACE_INVALID, "command line", f"--{name}", f"this effect acts at {at}", mend)
        if name == "joints":
            places[name] = [_joint(joint, campaign, name) for joint in given]
        elif name == "links":
            places[name] = given
        else:
            places[name] = [_pair(pair, campaign) for pair in given]
    return places


def _joint(word: int | str, campaign: Campaign, option: str) -> int:
    names = campaign.chain.joint_names
    if isinstance(word, int) and 1 <= word <= len(names):
        return word
    if isinstance(word, str) and word in names:
        return names.index(word) + 1
    if isinstance(word, str) and len(word) < 10 and word.isdecimal() and 1 <= int(word) <= len(names):
        return int(word)
    mend = f"number 1 to {len(names)}, or one of {', '.join(names)}"
    raise InputError.at(FaultCode.JOINT_UNKNOWN, "command line", f"--{option}", f"unknown joint {word}", mend)


def _pair(ends: Sequence[int | str], campaign: Campaign) -> tuple[int, int]:
    if len(ends) != 2:
        word = "-".join(str(end) for end in ends)
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--pairs", f"{word} is not a pair", "write it like 5-6"
        )
    a, b = sorted(_joint(end, campaign, "pairs") for end in ends)
    return a, b


def _every_place(places: Sequence[Any], kind: str) -> dict[str, Sequence[Any]]:
    by_kind: dict[str, Sequence[Any]] = {"joints": (), "links": (), "pairs": ()}
    if kind == "joints":
        by_kind[kind] = [place.joints[0] for place in places]
    elif kind == "pairs":
        by_kind[kind] = [place.joints for place in places]
    elif kind == "links":
        by_kind[kind] = [place.link for place in places]
    return by_kind


def _check_possible(
    effect: Effect, given: Mapping[str, Sequence[Any]], possible: Sequence[str], prismatic: frozenset[int]
) -> None:
    from stiffcal.campaign.model.model_file import place_names

    if not any(given.values()):
        return
    joints = [joint for joint in given["joints"] or () if joint in prismatic]
    pairs = [pair for pair in given["pairs"] or () if prismatic.intersection(pair)]
    at_prismatic = place_names(joints, (), pairs)
    for label in place_names(given["joints"], given["links"], given["pairs"]):
        if label not in possible:
            mend = f"possible: {', '.join(possible) or 'none on this robot'}"
            reason = f"{effect.name} cannot act at {label}"
            if label in at_prismatic and isinstance(effect.prismatic, str):
                reason += f", a prismatic joint: {effect.prismatic}"
            raise InputError.at(FaultCode.PLACE_INVALID, "command line", "EFFECT", reason, mend)


def _check_not_included(
    campaign: Campaign, catalogue: Mapping[str, Effect], effect: str, given: Mapping[str, Sequence[Any]]
) -> None:
    """Raise where an effect of the model includes the new one at the same place: that adds nothing."""
    from stiffcal.campaign.model.model_file import place_names

    places = place_names(given["joints"], given["links"], given["pairs"])
    for entry in campaign.model.effects:
        present = catalogue.get(entry.type)
        if present is None or effect not in present.includes:
            continue
        there = place_names(entry.joints or (), entry.links or (), entry.pairs or ())
        shared = [label for label in there if label in places]
        if shared:
            reason = f"{entry.type} in the model includes {effect} at {', '.join(shared)}"
            others = [label for label in places if label not in shared]
            rest = f"add it at {', '.join(others)} alone" if others else "nothing is to be added"
            mend = f"{rest}; for {effect} alone, remove {entry.type} there first"
            raise InputError.at(FaultCode.EFFECT_CONFLICT, "command line", effect, reason, mend)


def _remove_replaced(
    text: str, campaign: Campaign, effect: Any, given: Mapping[str, Sequence[Any]]
) -> tuple[str, list[str]]:
    """Take out what the new effect includes or excludes at the same places, and report it."""
    from stiffcal.campaign.model.model_editing import remove_effect
    from stiffcal.campaign.model.model_file import place_names

    changes = []
    place_labels = set(place_names(given["joints"], given["links"], given["pairs"]))
    for entry in campaign.model.effects:
        if entry.type not in (*effect.includes, *effect.excludes):
            continue
        shared: dict[str, Sequence[Any]] = {
            "joints": [joint for joint in entry.joints or () if f"j{joint}" in place_labels],
            "links": [link for link in entry.links or () if link in place_labels],
            "pairs": [],
        }
        if not any(shared.values()):
            continue
        text, removed = remove_effect(text, entry.type, **shared, n_joints=campaign.chain.n_joints)
        verb = "includes" if entry.type in effect.includes else "excludes"
        changes.append(f"removed {entry.type}: {', '.join(removed)} ({effect.name} {verb} it)")
    return text, changes
