"""What a diagnosis of load states names, by name."""

from __future__ import annotations

from stiffcal.judgement.diagnosed import DiagnosedStates


def named(found: DiagnosedStates) -> list[str]:
    """Return the effects to add, ``effect place``, the largest first."""
    return [one.candidate.name for one in found.found]


def named_with_alike(found: DiagnosedStates) -> list[set[str]]:
    """Return each effect to add together with its alternatives, the largest first."""
    return [{one.candidate.name, *(other.name for other, _ in one.alternatives)} for one in found.found]
