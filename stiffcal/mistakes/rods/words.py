"""Lengths as sentences about rods have them."""

from __future__ import annotations

from stiffcal.wording import length


def length_in_words(metres: float) -> str:
    """Return a length in the unit of the tables that it is printed next to.

    Examples
    --------
    >>> length_in_words(1.234e-5)
    '0.0123 mm'
    """
    return length(metres)
