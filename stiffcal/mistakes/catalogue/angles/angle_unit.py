"""All joint angles in another unit than stated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way
from stiffcal.mistakes.words import unit_in_words
from stiffcal.quantities import unit, unit_names


class AngleUnit(InputMistake):
    """Another unit of all angles."""

    name = "angle-unit"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS, TriedOn.REFERENCES, TriedOn.DISPLACEMENTS})
    code = FaultCode.UNIT_IMPLAUSIBLE
    rank = 21

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the angles in each unit that is not that of all joints."""
        turning = ~read.chain.prismatic[: read.joints.shape[1]]
        for name in unit_names("angle"):
            factor = np.where(turning, unit(name, "angle").factor / read.stated, 1.0)
            if not np.allclose(factor[turning], 1.0):
                yield Way(read.with_joints(read.joints * factor), value=name)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        own = unit_in_words(change.value)
        mend = f"write {toml_text.pair('units', {'position': change.value})}"
        in_rows = f"joint angles are in {own}, those of the others not"
        return ChangeTexts("units.position", f"joint angles in {own}", mend, in_rows)

    def is_in_manifest(self, change: InputChange) -> bool:
        """Return True: the manifest states one unit for all rows."""
        return True
