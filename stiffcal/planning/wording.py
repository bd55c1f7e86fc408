"""Sentences on a plan that the terminal, the run sheet and robot programs share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.wording import fixed_places, share, significant

if TYPE_CHECKING:
    from stiffcal.identification.answers.observability import ObservabilityIndices
    from stiffcal.planning.results import AnotherHour, Remedy

OWN_WEIGHT = "own weight"
CANDIDATES = {"load": "pairs of pose and load", "absolute": "poses", "clamped": "pairs of pose and driven joint"}
"""What a plan chooses from, by its experiment."""
# A half width that becomes smaller by less than this share of itself stays.
LEAST_SHARE = 5e-4


def another_hour_text(n_runs: int, hour: AnotherHour) -> str:
    """Return what another hour brings after all runs of a plan.

    Examples
    --------
    >>> from stiffcal.planning.results import AnotherHour
    >>> another_hour_text(14, AnotherHour(runs=6, worst_relative=0.0291, smaller=0.03))
    'after 14 runs another hour (6 more) reduces the largest half width by 3.0 %: ± 2.9 %'
    """
    count = f"{hour.runs} more" if hour.runs > 1 else "1 more, the minimum"
    if hour.smaller < LEAST_SHARE:
        return f"after {n_runs} runs another hour ({count}) does not reduce the largest half width"
    text = f"after {n_runs} runs another hour ({count}) reduces the largest half width by {share(hour.smaller, 2)}"
    return text if hour.worst_relative is None else f"{text}: ± {share(hour.worst_relative, 2)}"


def remedy_text(remedy: Remedy) -> str:
    """Return what would identify a parameter.

    Examples
    --------
    >>> from stiffcal.planning.results import Remedy
    >>> remedy_text(Remedy(parameter="joint-compliance.j6.c", means=["3 times the load", "orientations"]))
    'joint-compliance.j6.c would be identified with 3 times the load, or with orientations'
    """
    if not remedy.means:
        return f"{remedy.parameter}: none of the alternatives that were tried identifies it alone"
    return f"{remedy.parameter} would be identified with {', or with '.join(remedy.means)}"


def indices_text(indices: ObservabilityIndices) -> str:
    """Return the observability indices in a line."""
    values = ", ".join(f"{name} {significant(getattr(indices, name), 3)}" for name in ("O1", "O2", "O3", "O4", "O5"))
    return f"observability of these {indices.n_poses} poses, {indices.n_parameters} parameters: {values}"


def direction_and_sizes(wrench: Floats) -> tuple[str, str] | None:
    """Return the direction of the largest force of load steps (K, 6) in words, and the sizes along it, N.

    None where no step has a force: the robot's own weight is all.
    """
    forces = wrench[:, :3]
    largest = forces[int(np.argmax(np.linalg.norm(forces, axis=1)))]
    if not largest.any():
        return None
    direction = largest / np.linalg.norm(largest)
    sizes = ", ".join(fixed_places(size, 0) for size in forces @ direction)
    return f"({', '.join(fixed_places(part, 2) for part in direction)})", sizes
