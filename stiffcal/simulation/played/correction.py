"""What a correcting controller does in one run, over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class Correction:
    """Joint offsets and what they do to frames; between two moments nothing changes."""

    time: Floats
    """(m,) s from the run's first hold: the moments from which the joints stand at new offsets."""
    offset: Floats
    """(m, L) rad, of the logged joints."""
    shift: Mapping[str, Floats]
    """Frame name to (m, 6): how far the offsets move and turn it, m and rad, base axes."""

    def offset_at(self, time: Floats) -> Floats:
        """Return (n, L) the joint offsets at moments."""
        return np.asarray(self.offset[self._cycle(time)])

    def shift_at(self, frame: str, time: Floats) -> Floats:
        """Return (n, 6) how far a frame is moved and turned at moments."""
        return np.asarray(self.shift[frame][self._cycle(time)])

    def _cycle(self, time: Floats) -> NDArray[np.int64]:
        return np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, self.time.size - 1)
