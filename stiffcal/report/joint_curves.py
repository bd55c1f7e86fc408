"""What the pages on several tracked bodies show of each joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class JointCurve:
    """One component of a joint's own displacement over the same component of the wrench that it carries."""

    component: str
    """"tx", "ty", "tz", "rx", "ry" or "rz", joint axes."""
    load: Floats
    """(n,) N or N·m. ``moved``: (n,) m or rad, its run's offset taken off. ``run``: (n,) indices into the runs' names.
    """
    displacement: Floats
    run: NDArray[np.int64]
    curve: tuple[float, float, float]
    """(3,) of δ = c₁ w + c₂ w² + c₃ w³."""
    compliance: float
    std: float
    """``compliance``, ``std``: of the straight line, m/N or rad/(N·m); NaN where no load turns it."""
    above_noise: bool
    curved: bool
    """``above_noise``, ``curved``: as judged."""


@dataclass(frozen=True)
class JointPicture:
    """A joint between two tracked bodies."""

    name: str
    """The joint's. ``between``: the two targets, "base" inboard of all."""
    between: tuple[str, str]
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
