"""Readings of instruments that stood in several places, in the axes of each and in those of the base."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates, TrackerPlace


def each_tracker(trackers: Sequence[TrackerPlace], number: Integers) -> Iterator[tuple[Booleans, Floats]]:
    """Yield of each tracker that reads any state (n,) True for the states that it reads, and (4, 4) base_from_frame.

    Parameters
    ----------
    trackers : of the set-up.
    number : (n,) which of them reads each state.
    """
    for own, tracker in enumerate(trackers):
        states = np.asarray(number == own)
        if states.any():
            yield states, tracker.base_from_frame


def places_in_tracker(states: LoadStates) -> Floats:
    """Return (n, B, 3) the targets' places in the axes of the tracker that read them, m."""
    places = np.empty_like(states.position)
    for read, placed in each_tracker(states.setup.trackers, states.tracker):
        places[read] = (states.position[read] - placed[:3, 3]) @ placed[:3, :3]
    return places


def with_places_in_tracker(states: LoadStates, places: Floats) -> LoadStates:
    """Return states with the targets elsewhere: (n, B, 3) in the axes of the tracker that read them, m."""
    position = np.empty_like(states.position)
    for read, placed in each_tracker(states.setup.trackers, states.tracker):
        position[read] = places[read] @ placed[:3, :3].T + placed[:3, 3]
    return replace(states, position=position)
