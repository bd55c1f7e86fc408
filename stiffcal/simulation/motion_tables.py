"""The tables of `simulate.toml` that kinds of experiment have, found by walking their folder."""

from __future__ import annotations

from typing import Protocol, cast

from stiffcal.campaign.found.experiment_kinds import experiment_kind, kind_names
from stiffcal.campaign.toml.typed import TomlTable


class _WithTable(Protocol):
    """What `stiffcal.simulation.kinds.RunSimulation` has for this."""

    settings: type[TomlTable]


def motion_tables() -> tuple[tuple[str, type[TomlTable]], ...]:
    """Return each with the name of its kind."""
    kinds = ((name, experiment_kind(name)) for name in kind_names())
    found = ((name, cast("_WithTable | None", kind.simulation())) for name, kind in kinds if kind is not None)
    return tuple((name, simulation.settings) for name, simulation in found if simulation is not None)
