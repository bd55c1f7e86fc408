"""The record of trust: one file in the user's state folder, `trust.json`.

It holds what the user has allowed (plugin code and queries by their SHA-256, folders under development, places of
stores) and the generations of stores that the user's own runs have written. Nothing in a campaign folder can write to
it: a record inside a campaign folder, or one that others can write to, is not believed.

Where nothing can be remembered (no home, a folder that is read-only), commands work, with a warning of one line.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular, try_lock
from stiffcal.trust.content import (
    SHA256,
    CommittedGeneration,
    Kind,
    NewerSchemaError,
    RecordContent,
    TrustEntry,
    from_json,
    to_json,
)
from stiffcal.trust.notices import notice
from stiffcal.trust.pending import add_pending, all_pending, is_pending, remove_pending
from stiffcal.trust.places import is_within, normal_place
from stiffcal.trust.state import fault_of_owner, fault_of_place, make_private, may_write, state_folder

__all__ = ["CommittedGeneration", "TrustEntry", "TrustRecord", "open_record"]

RECORD, LOCK = "trust.json", "trust.lock"
VARIABLE = "STIFFCAL_TRUST"
_allowed_in_process: set[str] = set()
WAIT_S = 20.0
_POLL_S = 0.01
_MOST_BYTES = 64 << 20
_NOT_REMEMBERED = "nothing is remembered from one command to the next"


class TrustRecord:
    """What the user trusts, as it stood when the record was opened.

    Parameters
    ----------
    folder : the state folder, None where there is none.
    content : what its record holds.
    fault : why the record is not believed and not written, "" where it is.
    """

    def __init__(self, folder: Path | None, content: RecordContent, fault: str = "") -> None:
        self.folder = folder
        self._content = content
        self._fault = fault

    @property
    def file(self) -> Path | None:
        """Where the record is, None where nothing is remembered."""
        return None if self.folder is None or self._fault else self.folder / RECORD

    def plugin_allowed(self, digest: str) -> bool:
        """Return whether the user has allowed plugin code of this SHA-256, in the record or by `STIFFCAL_TRUST`.

        Raises
        ------
        InputError : `STIFFCAL_TRUST` holds something else than hashes.
        """
        return ("plugin", digest) in self._content.allowed or digest in hashes_of_environment()

    def text_allowed(self, digest: str) -> bool:
        """Return whether the user has allowed a query whose text has this SHA-256; as `plugin_allowed`."""
        return ("text", digest) in self._content.allowed or digest in hashes_of_environment()

    def folder_allowed(self, folder: Path) -> bool:
        """Return whether the user trusts whatever plugin code stands in this campaign folder (`trust --edit`)."""
        return ("folder", os.path.realpath(folder)) in self._content.allowed

    def place_allowed(self, uri: str) -> bool:
        """Return whether a store lies in a place that the user trusts: the place itself or anything below it."""
        place = normal_place(uri)
        return any(is_within(place, key) for kind, key in self._content.allowed if kind == "place")

    def generation(self, index_sha256: str) -> CommittedGeneration | None:
        """Return the generation with this index as a run of this user has written it, None where none has."""
        known = self._content.generations.get(index_sha256) or self._written_here().get(index_sha256)
        if known is None and self.file is not None and is_pending(self.file.parent, index_sha256):
            return CommittedGeneration(index_sha256, "", "")
        return known

    def entries(self) -> list[TrustEntry]:
        """Return everything that is trusted, what the user has allowed first."""
        allowed = sorted(self._content.allowed.values(), key=lambda entry: (entry.kind, entry.since))
        known = {**self._content.generations, **self._written_here()}.values()
        listed = [*allowed, *(TrustEntry("generation", row.index_sha256, "", row.committed) for row in known)]
        pending = () if self.file is None else all_pending(self.file.parent)
        return [*listed, *(TrustEntry("generation", digest, "", "") for digest in pending)]

    def allow_plugin(self, digest: str, note: str) -> None:
        """Remember that the user has allowed plugin code; `note` holds where it was.

        Raises
        ------
        InputError : it cannot be remembered.
        """
        self._allow("plugin", digest, note)

    def allow_text(self, digest: str, note: str) -> None:
        """Remember that the user has allowed a query by the SHA-256 of its text; as `allow_plugin`."""
        self._allow("text", digest, note)

    def allow_folder(self, folder: Path) -> None:
        """Remember that the user works on the plugins of this folder; as `allow_plugin`."""
        self._allow("folder", os.path.realpath(folder), "")

    def allow_place(self, uri: str) -> None:
        """Remember that stores in this place, and below it, are as good as the user's own; as `allow_plugin`."""
        self._allow("place", normal_place(uri), "")

    def revoke(self, *names: str) -> list[TrustEntry]:
        """Forget every entry whose key, or the folder where it was allowed, is one of these; return them.

        Parameters
        ----------
        names : hashes, folders (as absolute paths without links) or places (as `normal_place` gives them).

        Raises
        ------
        InputError : the record cannot be written.
        """
        revoked: list[TrustEntry] = []

        def without(content: RecordContent) -> None:
            revoked[:] = [entry for entry in content.allowed.values() if entry.key in names or entry.note in names]
            for entry in revoked:
                del content.allowed[entry.kind, entry.key]
            for name in names:
                row = content.generations.pop(name, None) or self._written_here().pop(name, None)
                if row is not None:
                    revoked.append(TrustEntry("generation", name, "", row.committed))

        self._change_or_raise(without)
        return revoked

    def remember_generation(self, *generations: CommittedGeneration, required: bool = False) -> None:
        """Remember generations that this user's run has just written.

        What the record cannot take is noted next to it. Where that cannot be done either, the generations hold for this
        process alone, with a warning of one line.

        Parameters
        ----------
        generations : what was written.
        required : raise instead where the record could be written when this process began. Why: a generation that
            replaces one of the record and is not in it is nobody's for the next command, which computes all of it
            again.

        Raises
        ------
        InputError : it is required, and refused for a reason that may pass (a full disk, a right taken away).
        """
        for generation in generations:
            if SHA256.fullmatch(generation.index_sha256) is None:
                raise ValueError(f"not a SHA-256: {generation.index_sha256!r}")
        fault = self._change(lambda content: content.add(generations))
        if fault and self.file is not None:
            fault = "" if add_pending(self.file.parent, (row.index_sha256 for row in generations)) else fault
        if fault and required and _writable_at_first.get(self.folder, False):
            mend = "free some space, correct its permissions, or set another folder in STIFFCAL_STATE"
            raise InputError.at(
                FaultCode.TRUST_RECORD, str(self.folder), "", fault, f"{mend}; what was stored before is unchanged"
            )
        self._written_here().update({generation.index_sha256: generation for generation in generations})
        if fault:
            notice(f"{fault}: {_NOT_REMEMBERED}", RECORD)

    def _written_here(self) -> dict[str, CommittedGeneration]:
        return _of_this_process.setdefault(self.folder, {})

    def _allow(self, kind: Kind, key: str, note: str) -> None:
        if kind in ("plugin", "text") and SHA256.fullmatch(key) is None:
            raise ValueError(f"not a SHA-256: {key!r}")
        entry = TrustEntry(kind, key, note, time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()))
        self._change_or_raise(lambda content: content.allowed.update({(kind, key): entry}))

    def _change_or_raise(self, change: Callable[[RecordContent], None]) -> None:
        fault = self._change(change)
        if fault:
            mend = "set a folder of your own in STIFFCAL_STATE"
            raise InputError.at(
                FaultCode.TRUST_RECORD,
                str(self.folder or "the state folder"),
                "",
                f"cannot remember this: {fault}",
                mend,
            )

    def _change(self, change: Callable[[RecordContent], None]) -> str:
        """Read the record as it is now, change it and replace it; return why that cannot be, "" where it was done."""
        if self.folder is None:
            return "there is no home folder"
        if self._fault:
            return self._fault
        try:
            make_private(self.folder, RECORD)
            with _locked(self.folder):
                content, fault = _read(self.folder)
                if fault:
                    return fault
                pending, now = all_pending(self.folder), time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
                noted = [digest for digest in pending if digest not in content.generations]
                content.add(CommittedGeneration(digest, "", now) for digest in noted)
                change(content)
                _replace(self.folder / RECORD, to_json(content))
                remove_pending(self.folder, pending)
                self._content = content
        except (OSError, InputError) as error:
            reason = (error.strerror if isinstance(error, OSError) else "") or str(error)
            return f"{self.folder / RECORD} cannot be written ({reason})"
        return ""


