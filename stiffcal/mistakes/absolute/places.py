"""Absolute places with a mistake taken back."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.mistakes.absolute.met_places import MeasuredPlaces, places_of
from stiffcal.mistakes.inputs.mistake import AsRead, TakenBack


def undone(read: AsRead, places: MeasuredPlaces, taken: TakenBack) -> MeasuredPlaces:
    """Return the places of the rows that are looked at, with a mistake taken back.

    Parameters
    ----------
    read : as they are read. places : theirs; kinematics is computed anew where angles or the robot are others.
    """
    if taken.states.joints is read.chosen.joints and taken.chain is read.chain:
        return replace(places, measured=taken.states.position)
    return places_of(taken.states, taken.chain)
