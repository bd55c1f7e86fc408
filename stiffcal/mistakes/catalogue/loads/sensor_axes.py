"""A force sensor that is upside down."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class SensorAxes(InputMistake):
    """Half a turn of the sensor about one of its axes."""

    name = "sensor-axes"
    part = InputPart.LOADS
    tried_on = frozenset({TriedOn.DISPLACEMENTS, TriedOn.WORK})
    code = FaultCode.WRENCH_MISMATCH
    rank = 51

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the load with the signs of two axes changed."""
        for k, axis in enumerate("xyz"):
            signs = np.where(np.arange(6) % 3 == k, 1.0, -1.0)
            yield Way(replace(read.chosen, wrench=read.chosen.wrench * signs), (axis,), (np.pi,))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (axis,) = change.names
        mend = f"the sensor is upside down, half a turn about {axis} of its axes: correct its frame"
        return ChangeTexts("wrench", f"the sensor turned by 180° about its {axis}", mend)
