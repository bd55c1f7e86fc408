"""Effects that change nothing but what links weigh."""

from __future__ import annotations

from stiffcal.model.effect import Geometry


class LinkMoments(Geometry):
    """The set-up parameters change nothing but the links' weight, in proportion (`adjusted_chain`): kg or kg·m.

    Their columns are one balance of moments (`weight_columns`), and a scale that they share with compliances is looked
    for (`load_scale`).
    """
