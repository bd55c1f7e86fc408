"""Parameters that an effect had in earlier versions and that are another effect's now: old model files stay valid."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tomlkit import TOMLDocument

    from stiffcal.campaign.model_file import EffectEntry

MOVED: dict[str, dict[str, str]] = {
    "joint-friction": {"stribeck": "stribeck", "velocity": "stribeck", "exponent": "stribeck"}
}
"""Effect to its former parameters and the effect that has each of them now, under the same symbol, since 0.2."""
_NAME = re.compile(r"([\w-]+)\.j(\d+)\.(\w+)", re.ASCII)


def with_moved_parameters(entries: tuple[EffectEntry, ...]) -> tuple[EffectEntry, ...]:
    """Return a model's effects with settings of former parameters as effects of their own, right after the former one.

    Values and ``fixed`` are kept. The new effect sits at the joints that have such settings.
    """
    result: list[EffectEntry] = []
    for entry in entries:
        moved = _moved(entry.type, entry.parameters)
        names = {old for settings in moved.values() for old in settings}
        kept = {name: setting for name, setting in entry.parameters.items() if name not in names}
        result.append(entry.model_copy(update={"parameters": kept}) if moved else entry)
        for successor, settings in moved.items():
            parameters = {_NAME.sub(rf"{successor}.j\2.\3", name): entry.parameters[name] for name in settings}
            update = {"type": successor, "joints": _joints(settings), "parameters": parameters}
            result.append(entry.model_copy(update=update))
    return tuple(result)


def move_in_document(document: TOMLDocument) -> None:
    """Write former parameters of a model file that is being edited as the effects that have them now."""
    import tomlkit

    effects: Any = document.get("effects", [])
    for index in reversed(range(len(effects))):
        entry = effects[index]
        settings = entry.get("parameters", {})
        for successor, names in _moved(str(entry.get("type")), settings).items():
            parameters: Any = tomlkit.table()
            for name in names:
                parameters[_NAME.sub(rf"{successor}.j\2.\3", name)] = settings[name]
                del settings[name]
            new: Any = tomlkit.table()
            new["type"], new["joints"], new["parameters"] = successor, list(_joints(names)), parameters
            if not settings:
                del entry["parameters"]
            effects.insert(index + 1, new)


def _moved(effect: str, names: Iterable[str]) -> dict[str, list[str]]:
    """Return successor to the names of the settings, of those of one effect, that are its parameters now."""
    moved: dict[str, list[str]] = {}
    for name in names:
        match = _NAME.fullmatch(name)
        successor = MOVED.get(effect, {}).get(match[3]) if match and match[1] == effect else None
        if successor is not None:
            moved.setdefault(successor, []).append(name)
    return moved


def _joints(names: Iterable[str]) -> tuple[int, ...]:
    """Return the joints of parameters' names, increasing."""
    return tuple(sorted({int(name.split(".")[1][1:]) for name in names}))
