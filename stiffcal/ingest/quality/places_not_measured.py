"""Places and orientations that the manifest names and no instrument measured."""

from __future__ import annotations

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.signals.signals import Deflection, Pose
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.set_aside import SetAsideCode

MOST_ROWS_NAMED = 10


def rows_without_place(states: LoadStates) -> list[str]:
    """Return a warning for rows of absolute runs in which no target was measured."""
    missing = np.flatnonzero(states.absolute & (states.set_aside_code == SetAsideCode.NOT_MEASURED.value))
    if not missing.size:
        return []
    rows = ", ".join(str(int(row)) for row in states.row[missing[:MOST_ROWS_NAMED]])
    more = f" and {missing.size - MOST_ROWS_NAMED} more" if missing.size > MOST_ROWS_NAMED else ""
    return [f"no target was measured in row {rows}{more} of absolute runs: not used"]


def orientations_not_measured(states: LoadStates, campaign: Campaign) -> list[str]:
    """Return a warning for each orientation that the manifest names where no state has one: positions alone count."""
    given = [np.isfinite(part).any() for part in (states.rotation, states.deflection[:, :, 3:])]
    named = [
        (f"sources.{source}.{name}", columns)
        for source, name, signal in campaign.manifest.signals()
        if (columns := _orientation_columns(signal))
    ]
    if any(given) or not named or not states.used.any():
        return []
    return [
        f"{place}: no state has an orientation, {', '.join(columns)} have gaps in all rows: positions alone are used"
        for place, columns in named
    ]


def _orientation_columns(signal: object) -> tuple[str, ...]:
    if isinstance(signal, Pose):
        return () if signal.orientation is None else signal.orientation[1]
    return tuple(signal.rotation or ()) if isinstance(signal, Deflection) else ()
