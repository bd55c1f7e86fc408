"""Adding effects to model.toml and removing them, with the user's comments kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import tomlkit
from tomlkit.items import AoT, Comment, Table, Whitespace

from stiffcal.campaign.model.model_file import MODEL_FILE, EffectEntry, check_model, default_model_text, place_names
from stiffcal.campaign.toml.reach import check_own
from stiffcal.campaign.toml.toml_reading import parse_for_editing, read_toml, toml_text
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import replacing

Places: TypeAlias = dict[str, list[Any]]
"""``joints``, ``links`` and ``pairs``, as far as they are not empty."""


def editable_text(folder: Path, n_joints: int) -> str:
    """Return the text of a campaign's model file, to be edited; where there is none, that of the default model.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    check_own(folder, MODEL_FILE)
    path = folder / MODEL_FILE
    return toml_text(path, MODEL_FILE) if path.exists() else default_text(folder, n_joints)


def default_text(folder: Path, n_joints: int) -> str:
    """Return the default model of a campaign as a model file, its joints one by one."""
    document = parse_for_editing(default_model_text(_experiments(folder)), MODEL_FILE, check_model)
    for entry in document["effects"]:
        if entry.get("joints") == "all":
            entry["joints"] = list(range(1, n_joints + 1))
    return tomlkit.dumps(document)


def save_model(folder: Path, text: str) -> None:
    """Write a campaign's model file whole or not at all; what was written must be a model file."""
    with replacing(folder / MODEL_FILE) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
        check_model(read_toml(temporary, MODEL_FILE))


def add_effect(
    text: str,
    effect: str,
    *,
    joints: Sequence[int] = (),
    links: Sequence[str] = (),
    pairs: Sequence[tuple[int, int]] = (),
    n_joints: int,
) -> tuple[str, tuple[str, ...]]:
    """Add an effect to a model file, or places to an effect that it holds.

    Parameters
    ----------
    text : of the model file.
    effect : its name. That the catalogue holds it, and where it can sit, is for the caller to check.
    joints, links, pairs : the places; none for a set-up effect.
    n_joints : J, for ``joints = "all"``.

    Returns
    -------
    str, tuple of str
        The text with the effect, and the places that are new (``j2``, ``swing``, ``j5-j6``, ``setup``); none where the
        model held all of them.

    Raises
    ------
    InputError
        The model file is faulty.
    """
    document = parse_for_editing(text, MODEL_FILE, check_model)
    wanted = _places(joints, links, pairs)
    same = [entry for entry in document.get("effects", []) if entry.get("type") == effect]
    in_model = {name for entry in same for name in _entry_places(entry, n_joints)}
    new = tuple(name for name in place_names(joints, links, pairs) if name not in in_model)
    if not new:
        return text, ()
    target = next((entry for entry in same if wanted and set(wanted) <= set(entry)), None)
    if target is None:
        _append(document, effect, _only(wanted, new))
    else:
        for key, values in _only(wanted, new).items():
            for value in values:
                target[key].append(value)
    return tomlkit.dumps(document), new


def set_starts(text: str, effect: str, values: Mapping[str, float], n_joints: int) -> tuple[str, tuple[str, ...]]:
    """Name parameters of an effect that the model file holds, with their start values; what is named already stays.

    Parameters
    ----------
    text : of the model file.
    effect : its name.
    values : start, SI, by full name (effect.place.symbol), of places that the effect has there.
    n_joints : J, for ``joints = "all"``.

    Returns
    -------
    str, tuple of str
        The text with them, and the names that are new.
    """
    document = parse_for_editing(text, MODEL_FILE, check_model)
    new = []
    for entry in document.get("effects", []):
        if entry.get("type") != effect:
            continue
        places = _entry_places(entry, n_joints)
        new_names = [
            name for name in values if name.split(".")[1] in places and name not in entry.get("parameters", {})
        ]
        if new_names and "parameters" not in entry:
            entry["parameters"] = tomlkit.table()
        for name in new_names:
            start = tomlkit.inline_table()
            start["value"] = values[name]
            entry["parameters"][name] = start
        new += new_names
    return tomlkit.dumps(document) if new else text, tuple(new)


