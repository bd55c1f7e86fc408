"""Load states under weights that hang on a rope: a kind of its own, whose runs are left out one by one."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.state_kinds import StateKind
from stiffcal.kinds import ExperimentKind
from stiffcal.measurements.rms import Rms


class HangingStateKind(StateKind):
    """Displacements under weights."""

    name = "hanging"
    runs = "runs of a rope"
    left_out = "ropes"
    measure = "translation"
    scheme = "each rope left out in turn"

    def folds(self, data: Observations) -> Integers:
        """Return (n,) the run of each state."""
        return np.asarray(np.unique(data.run, return_inverse=True)[1], dtype=np.int64)

    def expected_error(self, error: Rms, whole: Rms, noise: Rms | None) -> str:
        """Return the error under another rope."""
        return f"under another rope {error.translation}"


class HangingKind(ExperimentKind):
    """Weights on a rope."""

    def state_kind(self) -> StateKind:
        """Return displacements, left out by run."""
        return HangingStateKind()


KIND = HangingKind("hanging")
