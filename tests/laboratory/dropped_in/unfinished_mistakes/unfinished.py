"""A mistake that says nothing of how it reads."""

from __future__ import annotations

from stiffcal.mistakes.mistake import InputPart, Mistake, TriedOn


class Unfinished(Mistake):
    """It has no words."""

    name = "unfinished"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.DISPLACEMENTS})