_of_this_process: dict[Path | None, dict[str, CommittedGeneration]] = {}
"""What this process has written, by state folder, also where no record can be kept: no step is computed twice."""

_writable_at_first: dict[Path | None, bool] = {}
"""Whether the record was sound and this process had the right to write it when it first opened it, by state folder."""

_Stamp = tuple[str, int, int, int]
_cached: dict[_Stamp, RecordContent] = {}


def open_record() -> TrustRecord:
    """Return the record as it stands now.

    A damaged one is set aside, one that must not be believed is left alone: one line warns, and nothing is trusted.
    """
    record = _opened(state_folder())
    if record.folder not in _writable_at_first:
        _writable_at_first[record.folder] = record.file is not None and may_write(record.file.parent, LOCK)
    return record


def _opened(folder: Path | None) -> TrustRecord:
    if folder is None:
        notice(f"there is no home folder: {_NOT_REMEMBERED}; set a folder in STIFFCAL_STATE", RECORD)
        return TrustRecord(None, RecordContent())
    fault = fault_of_place(folder)
    if fault:
        fault = f"the state folder {folder} is not trusted, because {fault}"
        notice(
            f"{fault}: {_NOT_REMEMBERED}; set another in STIFFCAL_STATE, or correct its permissions (chmod 700)", RECORD
        )
        return TrustRecord(folder, RecordContent(), fault)
    stamp = _stamp(folder / RECORD)
    if stamp is None:
        return TrustRecord(folder, RecordContent())
    if stamp not in _cached:
        content, fault = _read(folder, may_lock=True)
        if fault:
            notice(f"{fault}: nothing is trusted, and {_NOT_REMEMBERED}", RECORD)
            return TrustRecord(folder, content, fault)
        _cached.clear()
        _cached[stamp] = content
    return TrustRecord(folder, _cached[stamp])


