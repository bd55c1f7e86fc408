"""The kinds of experiment: found by walking their folder, never by import of one.

Why by walking: the manifest lies below the experiments, yet names one for each run, and holds its table of options.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from pathlib import Path
from typing import Protocol, cast

from stiffcal.campaign.found.found_modules import module_names
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.measurements.state_measures import StateMeasure

KINDS = "stiffcal.kinds"
"""The package whose folders are the kinds."""
OF_SOME_KINDS = frozenset({"moved_joint", "fixture_compliance", "approach"})
"""Keys of a run that only runs of some kinds read: those that have them in their `run_keys`."""


class KnownKind(Protocol):
    """What the campaign has to know of a kind of experiment; see `stiffcal.kinds.ExperimentKind`."""

    @property
    def name(self) -> str:
        """As in ``experiment = "load"`` of a run, and of its table of options."""

    @property
    def options(self) -> type[TomlTable] | None:
        """The table of options, None where a run has none of this kind."""

    @property
    def default_model(self) -> Path | None:
        """The model file of campaigns of this kind alone that have none; None: compliant drives."""

    @property
    def measures(self) -> StateMeasure | None:
        """What is measured in the load states of its runs; None where these make none."""

    @property
    def run_keys(self) -> tuple[str, ...]:
        """Those of the manifest's keys of a run that are for some kinds alone, and that it reads."""

    def state_kind(self) -> object:
        """Return what its load states are, a `stiffcal.identification.readings.state_kinds.StateKind`."""

    def simulation(self) -> object | None:
        """Return the simulation of its runs, a `stiffcal.simulation.kinds.RunSimulation`; None: load cycles."""


def kind_names() -> tuple[str, ...]:
    """Return the names of all kinds of experiment, sorted; nothing is imported for them.

    Examples
    --------
    >>> {"load", "clamped", "friction", "free"} <= set(kind_names())
    True
    """
    return module_names(KINDS, folders_alone=True)


def experiment_kind(name: str) -> KnownKind | None:
    """Return the kind of experiment of a name, None where there is none.

    Examples
    --------
    >>> experiment_kind("load").name, experiment_kind("lode")
    ('load', None)
    """
    if name not in kind_names():
        return None
    return cast(KnownKind, importlib.import_module(f"{KINDS}.{name}").KIND)


def measure_of(experiment: str) -> StateMeasure | None:
    """Return what is measured in the load states of runs of a kind of experiment, by its name; None: they make none.

    Examples
    --------
    >>> measure_of("absolute").value
    'place'
    """
    kind = experiment_kind(experiment)
    return None if kind is None else kind.measures


def kinds_that_measure(measure: StateMeasure) -> tuple[str, ...]:
    """Return the names of the kinds of experiment that measure this, sorted.

    Examples
    --------
    >>> "absolute" in kinds_that_measure(StateMeasure.PLACE)
    True
    """
    return tuple(name for name in kind_names() if measure_of(name) is measure)


def any_measures(experiments: Iterable[str], measure: StateMeasure) -> bool:
    """Return whether one of these kinds of experiment measures this."""
    return any(measure_of(name) is measure for name in set(experiments))


def kinds_that_read() -> dict[str, tuple[str, ...]]:
    """Return the kinds of experiment, by name, whose runs read each of the keys that only some kinds have.

    Examples
    --------
    >>> kinds_that_read()["moved_joint"]
    ('clamped', 'friction')
    """
    keys = {name: cast(KnownKind, experiment_kind(name)).run_keys for name in kind_names()}
    return {key: tuple(name for name, own in keys.items() if key in own) for key in sorted(OF_SOME_KINDS)}


def reads(experiment: str, key: str) -> bool:
    """Return whether runs of a kind of experiment, by its name, read a key of `OF_SOME_KINDS`."""
    kind = experiment_kind(experiment)
    return kind is not None and key in kind.run_keys
