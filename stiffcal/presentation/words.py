"""Texts piece by piece, with numbers that are written when they are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from stiffcal.estimate import Estimate


@dataclass(frozen=True)
class Digits:
    """A number in a text; what is not known is drawn as a dash."""

    value: float | None
    significant: int = 3


@dataclass(frozen=True)
class Names:
    """Names listed in a text."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class Joints:
    """Joints listed in a text, from 1."""

    joints: tuple[int, ...]


Words: TypeAlias = tuple[str | Digits | Estimate | Names | Joints, ...]
"""A text, piece by piece; nothing stands between the pieces. An estimate with a quantity is written with its unit; in a
table it has that of the column."""
