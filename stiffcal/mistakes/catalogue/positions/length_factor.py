"""Absolute places in another unit than stated: all of them, those of one target, of one axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way
from stiffcal.wording import significant

FACTORS = {
    1e-3: "a thousand times too large",
    1e3: "a thousand times too small",
    1e-1: "ten times too large",
    1e1: "ten times too small",
    1e-2: "a hundred times too large",
    1e2: "a hundred times too small",
    25.4: "in inches and read as millimetres",
    1.0 / 25.4: "in millimetres and read as inches",
}
"""Factors that lengths may have to be multiplied by, and what these are without."""
_OF_ONE_AXIS = (1e3, 1e-3)  # metres in a column of millimetres, and the other way round


class LengthFactor(InputMistake):
    """Lengths that are too large or too small by what units differ by."""

    name = "length-factor"
    part = InputPart.POSITIONS
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS})
    code = FaultCode.UNIT_IMPLAUSIBLE
    rank = 30

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield positions in another unit: of all targets, of one, of one axis."""
        names, position = read.states.setup.target_names, read.chosen.position
        for factor in FACTORS:
            yield Way(replace(read.chosen, position=factor * position), sizes=(factor,))
            for b, name in enumerate(names if len(names) > 1 else ()):
                one = position.copy()
                one[:, b] *= factor
                yield Way(replace(read.chosen, position=one), (name,), (factor,))
        for k, axis in enumerate("XYZ"):
            for factor in _OF_ONE_AXIS:
                one = position.copy()
                one[..., k] *= factor
                yield Way(replace(read.chosen, position=one), (), (factor,), axis)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (factor,) = change.sizes
        wrong = FACTORS[factor]
        if change.value:
            of, place = f"{change.value} of the positions", f"columns {change.value} of the positions"
            mend = f"{of} is {wrong}: correct its column"
            return ChangeTexts(place, f"{of} multiplied by {significant(factor, 4)}", mend, f"{of} is {wrong}")
        of = f"the positions of {change.names[0]}" if change.names else "the positions"
        place = f"poses.{change.names[0]}.units.position" if change.names else "units.position"
        mend = f"{of} are {wrong}: correct their unit"
        return ChangeTexts(place, f"{of} multiplied by {significant(factor, 4)}", mend, f"{of} are {wrong}")

    def is_in_manifest(self, change: InputChange) -> bool:
        """Return whether a unit is wrong that the manifest states, not that of one axis."""
        return not change.value
