"""The keys under which the readings of runs lie in the store: hashes of all that they depend on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from stiffcal.campaign.frames.gauges import metres_of_rods
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Exclusion, Run
from stiffcal.revision import REVISION

if TYPE_CHECKING:
    from stiffcal.store import SourceFile

HashOf = Callable[[str], str]
"""From a file, relative to the campaign folder, to the SHA-256 of its content."""
_OF_LATER_STEPS = {
    "approach",
    "compensation",
    "files",
    "fixture_compliance",
    "holdout",
    "joints_deg",
    "moved_joint",
    "reference",
    "tags",
}
"""Keys of ``[[runs]]`` that count once a run was read; its files enter with their content."""


class RunKeys:
    """Makes the keys of a campaign's runs.

    Parameters
    ----------
    campaign : as it was read.
    elsewhere : what its sources name that is no file, as it is now.
    """

    def __init__(self, campaign: Campaign, elsewhere: Sequence[SourceFile] = ()) -> None:
        self._campaign = campaign
        self._elsewhere = {source.file: source.sha256 for source in elsewhere}
        self._settings: dict[str, str] = {}
        self._excluded: dict[tuple[str, str | None], list[Exclusion]] = {}
        for exclusion in campaign.manifest.exclude:
            self._excluded.setdefault((exclusion.source, exclusion.run), []).append(exclusion)

    def in_file(self, source: str) -> bool:
        """Return whether a source's logs are files."""
        return self._campaign.manifest.sources[source].in_files

    def files(self, run: Run, sources: Sequence[str]) -> list[str]:
        """Return the files that are read of a run."""
        manifest = self._campaign.manifest
        named = [file for source in sources if self.in_file(source) for file in manifest.files_of(source, run).values()]
        return named + ([run.states] if run.states is not None else [])

    def of_run(self, run: Run, sources: Sequence[str], hash_of: HashOf) -> str:
        """Return the key of what reading a run gives.

        Parameters
        ----------
        run : the manifest's entry. sources : those that log it, in the order in which they are read.
        hash_of : of a file's content.
        """
        manifest = self._campaign.manifest
        read = [
            (
                source,
                self._settings_of(source),
                [(signal, file, self._hash(source, file, hash_of)) for signal, file in files.items()],
                self._rows_left_out(source, run),
            )
            for source in sources
            for files in (manifest.files_of(source, run),)
        ]
        states = None if run.states is None else (run.states, hash_of(run.states))
        return _hash_of(run.model_dump(mode="json", exclude=_OF_LATER_STEPS), read, states)

    def of_names(self, source: str, file: str, hash_of: HashOf) -> str:
        """Return the key of the names of runs that a log holds."""
        return _hash_of(source, self._settings_of(source), file, self._hash(source, file, hash_of))

    def _hash(self, source: str, file: str, hash_of: HashOf) -> str:
        if self.in_file(source):
            return hash_of(file)
        return self._elsewhere.get(name_elsewhere(source, file), "")  # one that cannot be reached is no known one

    def _settings_of(self, source: str) -> str:
        """Return a hash of all that decides what a source's log gives; a pattern of files is not among it."""
        if source not in self._settings:
            settings = self._campaign.manifest.sources[source]
            ratio = self._campaign.chain.gear_ratio.tolist() if settings.joints and settings.joints.motor else None
            metres = None if settings.lengths is None else metres_of_rods(self._campaign.manifest)
            document = settings.model_dump(mode="json", exclude={"file"})
            self._settings[source] = _hash_of(document, ratio, metres, self._rows((source, None)))
        return self._settings[source]

    def _rows_left_out(self, source: str, run: Run) -> list[object]:
        """Return the rows that are left out of a run's log; where one log holds several runs, of any of these."""
        if source in run.files:
            return self._rows((source, run.id))
        return [own for key in self._excluded if key[0] == source and key[1] is not None for own in self._rows(key)]

    def _rows(self, key: tuple[str, str | None]) -> list[object]:
        return [[exclusion.run, list(exclusion.rows)] for exclusion in self._excluded.get(key, ())]


def name_elsewhere(source: str, text: str) -> str:
    """Return how a source's table or query that is no file is called.

    Examples
    --------
    >>> name_elsewhere("ft", "select *  from ft")
    'ft: select * from ft'
    """
    return f"{source}: {' '.join(text.split())}"


def _hash_of(*parts: object) -> str:
    return hashlib.sha256(json.dumps([REVISION, *parts], sort_keys=True).encode()).hexdigest()
