"""`stiffcal ingest`: raw logs to the Parquet store."""

from __future__ import annotations

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, StoreAt
from stiffcal.commands.next_step import following
from stiffcal.results.next_step import Step


def ingest(folder: Folder = HERE, as_json: AsJson = False, store: StoreAt = None) -> int:
    """Turn raw logs into load states in the Parquet store.

    Clocks are aligned, dwells found, references taken. If nothing has changed since the last ingest, the store is kept
    and this is reported.

    Example: stiffcal ingest demo
    """
    with answering(as_json) as answer:
        from stiffcal.commands.ingest import ingest_campaign

        result = ingest_campaign(folder, store=store, progress=answer.progress)
        answer.show(result, following(folder, store, Step.CHECK))
    return OK
