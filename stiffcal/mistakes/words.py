"""Words that several mistakes share."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mechanics.chain import Chain
from stiffcal.quantity import LENGTH

UNIT_WORDS = {
    "deg": "degrees",
    "rad": "radians",
    "rev": "revolutions",
    "mm": "millimetres",
    "in": "inches",
    "m": "metres",
    "arcmin": "arc minutes",
    "arcsec": "arc seconds",
}
"""Units that a sentence spells out."""


def unit_in_words(name: str) -> str:
    """Return a unit as a sentence has it.

    Examples
    --------
    >>> unit_in_words("deg"), unit_in_words("gon")
    ('degrees', 'gon')
    """
    return UNIT_WORDS.get(name, name)


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence lists them.

    Examples
    --------
    >>> listed(["A", "B", "C"])
    'A, B and C'
    """
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def millimetres(lengths: Sequence[float]) -> str:
    """Return lengths in m as a sentence lists them, in mm.

    Examples
    --------
    >>> millimetres([0.001, -0.0205])
    '1.0, -20.5'
    """
    return ", ".join(f"{LENGTH.usual.factor * part:.1f}" for part in lengths)


def sliding(chain: Chain) -> set[str]:
    """Return the names of a robot's prismatic joints."""
    return {name for name, prismatic in zip(chain.joint_names, chain.prismatic, strict=False) if prismatic}


def reading_of(name: str, chain: Chain) -> str:
    """Return what is logged of a joint, as in "the angle of joint A2"."""
    return f"the {'position' if name in sliding(chain) else 'angle'} of joint {name}"
