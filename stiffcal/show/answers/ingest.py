"""What `ingest` shows: states and clocks of each run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.quantity import DELAY
from stiffcal.show import parts
from stiffcal.show.builder import PageBuilder, number
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import length, significant

if TYPE_CHECKING:
    from stiffcal.ingest.results import IngestResult
    from stiffcal.presentation.values import Page
    from stiffcal.reduction.states.ingested_runs import IngestedRun
    from stiffcal.show.options import ShowOptions


def page(result: IngestResult, options: ShowOptions) -> Page:
    """Return states and clocks of each run."""
    made = PageBuilder("Read logs")
    made.add(parts.registration(result.registration))
    if result.unchanged:
        made.say("nothing has changed since the last ingest: the store is current", "ingest")
    rows = []
    for run in result.runs:
        swept = f" in {run.passes} passes" if run.passes else ""
        count_text = f"{run.n_readings} readings" if run.n_readings else run.n_states
        rows.append((run.id, f"{count_text}{swept}", _dropped(run), _clocks(run)))
    made.table(("run", number("states"), "set aside", "clock offsets relative to the first source"), rows)
    made.add(parts.clock_rates(run.clock_ahead_s for run in result.runs))
    if result.rods_grew_m:
        most = length(result.rods_grew_m)
        made.say(f"removed from the rod readings: thermal expansion, up to {most} within a run", "ingest")
    return made.page()


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
