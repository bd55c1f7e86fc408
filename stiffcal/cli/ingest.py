"""`stiffcal ingest`: raw logs to the Parquet store."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.answers import Document, answering, command_line
from stiffcal.cli.clocks import clock_rates
from stiffcal.cli.endings import OK
from stiffcal.cli.options import HERE, AsJson, Folder, StoreAt
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import length, significant

if TYPE_CHECKING:
    from rich.console import Console


def ingest(folder: Folder = HERE, as_json: AsJson = False, store: StoreAt = None) -> int:
    """Turn raw logs into load states in the Parquet store.

    Clocks are aligned, holds found, references taken. With nothing changed since the last time it does
    nothing and says so.

    Example: stiffcal ingest demo
    """
    with answering(as_json) as answer:
        from stiffcal.workflow.ingest import ingest_campaign

        document = ingest_campaign(folder, store=store, progress=answer.progress)
        answer.give(document, show_ingest, command_line("identify", folder, store=store))
    return OK


def show_ingest(console: Console, document: Document) -> None:
    """Draw the ingest document: states and clocks of each run."""
    if document.get("unchanged"):
        console.print("nothing has changed since the last time: the store stays as it is")
    table = plain_table("run", "states>", "dropped", "clocks ahead of the first source's")
    for run in document["runs"]:
        dropped = run["dropped"]
        swept = f" in {run['passes']} passes" if run.get("passes") else ""
        taken = f"{run['n_readings']} readings" if run.get("n_readings") else run["n_states"]
        name, states = str(run.get("id", run.get("run", ""))), f"{taken}{swept}"
        table.add_row(name, states, _dropped(dropped), _clocks(run))
    console.print(table)
    from stiffcal.reduction.clocks import SourceClockOffset

    offsets = [
        {source: SourceClockOffset(**clock) for source, clock in (run.get("clock_ahead_s") or {}).items()}
        for run in document["runs"]
    ]
    for line in clock_rates(offsets):
        console.print(line, soft_wrap=True)
    if document.get("rods_grew_m"):
        most = length(document["rods_grew_m"])
        console.print(f"taken out of the rods' readings: growth with the temperature, up to {most} within a run")


def _dropped(dropped: list[Document]) -> str:
    """Return each reason once, with how often it came."""
    count: dict[str, int] = {}
    for item in dropped:
        count[item["why"]] = count.get(item["why"], 0) + int(item.get("pieces", 1))
    return "; ".join(f"{n} × {why}" for why, n in count.items())


def _clocks(run: Document) -> str:
    words = []
    for source, offset in (run.get("clock_ahead_s") or {}).items():
        if isinstance(offset, dict) and offset.get("value") is not None:
            std = offset.get("std")
            spread = f" ± {significant(1.96e3 * std, 2)}" if std else ""
            words.append(f"{source} {significant(1e3 * offset['value'], 4)}{spread} ms")
        else:
            reason = offset.get("reason", "") if isinstance(offset, dict) else ""
            words.append(f"{source} not known" + (f" ({reason})" if reason else ""))
    return ", ".join(words)
