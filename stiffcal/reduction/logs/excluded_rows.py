"""The rows of a source that the manifest leaves out: known before their readings are judged."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.manifest.manifest import Manifest


@dataclass(frozen=True)
class RowExclusions:
    """The rows of a source's file that ``[[exclude]]`` leaves out."""

    entries: tuple[tuple[Integers, str | None], ...] = ()
    """Data rows from 1, and the run that is meant; None: every run."""
    run: str | None = None
    """The run whose file is read; None where a column names the runs."""

    @classmethod
    def of(cls, manifest: Manifest, source: str, run: str | None = None) -> RowExclusions:
        """Return what the manifest leaves out of a source.

        Parameters
        ----------
        manifest : of the campaign.
        source : the source's name.
        run : the run whose own file is read; None where one file serves all runs.
        """
        entries = tuple(
            (np.array(exclusion.rows, dtype=np.int64), exclusion.run)
            for exclusion in manifest.exclude
            if exclusion.source == source
        )
        return cls(entries, run)

    def mask(self, number: Integers, run_names: list[str]) -> Booleans:
        """Return (n,) True for the rows that are left out.

        Parameters
        ----------
        number : (n,) data rows, from 1.
        run_names : the n names of the run column, or empty.
        """
        excluded = np.zeros(number.shape, dtype=np.bool_)
        for rows, run in self.entries:
            chosen = np.isin(number, rows)
            if run is not None and run_names:
                chosen &= np.array([name == run for name in run_names], dtype=np.bool_)
            elif run not in (None, self.run):
                continue
            excluded |= chosen
        return excluded


@dataclass
class ExcludedStretches:
    """Collects, batch by batch, between which samples of a log rows are excluded."""

    last: float | None = None
    """s, the last sample so far that is not excluded; None before the first."""
    open: bool = False
    """Whether rows after it have been excluded."""
    stretches: list[tuple[float, float]] = field(default_factory=list)
    """The last sample before and the first after each stretch, s."""

    def update(self, time: Floats, excluded: Booleans) -> None:
        """Add a batch: the rows' times (n,), s, and which of them are excluded (n,)."""
        kept = np.flatnonzero(~excluded)
        if kept.size == 0:
            self.open |= excluded.size > 0
            return
        if self.last is not None and (self.open or kept[0] > 0):
            self.stretches.append((self.last, float(time[kept[0]])))
        wide = np.flatnonzero(np.diff(kept) > 1)
        self.stretches += zip(time[kept[wide]].tolist(), time[kept[wide + 1]].tolist(), strict=True)
        self.last, self.open = float(time[kept[-1]]), bool(kept[-1] < excluded.size - 1)

    def array(self) -> Floats:
        """Return (k, 2) s, the stretches."""
        return np.array(self.stretches, dtype=np.float64).reshape(-1, 2)
