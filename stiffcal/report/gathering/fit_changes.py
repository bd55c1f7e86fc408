"""What the report shows of each change of the model: the identified values before and after it."""

from __future__ import annotations

import itertools

from stiffcal.identification.answers.before_after import values_before_and_after
from stiffcal.report.content import FitChange
from stiffcal.results.history_results import StoredFit
from stiffcal.results.model_words import model_change
from stiffcal.stages.steps import HISTORY, Ingested, key_of_table, stored_document
from stiffcal.store.document_shape import result_from
from stiffcal.store.index import FOREIGN


def fit_changes(data: Ingested) -> tuple[FitChange, ...]:
    """Return the fits of the present load states that follow each other with another model, oldest first.

    Where there are several, what all of them together changed comes before them. Fits of other load states are left
    out: what differs then need not come from the model.

    Parameters
    ----------
    data : the campaign.
    """
    stored, states = stored_document(data.store, HISTORY) or {"fits": []}, key_of_table(data.table)
    fits = [result_from(StoredFit, fit, data.store.display_name, HISTORY) for fit in stored["fits"]]
    comparable = [fit for fit in fits if fit.states_key == states]
    pairs = itertools.pairwise(comparable)
    changes = [change for before, after in pairs if (change := _change(before, after)) is not None]
    whole = _change(comparable[0], comparable[-1]) if len(changes) > 1 else None
    return (*([] if whole is None else [whole]), *changes)


def _change(before: StoredFit, after: StoredFit) -> FitChange | None:
    """Return what changed from one fit to the next; None where the models are the same."""
    if before.model.same_as(after.model):
        return None
    text = model_change(before.model, after.model)
    if before.model.balance != after.model.balance:
        balance = f"balance {before.model.balance} → {after.model.balance}"
        text = f"{text}; {balance}" if text else balance
    return FitChange(
        before=before.id,
        after=after.id,
        change=text,
        values=tuple(values_before_and_after(before.parameters, after.parameters)),
        own=FOREIGN not in (before.origin, after.origin),
    )
