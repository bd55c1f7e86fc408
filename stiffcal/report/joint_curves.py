"""What the pages on several tracked bodies show of each joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.identification.bodies.body_results import JointLineResult


@dataclass(frozen=True)
class JointCurve:
    """One component of a joint's own displacement over the same component of the wrench that it carries."""

    line: JointLineResult
    """What was fitted to it."""
    load: Floats
    """(n,) N or N·m."""
    displacement: Floats
    """(n,) m or rad, its run's offset taken off."""
    run: NDArray[np.int64]
    """(n,) indices into the runs' names."""


@dataclass(frozen=True)
class JointPicture:
    """A joint between two tracked bodies."""

    name: str
    """The joint's name."""
    between: tuple[str, str]
    """Names of the two targets, "base" inboard of all."""
    runs: tuple[str, ...]
    """Names of the runs that the curves count."""
    curves: tuple[JointCurve, ...]
    """Six, translations first."""
    together: dict[str, tuple[float, float, bool]]
    """Component to (compliance, standard uncertainty, above the noise) by the fit of all joints at once, as far as its
    model holds such a spring.
    """
    couplings: tuple[tuple[str, str], ...] | None = None
    """(displacement, load) off the diagonal of the whole 6×6 that rise above the noise; None where the loads do not
    turn all six directions.
    """
    laws: Mapping[str, tuple[Floats, Floats]] = field(default_factory=dict)
    """Component to loads and displacements, (k,) each, by the laws of that fit: straight, curved, with play."""
