"""Files as a lab would add them: a log format, an effect, a mistake, a kind of experiment, a section, an answer.

Nothing in stiffcal knows of them. `dropped_in` puts a folder of them behind the one that a registry walks.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stiffcal.model.catalogue.catalogue import built_in_effects

FOLDER = Path(__file__).parent
PACKAGES = {
    "readers": "stiffcal.readers",
    "effects": "stiffcal.effects",
    "mistakes": "stiffcal.mistakes.catalogue",
    "exchanged_mistakes": "stiffcal.mistakes.catalogue",
    "unfinished_mistakes": "stiffcal.mistakes.catalogue",
    "effect_kinds": "stiffcal.effects",
    "kinds": "stiffcal.kinds",
    "load_kinds": "stiffcal.kinds",
    "state_kinds": "stiffcal.kinds",
    "row_kinds": "stiffcal.kinds",
    "sections": "stiffcal.report.sections",
    "answers": "stiffcal.show.answers",
}


@contextmanager
def dropped_in(*kinds: str) -> Iterator[None]:
    """Have the files of these kinds found as if they lay in the package's own folders, and edit nothing else."""
    before = set(sys.modules)
    packages = [importlib.import_module(PACKAGES[kind]) for kind in kinds]
    for kind, package in zip(kinds, packages, strict=True):
        package.__path__.append(str(FOLDER / kind))
    built_in_effects.cache_clear()
    importlib.invalidate_caches()
    try:
        yield
    finally:
        for kind, package in zip(kinds, packages, strict=True):
            package.__path__.remove(str(FOLDER / kind))
            for name in set(sys.modules) - before:
                module = sys.modules[name]
                if str(getattr(module, "__file__", "")).startswith(str(FOLDER / kind)):
                    del sys.modules[name]
                    delattr(package, name.rpartition(".")[2])
        built_in_effects.cache_clear()
