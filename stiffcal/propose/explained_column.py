"""What is answered about a column of a table; apart, as every `check` answers with a list of these."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplainedColumn:
    """A column of a table, and what it is taken for."""

    file: str
    """The file that holds it."""
    column: str
    """Its name for the manifest."""
    taken_as: str
    """What it is taken for: joints, force, …, time, run, sigma of another; "" where it is not used."""
    unit: str
    """As the file states it, "" where it does not."""
    why: str
    """By what that was decided."""
