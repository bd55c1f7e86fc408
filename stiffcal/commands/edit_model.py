"""Add effects to model.toml and take them out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.editing import Wanted, edit_text, places_at
from stiffcal.model.summary import Where
from stiffcal.results.command_results import EditResult
from stiffcal.stages.history import can_be_restored, model_of, stored_fits
from stiffcal.stages.steps import RunContext, open_store
from stiffcal.trust.output_kinds import MODEL
from stiffcal.trust.outputs import note_written


def edit_model(
    folder: Path,
    action: Literal["add", "remove"],
    effect: str,
    *,
    where: Mapping[str, str | None] | None = None,
    everywhere: bool = False,
    curved: bool = False,
    start: Mapping[str, float] | None = None,
    context: RunContext | None = None,
) -> EditResult:
    """Add an effect to model.toml, or remove it; the user's comments stay.

    Parameters
    ----------
    folder : the campaign folder.
    action : "add" or "remove".
    effect : its name.
    where : ``joints``, ``links`` and ``pairs`` as words: "2,3", "swing,arm", "5-6".
    everywhere : at every place the effect can have (or, removing, has).
    curved : in the law's curved form, also where the model holds the straight one.
    start : values by symbol from which the fit starts; of a law with several forms the one with these symbols is added.
    context : where the store is, whose history may keep the model as it was.

    Returns
    -------
    EditResult
        What changed, and what the model holds now.

    Raises
    ------
    InputError : no such effect or place; or no place given, with the places that there are.
    """
    campaign = load_campaign(Path(folder), check_files=False)
    places = places_of_words(campaign, where or {})
    return change_model(
        campaign, action, effect, where=places, everywhere=everywhere, curved=curved, start=start, context=context
    )


def change_model(
    campaign: Campaign,
    action: Literal["add", "remove"],
    effect: str,
    *,
    where: Where,
    everywhere: bool = False,
    curved: bool = False,
    start: Mapping[str, float] | None = None,
    context: RunContext | None = None,
) -> EditResult:
    """Do the same where the places are at hand as values.

    Raises
    ------
    InputError : as `edit_model`.
    """
    from stiffcal.campaign.model.model_editing import editable_text, save_model

    kept = _is_kept(campaign, context or RunContext())
    text = editable_text(campaign.folder, campaign.chain.n_joints)
    wanted = Wanted(where, everywhere, curved, start or {})
    edited, changes = edit_text(campaign, text, action, effect, wanted)
    if edited != text:
        save_model(campaign.folder, edited)
    if kept:
        note_written(campaign.folder / MODEL_FILE, MODEL)
    model = load_campaign(campaign.folder, check_files=False).model
    return EditResult(warnings=[], changes=changes, model=model_of(model))


def places_of_words(campaign: Campaign, where: Mapping[str, str | None]) -> Where:
    """Return the places that the command line has as words, joints by number or by name: "2,A3", "swing,arm", "5-6".

    Raises
    ------
    InputError : the robot has no such joint, or what should be a pair is none.
    """
    words = {kind: [word.strip() for word in (text or "").split(",") if word.strip()] for kind, text in where.items()}
    pairs = [[end.strip() for end in word.split("-")] for word in words.get("pairs", [])]
    return places_at(campaign, words.get("joints", []), words.get("links", []), pairs)


def _is_kept(campaign: Campaign, context: RunContext) -> bool:
    """Return whether the model file can be written again as it is now; where the history cannot be read, it cannot."""
    try:
        fits = stored_fits(open_store(campaign.folder, context))
    except InputError:
        fits = []
    return can_be_restored(campaign.folder / MODEL_FILE, fits)


def start_values(text: str | None) -> dict[str, float]:
    """Return start values by symbol, from ``p1=3.6e5,p2=-1.8e7``.

    Raises
    ------
    InputError : not written so, or no number.

    Examples
    --------
    >>> start_values("c=1e-6, width=2e-3")
    {'c': 1e-06, 'width': 0.002}
    """
    values: dict[str, float] = {}
    for word in (text or "").split(","):
        symbol, equals, number = (piece.strip() for piece in word.partition("="))
        if not word.strip():
            continue
        try:
            values[symbol] = float(number)
        except ValueError:
            values[symbol] = math.nan
        if not equals or not symbol or not math.isfinite(values[symbol]):
            mend = "write SYMBOL=VALUE, several with commas between them: p1=3.6e5,p2=-1.8e7"
            reason = f"{word.strip()} is not a start value"
            raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--start", reason, mend)
    return values
