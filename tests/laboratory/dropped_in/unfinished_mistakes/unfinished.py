"""A mistake that says nothing of how it reads."""

from __future__ import annotations

from stiffcal.mistakes.inputs.mistake import InputMistake, InputPart, TriedOn


class Unfinished(InputMistake):
    """It has no words."""

    name = "unfinished"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.DISPLACEMENTS})
