"""Every fit of a campaign, and the way back to an earlier model."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.model.model_file import MODEL_FILE
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.results.history_results import HistoryEntry, HistoryResult, StoredFit
from stiffcal.stages.history import can_be_restored, model_of, stored_fits
from stiffcal.stages.steps import IDENTIFY, RunContext, open_store, stored_document
from stiffcal.store.index import FOREIGN
from stiffcal.trust.output_kinds import MODEL
from stiffcal.trust.outputs import holds_something, not_ours, write_output


def read_history(folder: Path, context: RunContext | None = None) -> HistoryResult:
    """Return every fit, its model, its error in held-out poses and the noise floor.

    Returns
    -------
    HistoryResult
        Oldest fit first.

    Raises
    ------
    InputError : the folder holds no campaign.
    """
    context = context or RunContext()
    campaign = load_campaign(Path(folder), check_files=False)
    store = open_store(campaign.folder, context)
    fits = [_entry(fit) for fit in stored_fits(store)]
    present = model_of(campaign.model)
    identified = stored_document(store, IDENTIFY) or {}
    last = next((fit for fit in fits if fit.id == identified.get("fit_id")), fits[-1] if fits else None)
    if last is None or present.same_as(last.model):
        return HistoryResult(warnings=[], fits=fits)
    return HistoryResult(warnings=["the model in model.toml is not fitted yet"], fits=fits, not_fitted_yet=present)


def _entry(fit: StoredFit) -> HistoryEntry:
    return HistoryEntry(
        id=fit.id,
        time=fit.time,
        model=fit.model,
        heldout_rms=fit.heldout_rms,
        scheme=fit.scheme,
        fit_rms=fit.fit_rms,
        noise=fit.noise,
        loss=fit.loss,
        likely=fit.likely,
        origin=fit.origin or "own",
    )


def restore_model(
    folder: Path, context: RunContext, fit_id: str, confirm: Callable[[StoredFit], bool] | None = None
) -> str:
    """Write the model of an earlier fit back to model.toml, with the comments it had.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    fit_id : the fit's id in the history.
    confirm : called with the entry of a fit that another user made, before its model is written; its ``model_text`` is
        to be shown. Returns whether to write it; None: a model of another user is not written.

    Returns
    -------
    str
        One sentence that names the fit.

    Raises
    ------
    InputError : there is no such fit; another user made it and `confirm` returns False; its model is no model file;
        model.toml holds a model that is in no fit of the history, which would be lost.
    """
    campaign = load_campaign(Path(folder), check_files=False)
    fits = {fit.id: fit for fit in reversed(stored_fits(open_store(campaign.folder, context)))}
    if fit_id not in fits:
        fit_ids = ", ".join(reversed(fits)) or "none"
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--restore",
            f"there is no fit {fit_id}",
            f"known: {fit_ids}",
        )
    fit = fits[fit_id]
    if fit.origin == FOREIGN:
        _check_foreign(campaign, fit, confirm)
    path = campaign.folder / MODEL_FILE
    if not context.overwrite and holds_something(path) and not can_be_restored(path, fits.values()):
        raise not_ours(path)
    if fit.model_text:
        write_output(path, fit.model_text, MODEL, overwrite=True)
    else:
        path.unlink(missing_ok=True)
    return f"model.toml is restored from fit {fit_id}"


def _check_foreign(campaign: Campaign, fit: StoredFit, confirm: Callable[[StoredFit], bool] | None) -> None:
    """Check the model of a fit that another user made: the user wants it, and it is a valid model file.

    Raises
    ------
    InputError : it is no model file, or the user does not want it.
    """
    import tempfile

    from stiffcal.campaign.model.model_file import load_model

    place = f"fit {fit.id}"
    if confirm is None or not confirm(fit):
        reason = "this fit was not computed by you, and its model was not confirmed"
        raise InputError.at(
            FaultCode.CONTENT_UNTRUSTED,
            "history",
            place,
            reason,
            "read the model shown above, and add --yes to restore it",
        )
    if fit.model_text:
        with tempfile.TemporaryDirectory(prefix="stiffcal-model-") as folder:
            (Path(folder) / MODEL_FILE).write_text(fit.model_text, encoding="utf-8")
            load_model(Path(folder), campaign.chain.n_joints)
