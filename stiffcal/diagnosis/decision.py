"""Which of the effects that the evidence supports are named, and which stay undecided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stiffcal.diagnosis.deletions import Rival
from stiffcal.diagnosis.search_results import MissingEffect


@dataclass(frozen=True)
class Decision:
    """Which of the supported effects are named, and which stay undecided."""

    named: tuple[MissingEffect, ...]
    """Empty where the first is undecided."""
    undecided: tuple[Rival, ...]
    """Between which candidates the first effect is undecided."""
    undecided_next: tuple[Rival, ...]
    """The same for a lesser effect, where the first is named."""


def decide(supported: Sequence[MissingEffect]) -> Decision:
    """Return what is named of effects that the evidence supports.

    A lesser effect that is undecided leaves the others named: it is looked at again when they are in the model. A
    single pose may decide on any of them; only the first must not be one of too many look-alikes.

    Parameters
    ----------
    supported : what matters most first.
    """
    open_effects = [
        missing_effect
        for number, missing_effect in enumerate(supported)
        if missing_effect.rivals and (number == 0 or any(rival.deciding for rival in missing_effect.rivals))
    ]
    if open_effects and open_effects[0] is supported[0]:
        return Decision((), open_effects[0].rivals, ())
    named = tuple(effect for effect in supported if effect not in open_effects)
    return Decision(named, (), open_effects[0].rivals if open_effects else ())
