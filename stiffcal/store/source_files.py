"""The files that a store is made from: their hashes, and what shows that one of them is still as it was hashed.

A file is known to be unchanged where its place, size and times are those that were noted after its pages had been
written back, on a file system on which every later write moves them (`file_systems`). Of all others, and of the
smallest ones in any case, the content is compared.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
import threading
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.store.file_systems import shows_mapped_writes, write_back

CHUNK = 1 << 20
# A file changed within this time of being hashed may carry the same time of change: clocks of file systems are coarse.
RACY_NS = 3_000_000_000
ALWAYS_HASHED = 64 << 20
"""Bytes of sources, the smallest first, that are compared by their content in every command: 0.05 to 0.2 s of SHA-256.

Of thousands of logs no command reads gigabytes only to learn that nothing has changed."""
MOST_HASHED = 1000
"""Files of these at most: opening one takes as long as hashing 50 kB."""

_NOT_THERE = (errno.ENOENT, errno.ENOTDIR, errno.ELOOP)


@dataclass(frozen=True)
class SourceFile:
    """A source as it was when it was read."""

    file: str
    """Path relative to the campaign folder, with forward slashes, as in the manifest."""
    bytes: int
    """Size."""
    modified_ns: int
    """Time of the last change, ns since 1970."""
    sha256: str
    """Hexadecimal."""


@dataclass(frozen=True)
class FileStatus:
    """What the file system knows of a source."""

    bytes: int
    """Size, of all its files where it is a folder."""
    modified_ns: int
    """Time of the last change of content, ns since 1970."""
    state: str
    """Digest of name, device, inode, size, times of change of content and of inode; "" where these do not show every
    change: a program that writes a file without changing them has set back the system clock.
    """


class FileStatuses:
    """The status of sources, each looked at once.

    Parameters
    ----------
    folder : the campaign folder. files : paths relative to it.
    """

    def __init__(self, folder: Path, files: Sequence[str]) -> None:
        self._folder = folder
        self._shows: dict[int, bool] = {}
        self.of_file: dict[str, FileStatus] = {}
        """Those of the files that are there."""
        for file in files:
            if file not in self.of_file:
                try:
                    self.of_file[file] = self._status(file)
                except OSError as error:
                    if error.errno not in _NOT_THERE:
                        raise _unreadable(file, error) from None

    def settle(self, file: str) -> FileStatus:
        """Have what is written of a file but not yet on the disk written back, and return its status after that.

        While a page waits for that, writes to it through a mapping leave the file's times as they are. A file is
        hashed after it: then whatever comes later shows.
        """
        path = self._folder / file
        known = self.of_file[file]
        if known.state and not all(write_back(part) for part in _parts(path)):
            self.of_file[file] = replace(known, state="")
        elif known.state:
            try:
                self.of_file[file] = self._status(file)
            except OSError as error:
                raise _unreadable(file, error) from None
        return self.of_file[file]

    def _status(self, file: str) -> FileStatus:
        path = os.path.join(self._folder, file)  # noqa: PTH118 — ten thousand of them: Path takes ten times as long
        status = os.stat(path)  # noqa: PTH116
        if stat.S_ISDIR(status.st_mode):
            parts = [(part.relative_to(path).as_posix(), part.stat()) for part in _parts(Path(path))]
        else:
            parts = [("", status)]
        latest = max((max(own.st_mtime_ns, own.st_ctime_ns) for _, own in parts), default=0)
        rows = [
            (name, own.st_dev, own.st_ino, own.st_size, own.st_mtime_ns, own.st_ctime_ns)
            for name, own in parts
            if self._shows_changes(own.st_dev, path)
        ]
        state = ""
        if len(rows) == len(parts) and latest + RACY_NS <= time.time_ns():
            state = hashlib.sha256(repr((file, rows)).encode("utf-8", "surrogateescape")).hexdigest()
        size = sum(own.st_size for _, own in parts)
        return FileStatus(size, max((own.st_mtime_ns for _, own in parts), default=0), state)

    def _shows_changes(self, device: int, path: str) -> bool:
        if device not in self._shows:
            self._shows[device] = shows_mapped_writes(Path(path))
        return self._shows[device]

    def always_compared(self) -> frozenset[str]:
        """Return the sources whose content is compared in every command: the smallest, up to `ALWAYS_HASHED`."""
        sizes = sorted((status.bytes, file) for file, status in self.of_file.items())
        compared, total = set(), 0
        for size, file in sizes[:MOST_HASHED]:
            total += size
            if total > ALWAYS_HASHED:
                break
            compared.add(file)
        return frozenset(compared)

    def unchanged(self, states: Mapping[str, str]) -> frozenset[str]:
        """Return the files that are as they were when these states were noted, by what the file system knows."""
        return frozenset(
            file for file, status in self.of_file.items() if status.state and states.get(file) == status.state
        )

    def state_of_all(self, files: Sequence[str]) -> str:
        """Return one digest of the states of files, "" where one of them has none, or there are no files."""
        states = [self.of_file[file].state if file in self.of_file else "" for file in files]
        return hashlib.sha256("".join(states).encode()).hexdigest() if states and all(states) else ""


class SourceHashes:
    """The hashes of files, taken by threads. Made by `hash_sources`."""

    def __init__(
        self, folder: Path, files: Sequence[str], then: Mapping[str, SourceFile], states: Mapping[str, str]
    ) -> None:
        self._folder, self._files = folder, tuple(dict.fromkeys(files))
        self._stop = threading.Event()
        # before anything is read: what is written through a mapping from now on moves the files' times
        self._statuses = FileStatuses(folder, self._files)
        self._unchanged = self._statuses.unchanged(states)
        unread = self._unchanged - self._statuses.always_compared()
        self._known = {file: then[file] for file in self._files if file in unread and file in then}
        self._pool = ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="hash sources")
        self._waiting: dict[str, Future[dict[str, SourceFile | InputError]]] = {}
        for batch in self._batches([file for file in self._files if file not in self._known]):
            self._waiting |= dict.fromkeys(batch, self._pool.submit(self._hash, batch))

    def _batches(self, files: Iterable[str]) -> Iterator[list[str]]:
        """Cut files into those that are hashed one after the other: handing one of 10 kB over takes as long as it."""
        batch, size = [], 0
        for file in files:
            batch.append(file)
            size += self._statuses.of_file[file].bytes if file in self._statuses.of_file else CHUNK
            if size >= CHUNK:
                yield batch
                batch, size = [], 0
        if batch:
            yield batch

    def _hash(self, batch: Sequence[str]) -> dict[str, SourceFile | InputError]:
        found: dict[str, SourceFile | InputError] = {}
        for file in batch:
            try:
                if file in self._statuses.of_file and file not in self._unchanged:
                    self._statuses.settle(file)  # else nothing was written since it was settled
                found[file] = hash_file(self._folder, file, self._stop)
            except InputError as error:
                found[file] = error
        return found

    def stop(self) -> None:
        """Give up."""
        self._stop.set()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def of(self, file: str) -> SourceFile:
        """Return the hash of a file, once it is taken.

        Raises
        ------
        InputError
            If the file cannot be read, or was changed while it was hashed.
        """
        found = self._known[file] if file in self._known else self._waiting[file].result()[file]
        if isinstance(found, InputError):
            raise found
        return found

    def result(self) -> tuple[SourceFile, ...]:
        """Wait for all hashes.

        Raises
        ------
        InputError
            If a file cannot be read, or was changed meanwhile.
        """
        found = tuple(self.of(file) for file in self._files)
        after = FileStatuses(self._folder, self._files).of_file
        for source in found:
            now = after.get(source.file)
            if now is None or (now.bytes, now.modified_ns) != (source.bytes, source.modified_ns):
                raise _changed_meanwhile(source.file)
        return found

    def finished(self) -> list[SourceFile]:
        """Return the hashes that are taken so far."""
        found: dict[str, SourceFile | InputError] = {**self._known}
        for batch in set(self._waiting.values()):
            if batch.done() and not batch.cancelled() and batch.exception() is None:
                found |= batch.result()
        return [hashed for file in self._files if isinstance(hashed := found.get(file), SourceFile)]

    @property
    def states(self) -> dict[str, str]:
        """Of each file `FileStatus.state`, as it was noted before it was hashed."""
        return {file: status.state for file, status in self._statuses.of_file.items()}

    @property
    def state(self) -> str:
        """`FileStatuses.state_of_all` of the files that were hashed, "" where one of them has changed since."""
        always = self._statuses.always_compared()
        compared = [file for file in self._files if file not in always]
        now = FileStatuses(self._folder, self._files).state_of_all(compared)
        return now if now == self._statuses.state_of_all(compared) else ""


@contextmanager
def hash_sources(
    folder: Path,
    files: Sequence[str],
    then: Mapping[str, SourceFile] | None = None,
    states: Mapping[str, str] | None = None,
) -> Iterator[SourceHashes]:
    """Hash files while something else is done inside the block; ``result()`` gives the hashes.

    Parameters
    ----------
    folder : the campaign folder.
    files : paths relative to it, as in the manifest; the first are hashed first.
    then, states : the files as this user's own run has hashed them, and their `FileStatus.state`; one whose state is
        the same now is not hashed again.
    """
    hashes = SourceHashes(folder, files, then or {}, states or {})
    try:
        yield hashes
    finally:
        hashes.stop()


def hash_files(folder: Path, files: Sequence[str]) -> list[SourceFile]:
    """Return the hashes of files, each processor taking one at a time: what hashes holds no lock of the interpreter."""
    workers = min(os.cpu_count() or 1, len(files))
    if workers < 2:
        return [hash_file(folder, file) for file in files]
    with ThreadPoolExecutor(workers, thread_name_prefix="hash sources") as pool:
        waiting = [pool.submit(hash_file, folder, file) for file in files]
        try:
            return [one.result() for one in waiting]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def hash_file(folder: Path, file: str, stop: threading.Event | None = None) -> SourceFile:
    """Return the hash of a file, or of all files of a folder.

    Raises
    ------
    InputError : it cannot be read, or changed meanwhile.
    """
    parts = _parts_as_they_are(folder, file)
    digest = hashlib.sha256()
    try:
        for path in parts:
            with open_regular(path, file, buffering=0) as stream:
                while (chunk := stream.read(CHUNK)) and not (stop is not None and stop.is_set()):
                    digest.update(chunk)
    except OSError as error:
        raise _unreadable(file, error) from None
    if _parts_as_they_are(folder, file) != parts:
        raise _changed_meanwhile(file)
    size, latest = sum(size for size, _ in parts.values()), max((time for _, time in parts.values()), default=0)
    return SourceFile(file, size, latest, digest.hexdigest())


def _parts_as_they_are(folder: Path, file: str) -> dict[Path, tuple[int, int]]:
    """Return size and time of the last change, ns, of a file, or of all files of a folder, in order."""
    path = folder / file
    try:
        status = path.stat()  # calls of the system are what hashing a thousand small files takes
        states = {part: part.stat() for part in _parts(path)} if stat.S_ISDIR(status.st_mode) else {path: status}
    except OSError as error:
        raise _unreadable(file, error) from None
    return {part: (state.st_size, state.st_mtime_ns) for part, state in states.items()}


def _parts(path: Path) -> list[Path]:
    """Return the files of a log that is a folder, or the file."""
    return sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]


def _unreadable(file: str, error: OSError) -> InputError:
    return InputError.at(
        FaultCode.FILE_UNREADABLE,
        file,
        "",
        f"cannot be read: {error.strerror}",
        "correct the name of the file or its permissions",
    )


def _changed_meanwhile(file: str) -> InputError:
    return InputError.at(
        FaultCode.FILE_CHANGED,
        file,
        "",
        "the file changed while it was read",
        "wait until the log is closed, then ingest",
    )
