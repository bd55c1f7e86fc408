"""The catalogue of effects: found by walking the folder, never by naming one."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import sys
from contextlib import redirect_stdout
from functools import cache
from importlib.metadata import entry_points

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.catalogue.plugin_code import PluginCode, PluginFile
from stiffcal.model.catalogue.plugin_contract import checked_class, checked_effect
from stiffcal.model.catalogue.plugin_loading import load_modules, plugin_faults
from stiffcal.model.effect import Effect

ENTRY_POINT_GROUP = "stiffcal.effects"


def _effects_of(module: object, file: str = "") -> list[Effect]:
    """Return the effects of a module; `file`: of a campaign's own code, whose effects are held to their contract."""
    effects: list[Effect] = []
    for name, member in inspect.getmembers(module, inspect.isclass):
        # a private class is another form of an effect, not one of its own
        if (
            name.startswith("_")
            or not issubclass(member, Effect)
            or inspect.isabstract(member)
            or not getattr(member, "name", "")
        ):
            continue
        if member.__module__ == getattr(module, "__name__", None):
            effects.append(checked_effect(checked_class(member, file)(), file) if file else member())
    return effects


@cache
def built_in_effects() -> dict[str, Effect]:
    """Return the effects of the package and of installed packages' entry points, by name."""
    package = importlib.import_module("stiffcal.effects")
    effects: list[Effect] = []
    for module in pkgutil.iter_modules(package.__path__):
        effects.extend(_effects_of(importlib.import_module(f"stiffcal.effects.{module.name}")))
    for point in entry_points(group=ENTRY_POINT_GROUP):
        effects.append(point.load()())
    return {effect.name: effect for effect in effects}


def find_effects(plugins: PluginCode | None = None) -> dict[str, Effect]:
    """Return the whole catalogue by name: built in, installed, and those of a campaign's own code.

    Raises
    ------
    InputError : the code is not trusted, is broken, defines no effect, or takes the name of an effect that exists.
    """
    effects = dict(built_in_effects())
    if plugins is None or not plugins.files:
        return effects
    sourced_effects: list[tuple[PluginFile, Effect]] = []
    for file, module in zip(plugins.files, load_modules(plugins), strict=True):
        with plugin_faults(file.name), redirect_stdout(sys.stderr):
            sourced_effects += [(file, effect) for effect in _effects_of(module, file.name)]
    if not sourced_effects:
        names = ", ".join(file.name for file in plugins.files)
        raise InputError.at(
            FaultCode.PLUGIN_INVALID,
            names,
            "plugins",
            "defines no effect",
            "derive a class from Law, Geometry, Instrument or Motion, with a name; a Law needs terms",
        )
    for file, effect in sourced_effects:
        if effect.name in effects:
            raise InputError.at(
                FaultCode.PLUGIN_INVALID, file.name, effect.name, "this effect exists already", "choose another name"
            )
        effects[effect.name] = effect
    return effects
