"""What a plan is for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal


@dataclass(frozen=True)
class PlanRequest:
    """What a plan is for."""

    purpose: str = "stiffness"
    """"stiffness", "look-alikes" (of the last diagnosis), "region" (of plan.toml), a CSV of poses and loads to predict
    deflection at, or several of these with weights, as "stiffness=2, path.csv=1".
    """
    criterion: Literal["determinant", "worst"] | None = None
    """What counts for "stiffness"; None: "determinant" of absolute places, else "worst"."""
    runs: int | None = None
    """Number of runs; None: as plan.toml has it."""
    force: float | None = None
    """Largest force, N; None: as plan.toml has it."""
    sheet: Path | None = None
    """CSV, workbook or PDF file to write the run sheet to; None: nothing is written."""
    rivals: tuple[str, ...] = ()
    """Effects with their places that the runs are to distinguish, as "backlash j4"; empty: as ``purpose`` has it."""
    program: Path | None = None
    """Robot program to write, its ending states the language (`robot_programs`); None: none is written."""
    campaign: Path | None = None
    """Campaign folder to make ready for the logs; None: none is made."""
