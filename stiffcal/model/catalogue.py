"""The catalogue of effects: found by walking the folder, never by naming one."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import sys
from collections.abc import Iterable
from contextlib import redirect_stdout
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.model.effect import Effect
from stiffcal.model.plugin_notice import announce

ENTRY_POINT_GROUP = "stiffcal.effects"


def _effects_of(module: object) -> list[Effect]:
    found = []
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
            found.append(member())
    return found


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


def load_plugin(file: Path) -> list[Effect]:
    """Load the effects that a user's Python file defines. The file is code and runs; its user is told before.

    Raises
    ------
    InputError : the file is missing, does not run, or defines no effect.
    """
    if not file.is_file():
        raise InputError.at(str(file), "plugins", "no such file", "correct the name in campaign.toml")
    specification = importlib.util.spec_from_file_location(f"stiffcal_plugin_{file.stem}", file)
    if specification is None or specification.loader is None:
        raise InputError.at(str(file), "plugins", "not a Python file", "name a file that ends in .py")
    module = importlib.util.module_from_spec(specification)
    try:
        content = file.read_bytes()
        announce(file, content)
        with redirect_stdout(sys.stderr):  # what it prints must not get into an answer
            # these bytes and no others: the file may change between the notice and a second reading
            exec(compile(content, str(file), "exec"), module.__dict__)
    except Exception as fault:
        reason = f"does not run: {type(fault).__name__}: {fault}"
        raise InputError.at(str(file), "plugins", reason, "mend the file") from fault
    effects = _effects_of(module)
    if not effects:
        raise InputError.at(
            str(file), "plugins", "defines no effect", "derive a class from DocumentedEffect, with a name"
        )
    return effects


def find_effects(plugins: Iterable[Path] = ()) -> dict[str, Effect]:
    """Return the whole catalogue by name: built in, installed, and the user's own files.

    Raises
    ------
    InputError : a plugin is broken or takes the name of an effect that exists.
    """
    effects = dict(built_in_effects())
    for file in plugins:
        for effect in load_plugin(file):
            if effect.name in effects:
                raise InputError.at(str(file), effect.name, "this effect exists already", "choose another name")
            effects[effect.name] = effect
    return effects
