"""What the pages on several tracked bodies show of each joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class JointCurve:
    """One component of a joint's own displacement over the same component of the wrench that it carries.

    Attributes
    ----------
    component : "tx", "ty", "tz", "rx", "ry" or "rz", joint axes.
    load : (n,) N or N·m. moved : (n,) m or rad, its run's offset taken off. run : (n,) indices into the runs' names.
    curve : (3,) of δ = c₁ w + c₂ w² + c₃ w³.
    compliance, std : of the straight line, m/N or rad/(N·m); NaN where no load turns it.
    above_noise, curved : as judged.
    """

    component: str
    load: Floats
    moved: Floats
    run: NDArray[np.int64]
    curve: tuple[float, float, float]
    compliance: float
    std: float
    above_noise: bool
    curved: bool


@dataclass(frozen=True)
class JointPicture:
    """A joint between two tracked bodies.

    Attributes
    ----------
    name : the joint's. between : the two targets, "base" inboard of all.
    runs : names of the runs that the curves count.
    curves : six, translations first.
    together : component to (compliance, standard uncertainty, above the noise) by the fit of all joints at once, as far
        as its model holds such a spring.
    laws : component to loads and displacements, (k,) each, by the laws of that fit: straight, curved, with play.
    couplings : (displacement, load) beside the diagonal of the whole 6×6 that rise above the noise; None where the
        loads do not turn all six directions.
    """

    name: str
    between: tuple[str, str]
    runs: tuple[str, ...]
    curves: tuple[JointCurve, ...]
    together: dict[str, tuple[float, float, bool]]
    couplings: tuple[tuple[str, str], ...] | None = None
    laws: Mapping[str, tuple[Floats, Floats]] = field(default_factory=dict)
