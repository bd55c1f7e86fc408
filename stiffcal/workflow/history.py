"""Every fit of a campaign, and the way back to an earlier model."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.model_file import MODEL_FILE, ModelFile
from stiffcal.errors import InputError
from stiffcal.files import write_whole
from stiffcal.store.index import FOREIGN, OWN
from stiffcal.workflow.identify import NO_HISTORY
from stiffcal.workflow.steps import HISTORY, IDENTIFY, Document, RunContext, open_store, stored_document

PUBLIC = ("id", "time", "model", "heldout_rms", "fit_rms", "noise", "loss")


def read_history(folder: Path, context: RunContext | None = None) -> Document:
    """Return every fit, its model, its error in unseen poses and the noise floor.

    Returns
    -------
    dict
        The `history` document (interface, section 4). ``not_fitted_yet`` holds the present model where that is not the
        last one fitted.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    context = context or RunContext()
    campaign = load_campaign(Path(folder), check_files=False)
    store = open_store(campaign.folder, context)
    stored = stored_document(store, HISTORY) or NO_HISTORY
    fits = [
        {name: entry.get(name) for name in PUBLIC} | {"origin": entry.get("origin", OWN)} for entry in stored["fits"]
    ]
    document: Document = {"schema": NO_HISTORY["schema"], "warnings": [], "fits": fits}
    present = model_of(campaign.model)
    identified = stored_document(store, IDENTIFY) or {}
    last = next((fit for fit in fits if fit["id"] == identified.get("fit_id")), fits[-1] if fits else None)
    if last is not None and not same_model(present, last["model"]):
        document["warnings"].append("the model in model.toml is not fitted yet")
        document["not_fitted_yet"] = present
    return document


def restore_model(
    folder: Path, context: RunContext, identifier: str, agree: Callable[[Document], bool] | None = None
) -> str:
    """Write the model of an earlier fit back to model.toml, with the comments it had; return what was done, in words.

    Parameters
    ----------
    identifier : of the fit.
    agree : asked before a model is written that somebody else has made, with the entry, whose ``model_text`` is to be
        shown; None: such a model is not written.

    Raises
    ------
    InputError : there is no such fit; it is somebody else's and `agree` does not agree; its model is no model file.
    """
    campaign = load_campaign(Path(folder), check_files=False)
    stored = stored_document(open_store(campaign.folder, context), HISTORY) or NO_HISTORY
    for entry in stored["fits"]:
        if entry["id"] == identifier:
            break
    else:
        known = ", ".join(entry["id"] for entry in stored["fits"]) or "none"
        raise InputError.at("command line", "--restore", f"no fit has the id {identifier}", f"known: {known}")
    if entry.get("origin", OWN) == FOREIGN:
        _check_foreign(campaign, entry, agree)
    path = campaign.folder / MODEL_FILE
    if entry["model_text"]:
        write_whole(path, entry["model_text"])
    else:
        path.unlink(missing_ok=True)
    return f"model.toml is that of fit {identifier} again"


def _check_foreign(campaign: Campaign, entry: Document, agree: Callable[[Document], bool] | None) -> None:
    """Look at somebody else's model before it becomes this campaign's: that it is one, and that the user wants it.

    Raises
    ------
    InputError : it is no model file, or the user does not want it.
    """
    import tempfile

    from stiffcal.campaign.model_file import load_model

    place = f"fit {entry['id']}"
    if agree is None or not agree(entry):
        reason = "this fit was not made by you, and its model has not been looked at"
        raise InputError.at("history", place, reason, "look at the model that is shown, and say --yes to restore it")
    if entry["model_text"]:
        with tempfile.TemporaryDirectory(prefix="stiffcal-model-") as folder:
            (Path(folder) / MODEL_FILE).write_text(entry["model_text"], encoding="utf-8")
            load_model(Path(folder), campaign.chain.n_joints)


def model_of(model: ModelFile) -> Document:
    """Return the model file as the history writes models: balance and effects with places."""
    effects: dict[str, Document] = {}
    for entry in model.effects:
        one = effects.setdefault(entry.type, {"type": entry.type})
        for kind, places in (("joints", entry.joints), ("links", entry.links), ("pairs", entry.pairs)):
            if places:
                items = [list(place) if isinstance(place, tuple) else place for place in places]
                one.setdefault(kind, []).extend(items)
    return {"balance": model.balance, "effects": list(effects.values())}


def same_model(one: Document, other: Document) -> bool:
    """Tell whether two models hold the same effects at the same places, in whatever order."""
    return _sorted(one) == _sorted(other)


def _sorted(model: Document) -> object:
    effects = [
        (effect["type"], [(kind, sorted(map(str, effect.get(kind, [])))) for kind in ("joints", "links", "pairs")])
        for effect in model["effects"]
    ]
    return model["balance"], sorted(effects)
