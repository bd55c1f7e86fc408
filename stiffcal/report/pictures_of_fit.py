"""A picture of the fit that is computed only where it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiffcal.presentation.pictures import Picture
from stiffcal.report.figures.panels import draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class PictureOfFit:
    """What draws one; its content is known by all but `make`, so that a kept picture needs no fit."""

    of: str
    """Which picture, as `plot --of` names it."""
    key: str
    """Of the fit: another one where data, model or revision are others."""
    caption: str
    """What is in it, in words."""
    make: Callable[[], Picture]
    """Computes it."""

    def __call__(self) -> Figure:
        """Compute and draw."""
        return draw_panels(self.make())
