"""Denavit–Hartenberg parameters of the other convention."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class RobotConvention(InputMistake):
    """The other convention of the robot file."""

    name = "robot-convention"
    part = InputPart.ROBOT
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE})
    rank = 42

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the robot as the other convention has it."""
        if read.robot is None or read.robot.convention is None:
            return
        other = "dh" if read.robot.convention == "modified-dh" else "modified-dh"
        chain = chain_of(read.robot.model_copy(update={"convention": other}), read.folder)
        yield Way(read.chosen, value=other, chain=chain)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        line = toml_text.pair("convention", change.value)
        return ChangeTexts("convention", line, f"write {line} in the robot file")
