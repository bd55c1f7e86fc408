"""Where a state of a table stands: its file, its run, its row and its line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.escapes import toml_text
from stiffcal.measurements.load_states import LoadStates
from stiffcal.reduction.logs.log_rows import raw_rows_of

# Stretches of rows that one line lists; the others are counted.
MOST_LISTED = 6
# More places than these are no line to copy.
MOST_EXCLUDED = 40


@dataclass(frozen=True)
class TableRows:
    """The states of a campaign and the tables that they come from."""

    campaign: Campaign
    states: LoadStates

    def file(self, state: int = 0, *, of_angles: bool = False) -> str:
        """Return the file of a state's positions, or of its joint angles; the manifest where it comes from no table."""
        source = self._source(of_angles)
        if source is None:
            return MANIFEST_FILE
        run = next((run for run in self.campaign.manifest.runs if run.id == self._run(state)), None)
        files = self.campaign.manifest.files_of(source, run)
        return (
            files.get("") or files.get("joints" if of_angles else "pose") or next(iter(files.values()), MANIFEST_FILE)
        )

    def place(self, chosen: Integers, *, of_angles: bool = False) -> str:
        """Return the place of the first of some states, and whether there are others."""
        state, row = int(chosen[0]), int(self.states.row[chosen[0]])
        place, run = f"row {row}", self._run(state)
        place = place if run == str(row) else f"run {run}, {place}"
        source, file = self._source(of_angles), self.file(state, of_angles=of_angles)
        if source is not None and (self.campaign.folder / file).is_file():
            found = raw_rows_of(self.campaign.folder, self.campaign.manifest.sources[source], file, (row,))
            if row in found.lines:  # of formats that are no text a row has no line
                place += f" (line {found.lines[row][0]})"
        return place + (" and others" if len(chosen) > 1 else "")

    def numbers(self, chosen: Integers) -> tuple[int, ...]:
        """Return the rows of some states as they are counted in the table."""
        return tuple(self.states.row[chosen].tolist())

    def listed(self, chosen: Integers) -> str:
        """Return the rows of some states as they are counted in the table, those one after the other as from … to."""
        pieces = [str(first) if first == last else f"{first} to {last}" for first, last in self._stretches(chosen)]
        more = len(pieces) - MOST_LISTED
        return ", ".join(pieces[:MOST_LISTED]) + (f" and {more} more places" if more > 0 else "")

    def exclusion(self, chosen: Integers) -> str:
        """Return ``[[exclude]]`` with some states' rows as the manifest writes them, where they are of one run."""
        pieces = [first if first == last else f"{first}-{last}" for first, last in self._stretches(chosen)]
        if len({self._run(int(state)) for state in chosen}) > 1 or len(pieces) > MOST_EXCLUDED:
            return "[[exclude]]"
        return f"[[exclude]] with {toml_text.pair('rows', pieces)}"

    def _stretches(self, chosen: Integers) -> list[tuple[int, int]]:
        """Return the first and the last row of each stretch of rows one after the other."""
        numbers = self.states.row[chosen]
        breaks = np.flatnonzero(np.diff(numbers) != 1) + 1
        return [(int(piece[0]), int(piece[-1])) for piece in np.split(numbers, breaks)]

    def _run(self, state: int) -> str:
        info = self.states.runs[int(self.states.run[state])]
        return info.of or info.name

    def _source(self, of_angles: bool) -> str | None:
        """Return the source of the rows' positions or joint angles, where it is a table of states."""
        for name, source in self.campaign.manifest.sources.items():
            if source.is_states and (source.joints is not None if of_angles else bool(source.body_poses())):
                return name
        return None
