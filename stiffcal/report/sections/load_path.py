"""Paths of loads: where stiffness seems negative (002, Fig. 2)."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.compensation.predict_result import LoadPath
from stiffcal.report import wording
from stiffcal.report.blocks import PictureBlock, ReportSection
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.canvas import AXES_NAMES
from stiffcal.report.figures.load_path import apparent_negative, draw_load_path

ORDER = 100
_TITLE = "Deflection along a path of loads"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out each predicted path."""
    if not content.load_paths:
        return None
    pictures = tuple(PictureBlock(partial(draw_load_path, path), _caption(path)) for path in content.load_paths)
    return ReportSection(_TITLE, pictures)


def _caption(path: LoadPath) -> str:
    corners = [f"({', '.join(wording.significant(value) for value in path.force[corner])})" for corner in path.corners]
    text = f"{path.name}, predicted at {path.pose}."
    if corners:
        text += f" Loads {' → '.join(corners)} N, numbered in the picture."
    negative = [letter for axis, letter in enumerate(AXES_NAMES) if apparent_negative(path, axis).any()]
    if not negative:
        return text + " Force and deflection have the same direction along every axis."
    axis = AXES_NAMES.index(negative[-1])
    against = apparent_negative(path, axis)
    change = float(np.abs(np.diff(path.deflection[:, axis])[against]).sum())
    return (
        f"{text} Along {wording.listing(negative)} the target moves against the force on the thick dashed section "
        f"(along {negative[-1]} by {wording.length(change)}): apparent negative stiffness. It is caused by the force "
        f"along the other axes through the coupling of the joints; the robot is not unstable."
    )
