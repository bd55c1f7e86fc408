"""`stiffcal ingest`: raw logs to the Parquet store."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.answers import answering
from stiffcal.cli.clocks import clock_rates
from stiffcal.cli.endings import OK
from stiffcal.cli.next_step import following
from stiffcal.cli.options import HERE, AsJson, Folder, StoreAt
from stiffcal.cli.registration import show_registration
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import length, significant
from stiffcal.quantity import DELAY
from stiffcal.results.next_step import Step
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.ingest.results import IngestResult
    from stiffcal.reduction.states.ingested_runs import IngestedRun


def ingest(folder: Folder = HERE, as_json: AsJson = False, store: StoreAt = None) -> int:
    """Turn raw logs into load states in the Parquet store.

    Clocks are aligned, dwells found, references taken. If nothing has changed since the last ingest, the store is kept
    and this is reported.

    Example: stiffcal ingest demo
    """
    with answering(as_json) as answer:
        from stiffcal.commands.ingest import ingest_campaign

        result = ingest_campaign(folder, store=store, progress=answer.progress)
        answer.give(result, show_ingest, following(folder, store, Step.CHECK))
    return OK


def show_ingest(console: Console, result: IngestResult) -> None:
    """Draw states and clocks of each run."""
    show_registration(console, result.registration)
    if result.unchanged:
        console.print("nothing has changed since the last ingest: the store is current")
    table = plain_table("run", "states>", "set aside", "clock offsets relative to the first source")
    for run in result.runs:
        swept = f" in {run.passes} passes" if run.passes else ""
        count_text = f"{run.n_readings} readings" if run.n_readings else run.n_states
        table.add_row(run.id, f"{count_text}{swept}", _dropped(run), _clocks(run))
    console.print(table)
    for line in clock_rates(run.clock_ahead_s for run in result.runs):
        console.print(line, soft_wrap=True)
    if result.rods_grew_m:
        most = length(result.rods_grew_m)
        console.print(f"removed from the rod readings: thermal expansion, up to {most} within a run")


def _dropped(run: IngestedRun) -> str:
    """Return each cause once, with how often it came; a single state with its figures."""
    from stiffcal.measurements.set_aside import SetAsideCode

    causes = [f"{unused.pieces} × {unused.why}" for unused in run.dropped if unused.pieces is not None]
    states: dict[str, list[str]] = {}
    for unused in run.dropped:
        if unused.pieces is None:
            states.setdefault(unused.code, []).append(unused.why)
    for code, reasons in states.items():
        causes.append(f"{len(reasons)} × {reasons[0] if len(reasons) == 1 else SetAsideCode(code).short_text}")
    return "; ".join(causes)


def _clocks(run: IngestedRun) -> str:
    texts = []
    for source, offset in run.clock_ahead_s.items():
        if offset.value is not None:
            unit = DELAY.usual
            spread = f" ± {significant(unit.factor * NORMAL_95 * offset.std, 2)}" if offset.std else ""
            texts.append(f"{source} {significant(unit.factor * offset.value, 4)}{spread}{unit.mark}")
        else:
            texts.append(f"{source} not known" + (f" ({offset.reason})" if offset.reason else ""))
    return ", ".join(texts)
