"""The rival models of a plan: those that the user names, or that the last diagnosis could not distinguish."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiffcal.campaign.loading import Campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.summary import Where

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult

# Of a diagnosis: the named effect and its foremost look-alikes.
MOST_RIVALS = 4
_JOINT = re.compile(r"[jJ]?(\d+)")
_PAIR = re.compile(r"[jJ]?(\d+)-[jJ]?(\d+)")


@dataclass(frozen=True)
class NamedRival:
    """An effect at a place that could be what the model lacks."""

    effect: str
    """Its name."""
    where: Where
    """Its place."""
    label: str
    """Effect and place as the user writes them: ``backlash j4``."""


def named_rival(text: str) -> NamedRival:
    """Return the effect and place that a user wrote: ``backlash j4``, ``link-beam swing``, ``axis-coupling j3-j5``."""
    words = text.split()
    if not words or len(words) > 2:
        mend = 'write an effect and its place, as "backlash j4" or "link-beam swing"'
        raise InputError.at(FaultCode.OPTION_INVALID, "--tell", text, "not an effect with a place", mend)
    where = Where()
    if len(words) == 2:
        if match := _PAIR.fullmatch(words[1]):
            where = Where(pairs=[[int(match[1]), int(match[2])]])
        elif match := _JOINT.fullmatch(words[1]):
            where = Where(joints=[int(match[1])])
        else:
            where = Where(links=[words[1]])
    return NamedRival(words[0], where, " ".join(words))


def rivals_of_diagnosis(diagnosis: DiagnoseResult, campaign: Campaign) -> list[NamedRival]:
    """Return the first missing effect and those that look like it.

    Raises
    ------
    InputError : the diagnosis names none that look alike.
    """
    for missing in diagnosis.missing:
        if missing.alternatives:
            found = [(missing.effect, missing.where), *((other.effect, other.where) for other in missing.alternatives)]
            return [_rival_at(effect, where) for effect, where in found[:MOST_RIVALS]]
    if len(diagnosis.undecided) > 1:
        return [_rival_at(rival.effect, rival.where) for rival in diagnosis.undecided[:MOST_RIVALS]]
    reason = "the diagnosis names no effects that look alike"
    mend = 'state two, as --tell "backlash j4" "two-slope j4"'
    raise InputError.at(FaultCode.DATA_MISSING, str(campaign.folder), "diagnose", reason, mend)


def _rival_at(effect: str, where: Where) -> NamedRival:
    label = effect
    for kind, places in where.items():
        words = ["-".join(map(str, place)) if kind == "pairs" else str(place) for place in places]
        prefix = "j" if kind == "joints" else ""
        label = f"{effect} {','.join(prefix + word for word in words)}"
    return NamedRival(effect, where, label)
