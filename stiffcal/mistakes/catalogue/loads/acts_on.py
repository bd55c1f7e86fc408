"""The load of the other side: what the robot does to its environment, or what is done to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class ActsOn(InputMistake):
    """The load that acts the other way."""

    name = "acts-on"
    part = InputPart.LOADS
    tried_on = frozenset({TriedOn.DISPLACEMENTS, TriedOn.WORK})
    code = FaultCode.WRENCH_MISMATCH
    rank = 50

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the load with the other sign."""
        opposite = "robot" if read.acts_on == "environment" else "environment"
        yield Way(replace(read.chosen, wrench=-read.chosen.wrench), value=opposite)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        line = toml_text.pair("acts_on", change.value)
        return ChangeTexts("wrench", f"the load on the {change.value}", f"acts_on is inverted: write {line}")
