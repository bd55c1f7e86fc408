"""Where the frames of a robot are, as it comes to rest under loads."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class Places:
    """Where frames are in n states."""

    position: Floats
    """(n, B, 3) m, base axes, of the set-up's targets."""
    rotation: Floats
    """(n, B, 3, 3) base_from_target."""
    displacement: Floats
    """(n, B, 6) since the unloaded state of the same run: difference of positions, and rotation vector of R R_refᵀ; m
    and rad, base axes.
    """
    nodes: Floats | None = None
    """(n, 2J + 2, 6) the nodes' own displacements from the unloaded state, node axes; None where not known."""
