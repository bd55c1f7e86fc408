"""Signals that never change: the instrument was not connected, or its columns were filled in.

Two readings of an instrument never agree in every digit, whatever was measured. Of a signal whose readings are the same
in all rows of a campaign nothing can be identified, and a fit would take its zeros for a rigid robot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.reduction.logs.reading_bounds import LARGEST_DEFLECTION_M
from stiffcal.reduction.logs.summary import LogSummary
from stiffcal.wording import significant

# Readings below which equal ones say nothing: of one or two load steps a coarse gauge may read the same. Zeros in all
# channels are no reading from the second row on: a load that gives nothing to identify.
LEAST_ROWS, LEAST_ZERO_ROWS = 4, 2
_DISPLACEMENTS = "displacements"
_WORDS: Mapping[str, str] = {
    "translation": _DISPLACEMENTS,
    "rotation": "rotations of the displacement",
    "displacement": _DISPLACEMENTS,
    "position": "positions",
    "marker": "positions of the markers",
    "quaternion": "orientations",
    "lengths": "length changes of the rods",
    "joints.torque": "torques of the joints",
    "joints.current": "currents of the joints",
}
"""What a fit takes for a measured response or load, by the kind of signal. Forces may be zero in runs without a load,
joint angles may stand still; both are judged with the load states."""
# What makes readings change.
_CAUSES = ("joints", "wrench", "mass")
# Of these every signal is another point or rod: one alone may be dead, which is a warning.
_SHARED = ("marker", "lengths")
# What is filled in where it was not measured, while the rest of the same signal was.
_OPTIONAL = ("rotation", "quaternion")


@dataclass
class _Extremes:
    """Least and largest reading of each channel over all logs, and where it stands."""

    file: str
    columns: tuple[str, ...]
    low: Floats
    high: Floats
    n_rows: int

    @property
    def constant(self) -> Booleans:
        """(c,) True where all readings of the channel are the same."""
        return np.asarray(self.low == self.high)

    @property
    def is_zero(self) -> bool:
        """Whether all readings of all channels are zero."""
        return bool((self.constant & (self.low == 0.0)).all())

    @property
    def travel(self) -> float:
        """The largest difference of two readings of a channel."""
        return float(np.nan_to_num(self.high - self.low).max(initial=0.0))

    @property
    def is_dead(self) -> bool:
        """Whether all channels read the same in all rows, enough of them to say."""
        return bool(self.constant.all()) and self.n_rows >= (LEAST_ZERO_ROWS if self.is_zero else LEAST_ROWS)


def constant_signals(logs: Mapping[tuple[str, str, str], LogSummary]) -> tuple[list[Fault], list[str]]:
    """Return a fault for every signal that is the same in all rows, and a warning for every such channel of another.

    Parameters
    ----------
    logs : what was seen of each log, by source, file and run; each was read to its end.
    """
    of_signal = _extremes(logs)
    moved = max((seen.travel for (_, signal), seen in of_signal.items() if _kind(signal) == "position"), default=0.0)
    caused = any(_kind(signal) in _CAUSES and not seen.constant.all() for (_, signal), seen in of_signal.items())
    if not caused and moved <= LARGEST_DEFLECTION_M:
        # one state, written once or several times: no reading need have changed
        of_signal = {key: seen for key, seen in of_signal.items() if seen.is_zero}
    faults: list[Fault] = []
    warnings: list[str] = []
    for (source, signal), seen in of_signal.items():
        kind = _kind(signal)
        alike = [other for (own, name), other in of_signal.items() if own == source and _kind(name) == kind]
        if kind == "joints":
            if seen.is_dead and moved > LARGEST_DEFLECTION_M:
                faults.append(_still_joints(seen, moved))
            elif seen.is_dead and seen.is_zero:
                text = f"all joint angles are zero in all {seen.n_rows} rows: was the pose logged?"
                warnings.append(f"{seen.file}: {text}")
        elif kind in _CAUSES:
            warnings += _moments_of_zero(seen)
        elif seen.is_dead and kind not in _SHARED:
            faults.append(_fault(kind, [seen]))
        elif kind in _SHARED and all(other.is_dead for other in alike):
            faults += [_fault(kind, alike)] if seen is alike[0] else []
        elif seen.n_rows >= LEAST_ROWS:
            warnings += [
                f"{seen.file}: column {column} reads {'0' if low == 0.0 else 'the same'} in all {seen.n_rows} rows: a "
                "dead channel, or it was not measured? it counts as a measurement"
                for column, low, constant in zip(seen.columns, seen.low, seen.constant, strict=False)
                if constant
            ]
    return faults, warnings


def _moments_of_zero(seen: _Extremes) -> list[str]:
    """Return a warning where the moments of a wrench are zero throughout, and its forces are not."""
    zero = seen.constant & (seen.low == 0.0)
    if len(seen.columns) != 6 or seen.n_rows < LEAST_ROWS or not zero[3:].all() or zero[:3].all():
        return []
    text = f"the moments {', '.join(seen.columns[3:])} read 0 in all {seen.n_rows} rows and count as measured"
    mend = "if they were not measured, name the columns of the force alone, and the point where it acts"
    return [f"{seen.file}: {text}; {mend}"]


def _still_joints(seen: _Extremes, moved: float) -> Fault:
    reason = (
        f"all joint angles are the same in all {seen.n_rows} rows, and the measured target moved by "
        f"{significant(moved)} m"
    )
    mend = "log the joint angles of each pose, or check their columns"
    return Fault(FaultCode.READING_IMPLAUSIBLE, seen.file, _place([seen]), reason, mend)


def _extremes(logs: Mapping[tuple[str, str, str], LogSummary]) -> dict[tuple[str, str], _Extremes]:
    of_signal: dict[tuple[str, str], _Extremes] = {}
    for (source, _, _), log in logs.items():
        for signal, low in log.low.items():
            if _kind(signal) not in (*_WORDS, *_CAUSES):
                continue
            high, present = log.high[signal], of_signal.get((source, signal))
            columns = log.columns.get(signal, ())
            if not columns:  # computed from another signal, as torques from currents
                continue
            if present is None:
                file = log.elsewhere.get(signal, log.file)
                of_signal[source, signal] = _Extremes(file, columns, low, high, log.n_rows)
            else:
                present.low, present.high = np.fmin(present.low, low), np.fmax(present.high, high)
                present.n_rows += log.n_rows
    return of_signal


def _kind(signal: str) -> str:
    return signal if signal.startswith("joints") else signal.partition(".")[0]


def _place(signals: Sequence[_Extremes]) -> str:
    columns = [column for seen in signals for column in seen.columns]
    return f"column{'s' * (len(columns) != 1)} {', '.join(columns)}"


def _fault(kind: str, dead: Sequence[_Extremes]) -> Fault:
    alike = "zero" if all(seen.is_zero for seen in dead) else "the same"
    reason = f"all {_WORDS[kind]} are {alike} in all {dead[0].n_rows} rows: nothing was measured"
    mend = "check the instrument and the columns"
    if kind in _OPTIONAL:
        mend = "leave these columns out of campaign.toml if they were not measured"
    return Fault(FaultCode.READING_IMPLAUSIBLE, dead[0].file, _place(dead), reason, mend)
