"""Stretches of logs that no state and no reading uses: the cause as a code with its figures, and its words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from stiffcal.wording import significant


class UnusedCode(StrEnum):
    """Causes for which a stretch of a log is not used; the words are those of ``code`` in the answer of `ingest`."""

    TOO_FEW_READINGS = "too-few-readings"
    """The log is too short for a hold to be found."""
    NOISE_UNSTEADY = "noise-unsteady"
    """The noise of the holds does not converge."""
    NEVER_HELD = "never-held"
    """No load was held."""
    HELD_BRIEFLY = "held-briefly"
    """A load was held there, too briefly to be read."""
    LOAD_CHANGING = "load-changing"
    """Between two holds."""
    BEFORE_FIRST_LOAD = "before-first-load"
    """The log begins long before the first load."""
    AFTER_LAST_LOAD = "after-last-load"
    """The log runs on long after the last load."""
    NOT_LOGGED = "not-logged"
    """A source was not logging."""
    BETWEEN_SWEPT_LOADS = "between-swept-loads"
    """Between the loads at which a sweep is read."""
    NEVER_STEADY = "never-steady"
    """A stroke of a friction run never held a velocity."""
    EXCLUDED = "excluded"
    """The manifest excludes nearly all rows of a stretch at constant velocity."""


@dataclass(frozen=True)
class UnusedStretch:
    """A stretch of a log that no state uses."""

    start: float
    """Its start, s on the first source's clock."""
    end: float
    """Its end, likewise."""
    code: UnusedCode
    """Why it is not used."""
    source: str = ""
    """The source that was not logging, where that is the cause."""
    stroke: float = math.nan
    """Of a stroke that never held a velocity: how far the joint moved, rad."""
    speed: float = math.nan
    """Of such a stroke: its largest velocity, rad/s."""


def by_cause(stretches: Sequence[UnusedStretch]) -> list[list[UnusedStretch]]:
    """Return the stretches in groups of one code and source, in the order in which these first occur."""
    groups: dict[tuple[UnusedCode, str], list[UnusedStretch]] = {}
    for stretch in stretches:
        groups.setdefault((stretch.code, stretch.source), []).append(stretch)
    return list(groups.values())


def cause_text(group: Sequence[UnusedStretch]) -> str:
    """Return why the stretches of a group are not used, for people; ranges where their figures differ.

    Examples
    --------
    >>> cause_text([UnusedStretch(0.0, 4.0, UnusedCode.NOT_LOGGED, source="tracker")])
    'tracker was not logging'
    >>> strokes = [UnusedStretch(0.0, 1.0, UnusedCode.NEVER_STEADY, stroke=size, speed=2.0) for size in (0.4, 0.8)]
    >>> cause_text(strokes)[:72]
    'a stroke of 23 to 46° has no phase of constant velocity (fastest 2.0 rad'
    """
    code = group[0].code
    if code == UnusedCode.NOT_LOGGED:
        return f"{group[0].source} was not logging"
    if code == UnusedCode.NEVER_STEADY:
        stroke = _range([math.degrees(stretch.stroke) for stretch in group])
        speed = _range([stretch.speed for stretch in group])
        return f"a stroke of {stroke}° has no phase of constant velocity (fastest {speed} rad/s): it is too short"
    return _TEXTS[code]


def _range(values: Sequence[float]) -> str:
    low, high = significant(min(values), 2), significant(max(values), 2)
    return low if low == high else f"{low} to {high}"


_TEXTS = {
    UnusedCode.TOO_FEW_READINGS: "too few readings to find a dwell",
    UnusedCode.NOISE_UNSTEADY: "the noise estimate of the dwells does not converge",
    UnusedCode.NEVER_HELD: "the load was never constant",
    UnusedCode.HELD_BRIEFLY: "dwell too short",
    UnusedCode.LOAD_CHANGING: "load changing or settling",
    UnusedCode.BEFORE_FIRST_LOAD: "before the first load, longer than the dwells",
    UnusedCode.AFTER_LAST_LOAD: "after the last load, longer than the dwells",
    UnusedCode.BETWEEN_SWEPT_LOADS: "between the loads at which a sweep is read",
    UnusedCode.EXCLUDED: "[[exclude]] leaves hardly a row of the phase of constant velocity",
}
