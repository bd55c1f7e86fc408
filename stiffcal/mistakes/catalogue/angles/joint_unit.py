"""One joint in another unit than stated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way
from stiffcal.mistakes.words import reading_of, unit_in_words
from stiffcal.quantities import unit, unit_names

# What a position is multiplied by that was in another unit than the other of the two that people log.
_LENGTHS = {"mm": 1e-3, "m": 1e3}


class JointUnit(InputMistake):
    """Another unit of one joint."""

    name = "joint-unit"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS, TriedOn.REFERENCES, TriedOn.DISPLACEMENTS})
    code = FaultCode.UNIT_IMPLAUSIBLE
    rank = 22

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield each joint in each unit that it is not in."""
        joints, names, prismatic = read.joints, read.names, read.chain.prismatic
        for own in unit_names("angle"):
            factor = unit(own, "angle").factor / read.stated
            for k in np.flatnonzero(~prismatic[: joints.shape[1]] & ~np.isclose(factor, 1.0)).tolist():
                yield Way(read.with_joint(k, factor[k] * joints[:, k]), (names[k],), value=own)
        for k in np.flatnonzero(prismatic[: joints.shape[1]]).tolist():
            for own, length in _LENGTHS.items():
                yield Way(read.with_joint(k, length * joints[:, k]), (names[k],), value=own)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (name,), own = change.names, unit_in_words(change.value)
        return ChangeTexts(
            f"joint {name}",
            f"joint {name} in {own}",
            f"correct the unit of the column of {name}",
            f"{reading_of(name, chain)} is in {own}, that of the others not",
        )