def remove_effect(
    text: str,
    effect: str,
    *,
    joints: Sequence[int] = (),
    links: Sequence[str] = (),
    pairs: Sequence[tuple[int, int]] = (),
    n_joints: int,
) -> tuple[str, tuple[str, ...]]:
    """Remove an effect from a model file, or some of its places.

    Parameters
    ----------
    text : of the model file.
    effect : its name.
    joints, links, pairs : the places to remove; none of them: the whole effect.
    n_joints : J, for ``joints = "all"``.

    Returns
    -------
    str, tuple of str
        The text without them, and the places that were removed.

    Raises
    ------
    InputError
        The model does not hold the effect, or not at any of these places.
    """
    document = parse_for_editing(text, MODEL_FILE, check_model)
    unwanted = place_names(joints, links, pairs) if (joints or links or pairs) else None
    removed: list[str] = []
    entries = document.get("effects", [])
    for index in reversed(range(len(entries))):
        entry = entries[index]
        if entry.get("type") != effect:
            continue
        places = _entry_places(entry, n_joints)
        going = [name for name in places if unwanted is None or name in unwanted]
        removed = going + removed
        if len(going) == len(places):
            _drop(document, index)
        elif going:
            _thin(entry, set(going), n_joints)
    if not removed:
        in_model = ", ".join(dict.fromkeys(str(entry.get("type")) for entry in entries)) or "nothing"
        where = "" if unwanted is None else f" at {', '.join(unwanted)}"
        raise InputError.at(
            FaultCode.EFFECT_ABSENT,
            MODEL_FILE,
            "effects",
            f"the model contains no {effect}{where}",
            f"it contains {in_model}",
        )
    return tomlkit.dumps(document), tuple(removed)


def _experiments(folder: Path) -> set[str]:
    """Return the kinds of experiment that the manifest names; none where it cannot be read: others complain of that."""
    try:
        check_own(folder, "campaign.toml")
        runs = read_toml(folder / "campaign.toml", "campaign.toml").get("runs", [])
    except InputError:
        return set()
    return {str(run.get("experiment", "load")) for run in runs if isinstance(run, dict)}


def _places(joints: Sequence[int], links: Sequence[str], pairs: Sequence[tuple[int, int]]) -> Places:
    places: Places = {"joints": list(joints), "links": list(links), "pairs": [list(pair) for pair in pairs]}
    return {key: values for key, values in places.items() if values}


def _only(places: Places, names: Sequence[str]) -> Places:
    """Keep the places that are in `names`."""
    selected = {key: [value for value in values if _name(key, value) in names] for key, values in places.items()}
    return {key: values for key, values in selected.items() if values}


def _name(key: str, value: Any) -> str:
    if key == "joints":
        return f"j{value}"
    return str(value) if key == "links" else f"j{value[0]}-j{value[1]}"


def _entry_places(entry: Any, n_joints: int) -> tuple[str, ...]:
    plain = dict(entry.unwrap())
    if plain.get("joints") == "all":
        plain["joints"] = list(range(1, n_joints + 1))
    return EffectEntry.model_validate(plain).places


def _append(document: tomlkit.TOMLDocument, effect: str, places: Places) -> None:
    entry: Any = tomlkit.table()
    entry["type"] = effect
    for key, values in places.items():
        entry[key] = values
    effects = document.get("effects")
    if effects is None:
        effects = tomlkit.aot()
        document["effects"] = effects
        effects = document["effects"]
    if isinstance(effects, AoT):
        if len(effects):
            _end_with_blank_line(effects[-1])
        effects.append(entry)
    else:
        inline: Any = tomlkit.inline_table()
        inline.update({"type": effect, **places})
        effects.append(inline)  # effects = [{…}, {…}]


def _end_with_blank_line(table: Table) -> None:
    if not table.as_string().endswith("\n\n"):
        table.add(tomlkit.nl())


def _drop(document: tomlkit.TOMLDocument, index: int) -> None:
    """Remove an entry; comments after its last key stand before the next one and stay."""
    effects: Any = document["effects"]
    trailing: list[Any] = []
    if isinstance(effects, AoT):
        for _, item in reversed(effects[index].value.body):
            if not isinstance(item, Comment | Whitespace):
                break
            trailing.insert(0, item)
    del effects[index]
    if len(effects) == 0:
        document.remove("effects")
    elif index > 0:
        for item in trailing:
            if isinstance(item, Comment):
                effects[index - 1].add(tomlkit.comment(item.as_string().strip().lstrip("#").strip()))


def _thin(entry: Any, going: set[str], n_joints: int) -> None:
    """Remove single places from an entry, and what is set of their parameters."""
    settings = entry.get("parameters", {})
    if entry.get("joints") == "all":
        entry["joints"] = list(range(1, n_joints + 1))
    for key in ("joints", "links", "pairs"):
        values = entry.get(key)
        if values is None:
            continue
        for index in reversed(range(len(values))):
            value = values[index]
            if key == "pairs" and isinstance(value, str):
                value = value.split("-")
            if _name(key, value) in going:
                del values[index]
                for name in [setting for setting in settings if setting.split(".")[1] == _name(key, value)]:
                    del settings[name]
        if len(values) == 0:
            del entry[key]
