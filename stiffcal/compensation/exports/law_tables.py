"""Laws and springs of a controller's model as flat tables, as code with arrays of constant size takes them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.compensation.exports.controller_model import ControllerModel
from stiffcal.model.scalar_laws import LawForm

# Stands for infinity, which is no number of C99 or of Structured Text.
ENDLESS = 1e300
_MOST_NUMBERS = 5


@dataclass(frozen=True)
class LawRow:
    """One law."""

    form: LawForm
    """Its formula."""
    joint: int
    """Model joint whose angle it follows, from 0; −1: none."""
    first: int
    """Its first weight."""
    count: int
    """How many weights it has."""
    memory: int
    """Its play operator; −1: none."""
    numbers: tuple[float, ...]
    """Five numbers; of a cubic torque the last two are the angles between which it is the cubic."""


@dataclass(frozen=True)
class LawTables:
    """All laws."""

    laws: tuple[LawRow, ...]
    """One row each."""
    weights: tuple[tuple[int, float], ...]
    """(6 × node + component, factor)."""
    n_memories: int
    """Play operators."""


def law_tables(model: ControllerModel) -> LawTables:
    """Return the laws of a model as tables."""
    laws: list[LawRow] = []
    weights: list[tuple[int, float]] = []
    memories = 0
    for law in model.laws:
        numbers = law.numbers
        if law.form is LawForm.CUBIC_TORQUE:
            low, high = law.straight_between
            numbers = (*numbers, max(low, -ENDLESS), min(high, ENDLESS))
        memory = -1
        if law.form is LawForm.PLAY:
            memory, memories = memories, memories + 1
        numbers = (*numbers, *[0.0] * (_MOST_NUMBERS - len(numbers)))
        laws.append(LawRow(law.form, law.joint - 1, len(weights), len(law.weights), memory, numbers))
        weights += [(6 * node + component, factor) for node, component, factor in law.weights]
    return LawTables(tuple(laws), tuple(weights), memories)


def spring_rows(model: ControllerModel) -> list[tuple[int, int, float]]:
    """Return (to, from, compliance) of every element of the compliance matrix that is not zero."""
    there = zip(*np.nonzero(model.compliance), strict=True)
    return [(int(to), int(source), float(model.compliance[to, source])) for to, source in there]
