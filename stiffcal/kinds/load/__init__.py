"""Load states: wrench and joint angles are known, the deflection is measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.kinds import ExperimentKind

if TYPE_CHECKING:
    from stiffcal.identification.readings.state_kinds import StateKind


class LoadKind(ExperimentKind):
    """Displacements under loads that a person puts on the robot."""

    def state_kind(self) -> StateKind:
        """Return poses, and displacements in them."""
        from stiffcal.kinds.load.state_kind import LoadStateKind

        return LoadStateKind()


KIND = LoadKind("load")
