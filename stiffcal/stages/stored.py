"""Documents as they lie in a store, each checked against its types before anything relies on them.

What this user's own runs have written is known by its hash and needs no check; what anybody may have written is checked
key by key. Of a document that grows entry by entry, an entry of the wrong shape is left out.
"""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING, Any

from stiffcal.documents import Document, Result
from stiffcal.store.document_shape import has_shape, result_from
from stiffcal.store.index import OWN, check_version
from stiffcal.store.origin import ENTRY_LISTS

if TYPE_CHECKING:
    from stiffcal.store import Snapshot, Store


FIT_ID = re.compile(r"[1-9][0-9]{0,8}")


def stored_document(store: Store, name: str) -> Document | None:
    """Return a document of the store, or None where there is none.

    Raises
    ------
    DamagedError : it is not what was written, or holds something else than its name states.
    NewerError : it was written by a newer stiffcal.
    """
    if name not in store.documents:
        return None
    with store.snapshot() as snapshot:
        return checked(snapshot, name)


def stored_result(store: Store, name: str, kind: type[Result]) -> Result | None:
    """Return the content of a document of the store, or None where there is none.

    Parameters
    ----------
    name : of the document. kind : of the result.

    Raises
    ------
    DamagedError : it is not what was written, or holds something else than its name states.
    NewerError : it was written by a newer stiffcal.
    """
    document = stored_document(store, name)
    return None if document is None else result_from(kind, document, store.display_name, name)


def checked(snapshot: Snapshot, name: str) -> Document:
    """Return a document of a snapshot; raises as `stored_document`."""
    document = snapshot.read_document(name)
    if name in ENTRY_LISTS:
        return _checked_entries(snapshot, name, document)
    if snapshot.origin_of(name) != OWN:
        kind, schema = _document_types().get(name, (None, ""))
        check_version(document.get("schema"), schema, snapshot.display_name, name)
        if kind is not None:
            result_from(kind, document, snapshot.display_name, name)
    return document


def _checked_entries(snapshot: Snapshot, name: str, document: Document) -> Document:
    key = ENTRY_LISTS[name]
    sound = [row for row in document.get(key, []) if row.get("origin", OWN) == OWN or _has_shape(name, row)]
    return {"schema": _SCHEMAS.get(name), "warnings": [], **document, key: sound}


def _has_shape(name: str, row: Document) -> bool:
    if not has_shape(_entry_type(name), row):
        return False
    return name != "history" or FIT_ID.fullmatch(row["id"]) is not None


_SCHEMAS = {"history": "stiffcal/history/1", "load_paths": "stiffcal/load-paths/1"}


@cache
def _document_types() -> dict[str, tuple[Any, str]]:
    """Return the type and the schema of each document by name; imported only where somebody else's are read."""
    from stiffcal.diagnosis.answers.results import DiagnoseResult
    from stiffcal.diagnosis.refits.refits import StoredRefits
    from stiffcal.ingest.results import IngestResult
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.results.validate_result import ValidateResult
    from stiffcal.stages.stored_types import StoredReport
    from stiffcal.store import Provenance

    return {
        "identify": (IdentifyResult, "stiffcal/identify/1"),
        "validate": (ValidateResult, "stiffcal/validate/1"),
        "diagnose": (DiagnoseResult, "stiffcal/diagnose/1"),
        "ingest": (IngestResult, "stiffcal/ingest/1"),
        "refits": (StoredRefits, "stiffcal/refits/1"),
        "row_refits": (StoredRefits, "stiffcal/refits/1"),
        "provenance": (Provenance, "stiffcal/provenance/1"),
        "report": (StoredReport, "stiffcal/report-made/1"),
    }


@cache
def _entry_type(name: str) -> Any:
    """Return the type of an entry of a list; that of the others is not imported."""
    if name == "history":
        from stiffcal.results.history_results import StoredFit

        return StoredFit
    if name == "load_paths":
        from stiffcal.compensation.predict_result import LoadPath

        return LoadPath
    from stiffcal.diagnosis.answers.results import EarlierDiagnosis

    return EarlierDiagnosis
