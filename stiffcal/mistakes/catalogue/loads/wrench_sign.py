"""One force with the wrong sign."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class WrenchSign(InputMistake):
    """The other sign of one column of forces."""

    name = "wrench-sign"
    part = InputPart.LOADS
    tried_on = frozenset({TriedOn.DISPLACEMENTS})
    code = FaultCode.WRENCH_MISMATCH
    rank = 52

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the load with the other sign of each force."""
        for k, name in enumerate(read.columns[:3]):
            wrench = read.chosen.wrench * np.where(np.arange(6) == k, -1.0, 1.0)
            yield Way(replace(read.chosen, wrench=wrench), (name,))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (name,) = change.names
        return ChangeTexts(f"column {name}", f"column {name} with the other sign", "correct its sign in the log")
