"""Names of version 0.1 that keep working in 0.2, each with a DeprecationWarning; version 0.3 is without this file.

What is public is `stiffcal` and `stiffcal.effects_api`. Plugins and notebooks of 0.1 had to import from inside; the
names that they could rely on, those of the README and of `stiffcal.model.effect`, stand in the tables below.
"""

from __future__ import annotations

import functools
import importlib
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeVar

Kind = TypeVar("Kind")

GONE_IN = "0.3"
PUBLIC_FOR_PLUGINS = "stiffcal.effects_api"

METHODS = {"driver": "covariate", "shape_grid": "nonlinear_grid"}
"""Methods of an effect, then and now."""

MEMBERS = {"AMPLITUDE": "AMPLITUDE", "SHAPE": "NONLINEAR", "SETUP": "SETUP"}
"""Members of `Sort`, and of `ParameterRole` that is meant now."""


@dataclass(frozen=True)
class Evidence:
    """A class of version 0.1 that plugins could import and that no command read."""

    text: str
    meaning: str
    check: str


def warn(text: str, stacklevel: int = 3) -> None:
    """Warn that something goes with the next minor version; the warning names the caller's caller.

    Examples
    --------
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     warn("stiffcal.model.effect.Driver is called Covariate")
    >>> str(caught[0].message)
    'stiffcal.model.effect.Driver is called Covariate; the old way goes with stiffcal 0.3'
    """
    warnings.warn(f"{text}; the old way goes with stiffcal {GONE_IN}", DeprecationWarning, stacklevel=stacklevel)


def old_names(module: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """Return the `__getattr__` of a module that some names have left.

    Parameters
    ----------
    module : the module's full name.
    names : old name to new name, with the module's full name and a dot before it where that is another one. What is in
        this module has no new name: nothing uses it any more.
    """

    def find_old(name: str) -> Any:
        new = names.get(name)
        if new is None:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        place, _, word = new.rpartition(".")
        warn(f"{module}.{name} is not used any more" if place == __name__ else f"{module}.{name} is called {new}")
        value = getattr(importlib.import_module(place or module), word)
        if name == "Sort":  # one of its members has another name, too
            return SimpleNamespace(**{old: getattr(value, member) for old, member in MEMBERS.items()})
        return value

    return find_old


def with_old_field(old: str, new: str) -> Callable[[type[Kind]], type[Kind]]:
    """Let a dataclass be made and read with the old name of a field, too."""

    def decorated(kind: type[Kind]) -> type[Kind]:
        original_init = kind.__init__

        @functools.wraps(original_init)
        def make(self: Kind, *given: Any, **named: Any) -> None:
            if old in named:
                warn(f"the field {old} of {kind.__name__} is called {new}")
                named[new] = named.pop(old)
            original_init(self, *given, **named)

        def read(self: Kind) -> Any:
            warn(f"the field {old} of {kind.__name__} is called {new}")
            return getattr(self, new)

        setattr(kind, "__init__", make)  # noqa: B010 (mypy takes no assignment to a method)
        setattr(kind, old, property(read))
        return kind

    return decorated


def take_old_methods(effect: type) -> None:
    """Let the methods that a class of effects defines by their old names count as those of today."""
    for old, new in METHODS.items():
        defined = vars(effect)
        if old in defined and new not in defined:
            warn(f"the method {old} of an effect is called {new} ({effect.__name__})", stacklevel=4)
            setattr(effect, new, defined[old])


def with_old_methods(effect: type[Kind]) -> type[Kind]:
    """Let the methods of the class `Effect` be called by their old names, too."""
    for old, new in METHODS.items():
        setattr(effect, old, _forwarding(effect, old, new))
    return effect


def _forwarding(effect: type, old: str, new: str) -> Callable[..., Any]:
    def forward(self: Any, *given: Any, **named: Any) -> Any:
        warn(f"the method {old} of an effect is called {new}")
        line = type(self).__mro__
        # A class that defines the old name calls this by `super()`: what it inherits is meant, not itself.
        after = max(
            (place + 1 for place, kind in enumerate(line) if old in vars(kind) and kind is not effect), default=0
        )
        inherited = next(vars(kind)[new] for kind in line[after:] if new in vars(kind))
        return inherited(self, *given, **named)

    forward.__name__, forward.__doc__ = old, f"Return what `{new}` returns; its name in version 0.1."
    return forward


class ReadByKey:
    """A result that was a document in version 0.1: it can still be read by key, with a warning.

    Hidden from type checkers, so that the package itself reads attributes alone.
    """

    __slots__ = ()

    if not TYPE_CHECKING:

        def __getitem__(self, key: str) -> Any:
            """Return the value of a key of the result's document."""
            return self._document_with_warning()[key]

        def __contains__(self, key: object) -> bool:
            """Return whether the result's document has a key."""
            return key in self._document_with_warning()

        def __iter__(self) -> Iterator[str]:
            """Yield the keys of the result's document."""
            return iter(self._document_with_warning())

        def get(self, key: str, default: Any = None) -> Any:
            """Return the value of a key of the result's document, or a default."""
            return self._document_with_warning().get(key, default)

        def keys(self) -> Any:
            """Return the keys of the result's document."""
            return self._document_with_warning().keys()

        def items(self) -> Any:
            """Return keys and values of the result's document."""
            return self._document_with_warning().items()

        def _document_with_warning(self) -> dict[str, Any]:
            warn(f"{type(self).__name__} is no longer a dict: read its attributes, or its to_document()", stacklevel=4)
            return self.to_document()


def check_plugin_import(name: str, stacklevel: int = 3) -> None:
    """Warn where a campaign's own code imports from inside the package and not from what is public."""
    if name.startswith("stiffcal.") and name != PUBLIC_FOR_PLUGINS:
        warn(f"{name} is not a public module: import from {PUBLIC_FOR_PLUGINS}", stacklevel + 1)
