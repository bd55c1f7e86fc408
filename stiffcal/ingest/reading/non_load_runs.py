"""What runs measured that make no load states, by kind of experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.campaign.loading import Campaign
from stiffcal.kinds import all_kinds
from stiffcal.kinds.reduction import RunsReduction
from stiffcal.reduction.states.ingested_runs import IngestedRun
from stiffcal.store.provenance import IngestSettings

if TYPE_CHECKING:
    import pyarrow as pa


class NonLoadRuns:
    """What runs measured that make no load states, collected while a campaign is read.

    Parameters
    ----------
    campaign : as it was read.
    """

    def __init__(self, campaign: Campaign) -> None:
        reductions = {kind.name: kind.reduction(campaign) for kind in all_kinds()}
        self._reductions = {name: reduction for name, reduction in reductions.items() if reduction is not None}

    def __bool__(self) -> bool:
        return bool(self.entries)

    def of_kind(self, experiment: str) -> RunsReduction | None:
        """Return the reduction of a kind of experiment; None where these make load states."""
        return self._reductions.get(experiment)

    @property
    def entries(self) -> list[IngestedRun]:
        """What `ingest` answers of each such run."""
        return [entry for reduction in self._reductions.values() for entry in reduction.entries]

    @property
    def warnings(self) -> list[str]:
        """What the user ought to know."""
        return [text for reduction in self._reductions.values() for text in reduction.warnings]

    def finish(self) -> None:
        """Reduce what needs all runs at once.

        Raises
        ------
        InputError : runs of one kind do not fit together.
        """
        for reduction in self._reductions.values():
            reduction.finish()

    def tables(self, settings: IngestSettings) -> dict[str, pa.Table]:
        """Return the tables of all kinds, by name; `settings` stand with them."""
        tables_by_name: dict[str, pa.Table] = {}
        for reduction in self._reductions.values():
            tables_by_name |= reduction.tables(settings)
        return tables_by_name

    def check(self) -> tuple[list[str], list[str]]:
        """Return the faults of these runs, and remarks on them, a line each.

        Raises
        ------
        InputError : a run cannot be understood.
        """
        unusable: list[str] = []
        remarks = list(self.warnings)
        for reduction in self._reductions.values():
            missing, noticed = reduction.check()
            unusable += missing
            remarks += noticed
        return unusable, remarks
