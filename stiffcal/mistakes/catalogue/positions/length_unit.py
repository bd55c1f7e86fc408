"""Places of the unloaded poses in metres where millimetres are stated, or in millimetres."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.tracker_axes import places_in_tracker, with_places_in_tracker
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way

_FACTORS = {"mm": 1e-3, "m": 1e3}


class LengthUnit(InputMistake):
    """Another unit of all positions."""

    name = "length-unit"
    part = InputPart.POSITIONS
    tried_on = frozenset({TriedOn.REFERENCES})
    code = FaultCode.UNIT_IMPLAUSIBLE
    rank = 33

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the positions in each unit, as the tracker reads them."""
        own = places_in_tracker(read.chosen)
        for name, factor in _FACTORS.items():
            yield Way(with_places_in_tracker(read.chosen, factor * own), value=name)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = f"write {toml_text.pair('units', {'position': change.value})}"
        return ChangeTexts("units.position", f"positions in {change.value}", mend)

    def is_in_manifest(self, change: InputChange) -> bool:
        """Return True: the manifest states one unit for all rows."""
        return True
