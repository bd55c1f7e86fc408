"""What one of several searches for missing effects is of, in words; its kind of experiment says it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SearchSubject:
    """Readings of single joints that are searched apart."""

    name: str
    """In answers, as `ProposedEffect.searched_in` has it."""
    title: str
    """In words: "Torque over motion"."""
    left_out: str
    """Where an error that is that of the instruments was found: "at held-out speeds"."""
