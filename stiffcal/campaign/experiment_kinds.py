"""The kinds of experiment: found by walking their folder, never by import of one.

Why by walking: the manifest lies below the experiments, yet names one for each run, and holds its table of options.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Protocol, cast

from stiffcal.campaign.found_modules import module_names
from stiffcal.campaign.typed import TomlTable

EXPERIMENTS = "stiffcal.experiments"
"""The package whose folders are the kinds."""


class KnownKind(Protocol):
    """What the campaign has to know of a kind of experiment; see `stiffcal.experiments.ExperimentKind`."""

    @property
    def name(self) -> str:
        """As in ``experiment = "load"`` of a run, and of its table of options."""

    @property
    def options(self) -> type[TomlTable] | None:
        """The table of options, None where a run has none of this kind."""

    @property
    def default_model(self) -> Path | None:
        """The model file of campaigns of this kind alone that have none; None: compliant drives."""

    def state_kind(self) -> object:
        """Return what its load states are, a `stiffcal.identification.state_kinds.StateKind`."""

    def simulation(self) -> object | None:
        """Return the simulation of its runs, a `stiffcal.simulation.kinds.RunSimulation`; None: load cycles."""


def kind_names() -> tuple[str, ...]:
    """Return the names of all kinds of experiment, sorted; nothing is imported for them.

    Examples
    --------
    >>> {"load", "clamped", "friction", "free"} <= set(kind_names())
    True
    """
    return module_names(EXPERIMENTS, folders_alone=True)


def experiment_kind(name: str) -> KnownKind | None:
    """Return the kind of experiment of a name, None where there is none.

    Examples
    --------
    >>> experiment_kind("load").name, experiment_kind("lode")
    ('load', None)
    """
    if name not in kind_names():
        return None
    return cast(KnownKind, importlib.import_module(f"{EXPERIMENTS}.{name}").KIND)
