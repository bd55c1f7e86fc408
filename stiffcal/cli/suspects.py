"""Runs that disagree with all the others, as lines of a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.cli.wording import places
from stiffcal.wording import probability_in_words

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect


def show_suspects(
    console: Console, suspects: Sequence[Suspect] | None, not_checked: RunsNotChecked | None = None
) -> None:
    """Draw each suspect: why, the likely cause and cure, and the lines to copy; and what was not checked."""
    for suspect in suspects or ():
        row = "" if suspect.row is None else f", row {suspect.row}"
        p = suspect.probability
        sure = "" if p is None else f" ({probability_in_words(p)})"
        text = f"suspect: run {suspect.run}{row}{sure}: {suspect.kind}: {suspect.why}"
        console.print(text, soft_wrap=True, markup=False)
        console.print(f"  likely: {suspect.likely}", soft_wrap=True, markup=False)
        if suspect.explained_by:
            effects = " and ".join(f"{effect.effect} ({places(effect.where)})" for effect in suspect.explained_by)
            console.print(f"  equally well explained by an effect: {effects}", soft_wrap=True, markup=False)
    if suspects:
        console.print("suspects are included in the fit; to exclude them, copy these lines into campaign.toml:")
        for suspect in suspects:
            for line in suspect.exclude:
                console.print(f"  {line}", soft_wrap=True, markup=False, highlight=False)
    if not_checked is not None:
        console.print(not_checked.sentence, soft_wrap=True, markup=False, highlight=False)
