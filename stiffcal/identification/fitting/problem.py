"""What a fit is made from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.identification.readings.observations import Observations


@dataclass(frozen=True)
class Problem:
    """Observations with what is known of their repeats."""

    data: Observations
    """The observations that may be used to fit."""
    groups: tuple[NDArray[np.int64], ...]
    """Positions in ``data`` of states that repeat each other."""
    stated: Noise | None
    """The manifest's noise, or None."""
