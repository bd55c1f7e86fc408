"""What reading the logs of each run gave, before anything of other runs counts, and its place in the store.

Reading a log and finding its load states takes nearly all the time of an ingest, and asks for nothing but the logs of
that run and a few settings. What came of it lies in the store with a key: a hash of these settings, of the content of
the logs and of the revision that computed it (`run_keys`). A run whose key is the present one is not read again; all
steps in which runs are compared with each other follow on top, whether a run was read now or earlier.

Only what a run of this user has written is believed: a campaign folder may come from anybody.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.errors import InputError
from stiffcal.ingest.parts import READ_LOGS, READ_NAMES, READ_RUNS, READ_SOURCES, READ_STATES
from stiffcal.ingest.quality.data_quality import DataQuality
from stiffcal.ingest.reading.read_run import ReadRun
from stiffcal.ingest.reading.recording_tables import recording_name
from stiffcal.ingest.reading.run_keys import HashOf, RunKeys
from stiffcal.ingest.reading.run_tables import RawStatesOfRuns, blocks_from_table, blocks_table, raw_states_table
from stiffcal.ingest.reading.run_texts import StoredText, stored_text, text_of
from stiffcal.ingest.reading.stored_sources import sources_from_table, sources_table
from stiffcal.ingest.sources import files_in_order_of_runs, sources_elsewhere
from stiffcal.measurements.columns import table_of
from stiffcal.reduction.states.raw_states import RawStates, no_states
from stiffcal.store.index import OWN, DamagedStoreError

if TYPE_CHECKING:
    from stiffcal.store import Snapshot, SourceFile, Store, Writing

_COLUMNS = ("run", "table", "key", "n_states", "text")
_Id = tuple[str, str]
"""A run's name, and of a table of states its source; "" of logs."""
CHECKPOINT_S = 120.0
"""Of reading, after which what was read so far is kept: an ingest of hours that is killed goes on from there. Keeping
ten thousand runs takes a few seconds."""


class ReadingPaused(Exception):  # noqa: N818 — no error
    """What was read so far is to be written before the next run is read."""


@dataclass(frozen=True)
class _StoredRun:
    """A run as it lies in the store."""

    key: str
    first: int
    """Of its load states, the first row of their table."""
    stop: int
    """The row after the last one; `first` where it gives none."""
    text: str
    """`text_of` its contents."""


@dataclass(frozen=True)
class StoredReadings:
    """What a store of the user's own holds of runs that were read; nothing where it holds none of it."""

    snapshot: Snapshot | None = None
    """Where it lies; held as long as runs are looked for."""
    sources: Mapping[str, SourceFile] = field(default_factory=dict)
    """The logs as they were when they were read, by file."""
    states: Mapping[str, str] = field(default_factory=dict)
    """What shows that one is still the same: `FileStatus.state` of each."""
    runs: Mapping[_Id, _StoredRun] = field(default_factory=dict)
    """By name and table."""
    raw_states: RawStatesOfRuns | None = None
    """Of all runs."""
    names: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """The names that run columns hold, by their key."""


NOTHING_STORED = StoredReadings()


def stored_readings(snapshot: Snapshot) -> StoredReadings:
    """Return what a generation of a store holds of runs that were read; nothing where it is not the user's own work."""
    parts = (READ_RUNS, READ_STATES, READ_SOURCES, READ_NAMES)
    if any(name not in (*snapshot.tables, *snapshot.documents) for name in parts) or snapshot.origin_of(*parts) != OWN:
        return NOTHING_STORED
    try:
        table, raw_states = snapshot.read_table(READ_RUNS), snapshot.read_table(READ_STATES)
        sources, states = sources_from_table(snapshot.read_table(READ_SOURCES))
        names = snapshot.read_document(READ_NAMES)
    except DamagedStoreError:
        return NOTHING_STORED
    if tuple(table.column_names) != _COLUMNS:  # of a version that was not released
        return NOTHING_STORED
    runs: dict[_Id, _StoredRun] = {}
    first = 0
    for name, source, key, count, text in zip(*(table.column(column).to_pylist() for column in _COLUMNS), strict=True):
        runs[name, source] = _StoredRun(key, first, first + count, text)
        first += count
    return StoredReadings(snapshot, sources, states, runs, RawStatesOfRuns(raw_states), names)


