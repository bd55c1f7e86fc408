"""What effects that only absolute poses show need of the data."""

from __future__ import annotations

from stiffcal.measurements.load_states import LoadStates


def lacks_absolute_places(states: LoadStates) -> str | None:
    """Return what is missing where no state holds an absolute place; None where one does.

    Displacements under load do not depend on the geometry to first order: both of their ends move with it.
    """
    return None if states.absolute.any() else 'absolute poses: runs with experiment = "absolute"'
