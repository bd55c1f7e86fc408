"""Readings that no robot or instrument gives: most are of a wrong unit (physics, section 0)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats

# Twice around is more than any industrial joint turns, cable hoses allow ±400° at most; 90 rad are 14 turns.
LARGEST_ANGLE_RAD = 4.0 * np.pi
# The longest linear tracks end near that.
LONGEST_TRAVEL_M = 100.0
# Physics, section 0: no robot holds 3·10⁵ N; the strongest sensors in use end near 10⁵ N.
LARGEST_FORCE_N = 3e5
LARGEST_MOMENT_NM = 1e5
# The strongest industrial arm carries 2300 kg.
LARGEST_MASS_KG = 3e3
# A loaded arm gives millimetres; a displacement of half a metre is a unit.
LARGEST_DEFLECTION_M = 0.3
LARGEST_DEFLECTION_RAD = 0.2
# Trackers measure to 100 m.
LARGEST_POSITION_M = 200.0
QUATERNION_SLACK = 1e-3
_ANOTHER_QUANTITY = "is this the column of another quantity?"


@dataclass(frozen=True)
class ImpossibleReading:
    """A reading that no robot or instrument can give."""

    row: int
    """Which of the rows that were looked at, from 0."""
    reason: str
    """What was read, with its unit and column."""
    mend: str
    """What to write instead."""


@dataclass(frozen=True)
class _Bound:
    """The largest reading of a kind, and what to do about a larger one."""

    largest: float
    """SI."""
    reason: str
    """With places for the value and the channel."""
    mend: str
    """Where the unit may be another one, or where no unit is proposed."""
    proposed: str = ""
    """The unit that ``mend`` proposes."""
    otherwise: str = ""
    """What else to try."""

    def advice(self, declared: str | None) -> str:
        """Return what to do where the manifest declares a unit; the proposed one is none where it is that."""
        if self.proposed and declared == self.proposed:
            return " ".join(filter(None, [_ANOTHER_QUANTITY, self.otherwise]))
        return "; ".join(filter(None, [self.mend, self.otherwise]))


def first_impossible(
    name: str,
    values: Floats,
    low: Floats,
    high: Floats,
    columns: Sequence[str],
    slides: Collection[str] = (),
    declared: Mapping[str, str] | None = None,
) -> ImpossibleReading | None:
    """Return the first reading of a signal that no robot or instrument can give, None where all are possible.

    Parameters
    ----------
    name : the signal, as in `LogRows`.
    values : (c, n) the readings, SI.
    low, high : (c,) least and largest value of each channel.
    columns : (c) names of the channels in the log; empty where they have none.
    slides : those of the columns of joints that hold positions of prismatic joints.
    declared : the unit of each column, as the manifest states it.
    """
    declared = declared or {}
    kind = name.split(".")[0]
    if kind == "quaternion":
        length = np.sqrt(np.einsum("cn,cn->n", values, values))
        off = np.flatnonzero(np.abs(length - 1.0) > QUATERNION_SLACK)
        if not off.size:
            return None
        reason = f"quaternion of length {length[off[0]]:.4g}"
        mend = "name its four columns, w first"
        if not length[off[0]]:
            mend = "where the target was lost exclude the row with [[exclude]]; else " + mend
        return ImpossibleReading(int(off[0]), reason, mend)
    if kind == "mass" and (negative := np.flatnonzero(values[0] < 0.0)).size:
        reason = f"a mass of {values[0, negative[0]]:.4g} kg"
        return ImpossibleReading(int(negative[0]), reason, "write the mass at the tool, positive")
    bound = _BOUNDS.get(kind)
    if bound is None or name in ("joints.velocity", "joints.torque", "joints.current", "joints.approach"):
        return None
    largest = bound.largest
    if kind == "joints" and slides and (position := _impossible_position(values, columns, slides, declared)):
        return position
    if kind == "joints" and slides:
        values = np.where(np.isin(columns, list(slides))[:, None], 0.0, values)
    elif np.fmax(np.abs(low), np.abs(high)).max() <= largest:
        return None
    out_of_bounds = np.abs(values) > (_bounds_of_wrench()[: values.shape[0], None] if kind == "wrench" else largest)
    if not out_of_bounds.any():
        return None
    row = int(np.flatnonzero(out_of_bounds.any(axis=0))[0])
    channel = int(np.argmax(out_of_bounds[:, row]))
    column = columns[channel] if channel < len(columns) else str(channel + 1)
    reason = bound.reason.format(value=float(values[channel, row]), channel=column)
    return ImpossibleReading(row, reason, bound.advice(declared.get(column)))


def _impossible_position(
    values: Floats, columns: Sequence[str], slides: Collection[str], declared: Mapping[str, str]
) -> ImpossibleReading | None:
    """Return the first position of a prismatic joint that no robot has."""
    for channel, column in enumerate(columns):
        beyond = np.flatnonzero(np.abs(values[channel]) > LONGEST_TRAVEL_M)
        if column in slides and beyond.size:
            reason = f"a position of {values[channel, beyond[0]]:.4g} m in column {column}"
            other_unit = f'millimetres read as metres? write "mm" for {column}'
            mend = _ANOTHER_QUANTITY if declared.get(column) == "mm" else other_unit
            return ImpossibleReading(int(beyond[0]), reason, mend)
    return None


def _bounds_of_wrench() -> Floats:
    return np.array([LARGEST_FORCE_N] * 3 + [LARGEST_MOMENT_NM] * 3)


_BOUNDS: dict[str, _Bound] = {
    "joints": _Bound(
        LARGEST_ANGLE_RAD,
        "an angle of {value:.4g} rad in column {channel}",
        'degrees declared as radians? write units = { position = "deg" }',
        "deg",
        "motor side? motor = true",
    ),
    "wrench": _Bound(
        LARGEST_MOMENT_NM,
        "a load of {value:.4g} N (or N*m) in column {channel}",
        "correct units.force or units.moment, or the columns",
    ),
    "mass": _Bound(
        LARGEST_MASS_KG,
        "a mass of {value:.4g} kg in column {channel}",
        'grams read as kilograms? write units = { mass = "g" }',
        "g",
    ),
    "position": _Bound(
        LARGEST_POSITION_M,
        "a position of {value:.4g} m in column {channel}",
        'millimetres read as metres? write units = { position = "mm" }',
        "mm",
    ),
    "marker": _Bound(
        LARGEST_POSITION_M,
        "a position of {value:.4g} m in column {channel}",
        'millimetres read as metres? write units = { position = "mm" }',
        "mm",
    ),
    "translation": _Bound(
        LARGEST_DEFLECTION_M,
        "a displacement of {value:.4g} m in column {channel}",
        'millimetres read as metres? write units = { translation = "mm" }',
        "mm",
    ),
    "rotation": _Bound(
        LARGEST_DEFLECTION_RAD,
        "a deflection of {value:.4g} rad in column {channel}",
        "correct units.rotation",
    ),
    "displacement": _Bound(
        LARGEST_DEFLECTION_M,
        "a displacement of {value:.4g} m in column {channel}",
        'millimetres read as metres? write units = { length = "mm" }',
        "mm",
    ),
    "lengths": _Bound(
        0.1,
        "a length change of {value:.4g} m in column {channel}",
        'micrometres read as metres? write units = { length = "um" }',
        "um",
    ),
}