@contextmanager
def open_readings(store: Store) -> Iterator[StoredReadings]:
    """Hold what a store holds of runs that were read; nothing where there is no store, or it is damaged."""
    with ExitStack() as stack:
        found = NOTHING_STORED
        with suppress(DamagedStoreError):
            if store.exists:
                found = stored_readings(stack.enter_context(store.snapshot()))
        yield found


@contextmanager
def earlier_readings(campaign: Campaign, store: Store, only: str | None = None) -> Iterator[RunReadings]:
    """Hold the readings that a store holds of runs whose logs and settings are as they were; nothing is written.

    A store that cannot be used holds none: that is reported by the commands that need it.

    Parameters
    ----------
    campaign : as it was read. store : its store. only : this run alone is asked for; None: any.
    """
    from stiffcal.store import hash_sources

    with ExitStack() as stack:
        stored = NOTHING_STORED
        with suppress(InputError):
            stored = stack.enter_context(open_readings(store))
        elsewhere: Sequence[SourceFile] = ()
        if stored.runs:
            with suppress(InputError):
                elsewhere = sources_elsewhere(campaign)
        files = [file for file in files_in_order_of_runs(campaign, only) if file in stored.sources]
        hashes = stack.enter_context(hash_sources(campaign.folder, files, stored.sources, stored.states))
        yield RunReadings(campaign, stored, lambda file: hashes.of(file).sha256, elsewhere)


