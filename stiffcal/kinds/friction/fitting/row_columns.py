"""What effects of moving joints make of each row: their torque per unit, averaged over the row's samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Effect, Place
from stiffcal.model.motion import as_motion


@dataclass(frozen=True)
class RowColumns:
    """Columns of effects over k rows."""

    rows: FrictionRows
    """The k rows."""
    chain: Chain
    """The robot."""
    _motion: dict[int, tuple[DriveMotion, Integers]] = field(default_factory=dict, compare=False, repr=False)
    """Joint to its samples, and to the row of each."""

    def of(self, effect: Effect, place: Place, shape: Mapping[str, float]) -> dict[str, Floats]:
        """Return amplitude symbol to (k,) torque per unit, N·m; 0 in other joints' rows."""
        motion, _ = self._of_joint(place.joints[0])
        return self.averaged(place, as_motion(effect).motion_columns(place, self.chain, motion, shape))

    def averaged(self, place: Place, columns: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return the means (k,) over each row's samples of columns over the samples of a place's joint."""
        row, k = self._of_joint(place.joints[0])[1], len(self.rows)
        count = np.maximum(np.bincount(self.rows.row, minlength=k), 1)
        return {
            symbol: np.asarray(np.bincount(row, weights=column, minlength=k) / count)
            for symbol, column in columns.items()
        }

    def _of_joint(self, joint: int) -> tuple[DriveMotion, Integers]:
        if joint not in self._motion:
            row = self.rows.row
            self._motion[joint] = self.rows.motion_of(joint), row[self.rows.joint[row] == joint]
        return self._motion[joint]
