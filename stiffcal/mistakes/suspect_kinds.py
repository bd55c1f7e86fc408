"""What may be wrong with a run or a row that disagrees with all the others."""

from __future__ import annotations

from enum import StrEnum


class SuspectKind(StrEnum):
    """What is wrong with a run, as far as the others show it."""

    MISLABELLED = "mislabelled"
    SIGN = "sign"
    UNIT = "unit"
    EXCHANGED = "exchanged"
    BUMP = "bump"
    ZERO = "zero"
    KNOCKED = "knocked"
    MOVED = "moved"
    OFF = "off"
    UNKNOWN = "unknown"