class RunReadings:
    """The readings of a campaign's runs: those that the store holds, and those that are made.

    Parameters
    ----------
    campaign : as it was read.
    stored : what the store holds.
    hash_of : the SHA-256 of a log, of those that the store knows at least.
    elsewhere : what the sources name that is no file, as it is now.
    seconds : after which reading is to pause.
    """

    def __init__(
        self,
        campaign: Campaign,
        stored: StoredReadings,
        hash_of: HashOf,
        elsewhere: Sequence[SourceFile] = (),
        seconds: float = math.inf,
    ) -> None:
        self._stored, self._hash_of = stored, hash_of
        self._pause_at = time.monotonic() + seconds
        self._keys = RunKeys(campaign, elsewhere)
        self._described = DataQuality(campaign).described
        self._made: dict[_Id, tuple[Run, Sequence[str], ReadRun]] = {}
        self._kept: dict[_Id, RawStates | None] = {}
        self._names: dict[str, tuple[str, str, Sequence[str]]] = {}

    def find_table(self, run: Run, source: str) -> ReadRun | None:
        """Return what reading a run's own table of states gave earlier, None where it has to be read (again)."""
        return self._find((run.id, source), run, [source], None)

    def find(self, run: Run, sources: Sequence[str], writing: Writing | None = None) -> ReadRun | None:
        """Return what reading a run's logs gave earlier, None where they have to be read (again).

        Parameters
        ----------
        run : the manifest's entry. sources : those that log it.
        writing : where its recordings are to be carried over; None: they are not asked for.
        """
        return self._find((run.id, ""), run, sources, writing)

    def _find(self, place: _Id, run: Run, sources: Sequence[str], writing: Writing | None) -> ReadRun | None:
        stored, snapshot = self._stored.runs.get(place), self._stored.snapshot
        if stored is None or snapshot is None or stored.key != self._key_of_known(run, sources):
            return None
        contents = stored_text(stored.text, self._described)
        blocks = [READ_LOGS + recording_name(run.id, source) for source in contents.blocks]
        tables = [*(recording_name(run.id, source) for source in sources), *blocks] if writing is not None else []
        if writing is not None and not all(snapshot.is_there(name) for name in tables):
            return None
        try:
            read = self._read_of(run.id, stored, contents, snapshot)
        except DamagedStoreError:
            return None
        if writing is not None:
            writing.keep(*tables)
        self._kept[place] = read.states
        return read

    def note_table(self, run: Run, source: str, read: ReadRun) -> None:
        """Take in what reading a run's own table of states gave now."""
        self._made[run.id, source] = (run, [source], read)

    def note(self, run: Run, sources: Sequence[str], read: ReadRun) -> None:
        """Take in what reading a run's logs gave now.

        Raises
        ------
        ReadingPaused : it is time to `write`, and to begin anew with what then is stored.
        """
        self._made[run.id, ""] = (run, sources, read)
        if time.monotonic() > self._pause_at:
            raise ReadingPaused

    def find_names(self, source: str, file: str) -> Sequence[str] | None:
        """Return the runs that a log holds as its run column names them, None where it has to be read."""
        in_file = self._keys.in_file(source)
        if in_file and file not in self._stored.sources:
            return None
        try:
            return self._stored.names.get(self._keys.of_names(source, file, self._hash_of))
        except InputError:  # named where the log is read
            return None

    def note_names(self, source: str, file: str, names: Sequence[str]) -> None:
        """Take in the runs that a log holds."""
        self._names[source] = (source, file, names)

    def write(
        self, writing: Writing, hashes: Sequence[SourceFile], states: Mapping[str, str], paused: bool = False
    ) -> None:
        """Write the readings of all runs that were found or made, to be found by the next command.

        Parameters
        ----------
        hashes : of the logs that were hashed. states : of each, `FileStatus.state` before it was.
        paused : more runs are to come; what is stored of others stays.
        """
        rows: list[tuple[str, str, str, int, str]] = []
        raw_states: list[RawStates] = []
        of_columns = {
            self._keys.of_names(source, file, self._hash_of): list(listed)
            for source, file, listed in self._names.values()
        }
        if paused:
            hashed = {source.file for source in hashes}
            hashes = [*hashes, *(source for file, source in self._stored.sources.items() if file not in hashed)]
            states = {**self._stored.states, **states}
            of_columns = {**{key: list(listed) for key, listed in self._stored.names.items()}, **of_columns}
            for place, stored in self._stored.runs.items():
                if place not in self._kept and place not in self._made:
                    self._kept[place] = self._states_of(place[0], stored, stored_text(stored.text, self._described))
        for place, of_run in {**self._kept, **dict.fromkeys(self._made)}.items():
            if place in self._made:
                run, sources, read = self._made[place]
                of_run = read.states
                key, text = self._keys.of_run(run, sources, self._hash_of), text_of(read)
                for source, blocks in read.blocks.items():
                    writing.write_table(READ_LOGS + recording_name(run.id, source), blocks_table(blocks))
            else:
                key, text = self._stored.runs[place].key, self._stored.runs[place].text
            rows.append((*place, key, 0 if of_run is None else len(of_run.run), text))
            raw_states += [] if of_run is None else [of_run]
        names, tables, keys, counts, texts = zip(*rows, strict=True) if rows else ((), (), (), (), ())
        columns = (names, tables, keys, np.array(counts, dtype=np.int64), texts)
        writing.write_table(READ_RUNS, table_of(dict(zip(_COLUMNS, columns, strict=True))))
        writing.write_table(READ_STATES, raw_states_table(raw_states or [no_states()]))
        writing.write_table(READ_SOURCES, sources_table(hashes, states))
        writing.write_document(READ_NAMES, of_columns)

    def _read_of(self, name: str, stored: _StoredRun, contents: StoredText, snapshot: Snapshot) -> ReadRun:
        blocks = {
            source: blocks_from_table(snapshot.read_table(READ_LOGS + recording_name(name, source)))
            for source in contents.blocks
        }
        return replace(contents.read, id=name, states=self._states_of(name, stored, contents), blocks=blocks)

    def _states_of(self, name: str, stored: _StoredRun, contents: StoredText) -> RawStates | None:
        if self._stored.raw_states is None or contents.blocks:
            return None
        return self._stored.raw_states.of_run(name, stored.first, stored.stop, contents.widths)

    def _key_of_known(self, run: Run, sources: Sequence[str]) -> str | None:
        """Return the present key of a run, None where one of its files was not read when the store was written."""
        if any(file not in self._stored.sources for file in self._keys.files(run, sources)):
            return None
        try:
            return self._keys.of_run(run, sources, self._hash_of)
        except InputError:  # the log cannot be read: reading it says so
            return None
