"""The history of fits as the store keeps it, and the models in it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffcal.campaign.model.model_file import MODEL_FILE, ModelFile
from stiffcal.documents import Document, document_of
from stiffcal.files import read_regular
from stiffcal.limits import TOML
from stiffcal.model.summary import EffectAt, EffectInModel, ModelSummary
from stiffcal.results.history_results import StoredFit
from stiffcal.stages.steps import HISTORY, stored_document
from stiffcal.store.document_shape import result_from
from stiffcal.store.index import FOREIGN
from stiffcal.trust.output_kinds import MODEL
from stiffcal.trust.outputs import was_written

if TYPE_CHECKING:
    from stiffcal.stages.steps import Ingested
    from stiffcal.store import Store
    from stiffcal.store.store_place import Documents, Stored


NO_HISTORY: Document = {"schema": "stiffcal/history/1", "warnings": [], "fits": []}


def stored_fits(store: Store) -> list[StoredFit]:
    """Return every fit of the history as the store keeps it, oldest first."""
    stored = stored_document(store, HISTORY) or NO_HISTORY
    return [result_from(StoredFit, fit, store.display_name, HISTORY) for fit in stored["fits"]]


def mark_likely(data: Ingested, fit_id: str, effect: EffectAt) -> None:
    """Write into a fit's entry of the history that an effect was added which was probable and not certain."""

    def with_mark(stored: Stored) -> Documents:
        history = stored(HISTORY)
        if history is None:
            return {}
        mark = {"likely": [document_of(effect)]}
        entries = [entry | (mark if entry.get("id") == fit_id else {}) for entry in history["fits"]]
        return {HISTORY: history | {"fits": entries}}

    data.commit({}, with_mark, command="improve")


def can_be_restored(model: Path, fits: Iterable[StoredFit]) -> bool:
    """Return whether nothing of the user's is lost with a model file: stiffcal wrote it, or a fit of theirs keeps it.

    Parameters
    ----------
    model : the model file; True where there is none.
    fits : of the campaign's history.
    """
    if not model.exists() or was_written(model, MODEL):
        return True
    text = read_regular(model, MODEL_FILE, limit=TOML).decode("utf-8", "replace")
    return any(fit.model_text == text for fit in fits if fit.origin != FOREIGN)


def model_of(model: ModelFile) -> ModelSummary:
    """Return the model file as results name models: balance and effects with places."""
    effects: dict[str, dict[str, list[Any]]] = {}
    for entry in model.effects:
        effect = effects.setdefault(entry.type, {})
        for kind, places in (("joints", entry.joints), ("links", entry.links), ("pairs", entry.pairs)):
            if places:
                items = [list(place) if isinstance(place, tuple) else place for place in places]
                effect.setdefault(kind, []).extend(items)
    return ModelSummary(model.balance, [EffectInModel(name, **places) for name, places in effects.items()])
