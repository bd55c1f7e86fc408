"""How a kind of experiment takes the logs of its runs, one after the other, while a campaign is read."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.ingested_runs import IngestedRun
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.store.provenance import IngestSettings

if TYPE_CHECKING:
    import pyarrow as pa


class RunsReduction(ABC):
    """The runs of one kind, collected while a campaign is read.

    Parameters
    ----------
    campaign : as it was read.
    """

    reads_first_lines = True
    """Whether the first lines of a log alone are of use, as ``check --quick`` reads them."""

    def __init__(self, campaign: Campaign) -> None:
        self.campaign = campaign
        self.entries: list[IngestedRun] = []
        """What `ingest` answers of each run."""
        self.warnings: list[str] = []
        """What the user ought to know, in words."""

    @abstractmethod
    def add(self, run: Run, logs: Mapping[str, Blocks]) -> RawStates | None:
        """Take the logs of a run; return its load states where other runs make some to fit with, else None.

        Parameters
        ----------
        run : the manifest's entry.
        logs : source to block averages in SI, at the joint's side.

        Raises
        ------
        InputError
            The logs cannot be brought together.
        """

    def finish(self) -> None:
        """Reduce what needs all runs at once; called when the last one was added.

        Raises
        ------
        InputError
            The runs do not fit together.
        """
        return

    @abstractmethod
    def tables(self, settings: IngestSettings) -> dict[str, pa.Table]:
        """Return the tables for the store, by name: those of the kind's `tables` that these runs fill.

        Parameters
        ----------
        settings : what besides the logs decides what is made of them; a table that keeps them has another key.
        """

    def check(self) -> tuple[list[str], list[str]]:
        """Return the faults that prevent using these runs, and remarks on them, a line each, before anything is fitted.

        Raises
        ------
        InputError
            A run cannot be understood.
        """
        return [], []
