"""What a kind of experiment gives the page for a browser: its readings as rows that can be drawn and selected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats


@dataclass(frozen=True)
class DrawnVariable:
    """Something that a residual can be drawn against."""

    name: str
    """For programs: "speed"."""
    label: str
    """As it is printed."""
    unit: str
    """As it is printed; "" where there is none."""
    values: Floats
    """(n,) in that unit; NaN where not known."""
    levels: list[str] = field(default_factory=list)
    """Texts of the values 0, 1, …; empty where values are numbers."""


@dataclass(frozen=True)
class DrawnPart:
    """What an effect of the model adds to the prediction."""

    effect: str
    """``effect place``."""
    joint: int
    """From 1."""
    values: Floats
    """(n,) in the measure's unit, SI."""


@dataclass(frozen=True, kw_only=True)
class DrawnRows:
    """n rows of a kind of experiment, in the numbering of `RowProblem.index`."""

    run: NDArray[np.str_]
    """(n,) name of the run."""
    measured: Floats
    """(n,) SI, what the model explains of the reading."""
    fitted: Booleans
    """(n,) True for the rows of `fit_table`, in its order."""
    judged: Booleans
    """(n,) True for the rows of `heldout_table`, in its order."""
    fit_table: str
    """Name of the table with a row for each fitted one."""
    heldout_table: str
    """Name of the table with a row for each that was judged on a fit without it."""
    residual: str
    """Name of the column of either table that holds the residual, SI."""
    direction: str
    """Name of the variable by which errors are cut next to the run."""
    variables: list[DrawnVariable]
    parts: list[DrawnPart]
    """Of each effect of the model with the values of the fit."""
    readings: Mapping[str, Floats]
    """(n,) each: what a row was made of, by name and unit."""
