"""How large an effect would have to be to be found, where `diagnose` finds none, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.wording import DASH, length, significant

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult, ExcludedSizeAt

MOST_PLACES = 4
"""Places that are listed without details."""


def places_without_effect(result: DiagnoseResult) -> list[ExcludedSizeAt]:
    """Return the places of what could not be excluded, the largest size first; none where something is found."""
    if result.missing or result.unexplained:
        return []
    return sorted(result.excluded_sizes or (), key=lambda one: (-(one.size_m or 0.0), -(one.size_Nm or 0.0)))


def excluded_in_words(result: DiagnoseResult, details: bool = False) -> list[str]:
    """Return how large an effect at each place would have been found, and where none would show.

    Parameters
    ----------
    details : whether all places are listed.
    """
    sizes = places_without_effect(result)
    hidden = [one.of for one in sizes if one.size_m is None and one.size_Nm is None]
    known = [one for one in sizes if one.of not in hidden]
    texts = []
    if known:
        measure = "torque, rms" if any(one.size_Nm for one in known) else "rms at the tool"
        shown = known if details else known[:MOST_PLACES]
        listed = "; ".join(f"{one.of}: {size_words(one.size_m, one.size_Nm)} ({one.effect})" for one in shown)
        rest = len(known) - len(shown)
        less = f"; less at {rest} further places (diagnose --details)" if rest else ""
        texts.append(f"an effect this large would have been found in nine campaigns of ten ({measure}): {listed}{less}")
    if hidden:
        more = "; load along other axes, in other poses" if result.rms.torque is None else ""
        texts.append(f"an effect would not show in these data, however large: {', '.join(hidden)}{more}")
    return texts


def size_words(at_tool: float | None, torque: float | None) -> str:
    """Return the rms of an effect at the tool, m, or in a drive's torque, N·m, in words."""
    if torque:
        return f"{significant(torque)} N·m"
    return length(at_tool) if at_tool else DASH