def hashes_of_environment() -> frozenset[str]:
    """Return the hashes in `STIFFCAL_TRUST`, separated by spaces, commas or as in `PATH`.

    Raises
    ------
    InputError : it holds something else.
    """
    text = os.environ.get(VARIABLE, "")
    hashes = [word.lower() for word in re.split(r"[\s,]+|" + re.escape(os.pathsep), text) if word]
    for word in hashes:
        if SHA256.fullmatch(word) is None:
            raise InputError.at(
                FaultCode.OPTION_INVALID,
                "",
                VARIABLE,
                f"{word!r} is not a SHA-256",
                "give the hash that stiffcal trust --hash DIR prints",
            )
    return frozenset((*hashes, *_allowed_in_process))


def allow_in_process(*digests: str) -> None:
    """Allow plugin code and texts by their SHA-256 as long as this process runs; nothing is recorded."""
    _allowed_in_process.update(digests)


def _stamp(file: Path) -> _Stamp | None:
    try:
        status = file.stat()
    except FileNotFoundError:
        return None
    except OSError:
        return (str(file), 0, 0, 0)
    return (str(file), status.st_mtime_ns, status.st_ino, status.st_size)


def _read(folder: Path, may_lock: bool = False) -> tuple[RecordContent, str]:
    """Return the record's content, and the reason why it is not believed ("" where it is).

    Parameters
    ----------
    folder : the state folder.
    may_lock : False: this process holds the lock already.
    """
    file = folder / RECORD
    try:
        with open_regular(file) as opened:
            fault = fault_of_owner(os.fstat(opened.fileno()))
            if fault:
                return RecordContent(), f"{file} is not trusted, because {fault}; correct its permissions (chmod 600)"
            data = opened.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise ValueError("too large")
        return from_json(data.decode("ascii")), ""
    except FileNotFoundError:
        return RecordContent(), ""
    except (OSError, InputError) as error:
        reason = (error.strerror if isinstance(error, OSError) else "") or str(error)
        return RecordContent(), f"{file} cannot be read ({reason})"
    except NewerSchemaError:
        return RecordContent(), f"{file} was written by a newer stiffcal; update stiffcal"
    except ValueError as error:
        return _set_aside(folder, error, may_lock)


def _set_aside(folder: Path, error: ValueError, may_lock: bool) -> tuple[RecordContent, str]:
    """Take a damaged record away, so that the next one can be written; the record that holds then is empty."""
    file = folder / RECORD
    if may_lock:
        try:
            with _locked(folder):
                return _read(folder)  # another process may have replaced it in between
        except (OSError, InputError) as refused:
            return RecordContent(), f"{file} is damaged ({error}) and cannot be set aside ({refused})"
    set_aside = file.with_name(f"{RECORD}.damaged-{time.time_ns()}")
    try:
        file.replace(set_aside)
    except OSError as refused:
        return RecordContent(), f"{file} is damaged ({error}) and cannot be set aside ({refused})"
    notice(
        f"{file} is damaged ({error}) and was renamed to {set_aside.name}: nothing is trusted until you allow it again"
    )
    return RecordContent(), ""


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the lock next to the record.

    Raises
    ------
    InputError : another process has locked it for longer than anybody writes. OSError : the system refuses.
    """
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | getattr(os, "O_NONBLOCK", 0), 0o600)
    try:
        end = time.monotonic() + WAIT_S
        while not try_lock(descriptor):
            if time.monotonic() >= end:
                raise InputError.at(
                    FaultCode.TRUST_RECORD,
                    str(folder / LOCK),
                    "",
                    "another process has locked it",
                    "wait until it has ended",
                )
            time.sleep(_POLL_S)
        yield
    finally:
        os.close(descriptor)


def _replace(file: Path, text: str) -> None:
    temporary = file.with_name(f".{RECORD}.{os.getpid()}")
    with suppress(OSError):
        temporary.unlink()  # of a killed process that had the same number
    try:
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        with os.fdopen(os.open(temporary, flags, 0o600), "wb") as opened:
            opened.write(text.encode("ascii"))
            opened.flush()
            os.fsync(opened.fileno())
        temporary.replace(file)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise
