"""The names of what lies in a package's folders: found by walking, without an import."""

from __future__ import annotations

import pkgutil
import sys
from functools import cache, lru_cache
from importlib.util import find_spec


def package_folders(package: str) -> tuple[str, ...]:
    """Return the folders of a package, by its full name."""
    loaded = sys.modules.get(package)
    return tuple(loaded.__path__) if loaded is not None else _folders_of(package)


def module_names(package: str, *, folders_alone: bool = False) -> tuple[str, ...]:
    """Return the names of a package's modules, sorted.

    Parameters
    ----------
    package : its full name.
    folders_alone : leave out modules that are single files.

    Examples
    --------
    >>> "clamped" in module_names("stiffcal.kinds", folders_alone=True)
    True
    """
    return _names_in(package_folders(package), folders_alone)


@lru_cache(maxsize=64)  # a manifest of thousands of runs asks for each of them
def _names_in(folders: tuple[str, ...], folders_alone: bool) -> tuple[str, ...]:
    modules = pkgutil.iter_modules(folders)
    return tuple(sorted(module.name for module in modules if module.ispkg or not folders_alone))


@cache
def _folders_of(package: str) -> tuple[str, ...]:
    spec = find_spec(package)
    return tuple(spec.submodule_search_locations or ()) if spec is not None else ()
