"""Forces and moments of which one is in another unit than stated.

Both in other units by one factor make all compliances other by that factor: no displacement shows it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.deciding import CLEARLY_LESS
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, Scored, TriedOn, Way
from stiffcal.quantities import unit, unit_names

_FORCES = ("N", "kN", "kgf", "lbf")


class LoadUnits(InputMistake):
    """Another unit of forces against moments."""

    name = "load-units"
    part = InputPart.LOADS
    tried_on = frozenset({TriedOn.WORK})
    code = FaultCode.UNIT_IMPLAUSIBLE
    rank = 54

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the load in other units, each ratio of moments to forces once, that of a usual pair of units."""
        if len(read.load_units) != 2 or not np.any(read.chosen.wrench[:, 3:]):
            return
        own = (unit(read.load_units[0], "force"), unit(read.load_units[1], "moment"))
        known = {1.0}
        for force, moment in _pairs(own[0].name, own[1].name):
            factors = unit(force, "force").factor / own[0].factor, unit(moment, "moment").factor / own[1].factor
            ratio = float(f"{factors[1] / factors[0]:.6g}")
            if ratio not in known:
                known.add(ratio)
                wrench = read.chosen.wrench * np.repeat(factors, 3)
                yield Way(replace(read.chosen, wrench=wrench), (force, moment), factors)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        force, moment = change.names
        mend = f"write {toml_text.pair('units', {'force': force, 'moment': moment})} if that is what was logged"
        return ChangeTexts("wrench.units", f"forces in {force} and moments in {moment}", mend)

    def as_known(self, best: Scored, tried: Sequence[Scored]) -> InputChange:
        """Return the most usual units of those that the moments do not distinguish from the best."""
        same = (one for one in tried if one.taken.change.kind == self.name)
        return next(one for one in same if 1.0 - best.score >= CLEARLY_LESS * (1.0 - one.score)).taken.change


def _pairs(force: str, moment: str) -> list[tuple[str, str]]:
    """Return units of force and moment, of which one is as stated or the second one is made of the first."""
    pairs = [(one, other) for one in _FORCES for other in unit_names("moment")]
    made = [(one, other) for one, other in pairs if other.startswith(f"{one}*")]
    return made + [
        (one, other) for one, other in pairs if (one, other) not in made and (one == force or other == moment)
    ]
