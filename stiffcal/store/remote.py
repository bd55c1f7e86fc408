"""A store in an object store (``s3://bucket/prefix``).

Layout, as of a folder: ``generations/ID/…``, and in ``current/`` an object ``NUMBER-TICKET-ID`` for the generation that
holds: the last by its name counts. An object appears whole or not at all, so that putting this one, last of all, is the
one atomic step. Reading and writing go through a folder of this process on the local disk: tables are fetched when they
are first read, written there in bounded memory and sent when they are finished. What is kept unchanged is copied inside
the object store.

Two writers: S3 has no locks, and Arrow no conditional put; but what was put can be read by everyone at once. That is
enough for Lamport's bakery: a writer announces itself, draws a number above all it reads, and waits until every smaller
one is gone. It renews its number while it works; one that stands still for `LEASE_S` belonged to a process that was
killed, and is removed. Before the switch the writer checks that its number is still there and that the generation it
began from still holds. One that is stopped between that look and the switch, for longer than the lease, and then wakes
up, puts an object that does not count: its NUMBER is that of what it began from, plus one, and who came after it has a
larger NUMBER or TICKET. After the switch every writer looks again: where another has switched too since it began, it
takes its own back with an error. So of two one may have to do its work again, but no result is lost without a word.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
import socket
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.util import Finalize
from pathlib import Path
from typing import NoReturn
from urllib.parse import unquote, urlsplit

from stiffcal.bounded_work.object_store import LongerError, ObjectStore
from stiffcal.documents import Document
from stiffcal.errors import InputError, one_line
from stiffcal.fault_codes import FaultCode
from stiffcal.masking import mask
from stiffcal.store.generations import CURRENT, GENERATIONS, current_folder, is_generation_name, switch
from stiffcal.store.index import INDEX, MOST_BYTES, REBUILD, DamagedStoreError

LEASE_S = 60.0
RENEW_S = 10.0
POLL_S = 0.1
ENTERING, TICKET = "entering-", "ticket-"
_TICKET = re.compile(r"ticket-(\d{8,18})-[0-9a-f]+")
_POINTER = re.compile(r"(\d{10})-(\d{8})-(.+)")
CHECK = "check the address, and AWS_ENDPOINT_URL, AWS_REGION, AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"

_mirrors: dict[tuple[int, str], Path] = {}


class Remote:
    """A store's place in an object store.

    Attributes
    ----------
    address : without encoding, as places are allowed. display_name : how it is called in messages.
    mirror : the folder of this process that stands for it.
    """

    def __init__(self, address: str, display_name: str) -> None:
        pieces = urlsplit(address)
        self.display_name = display_name
        self._root = f"{pieces.netloc}/{unquote(pieces.path).strip('/')}".rstrip("/")
        # As it is used, so that two dots behind a percent sign lead out of no place that the user allows.
        self.address = f"s3://{self._root}"
        if not pieces.netloc:
            raise InputError.at(
                FaultCode.STORE_ADDRESS,
                display_name,
                "--store",
                "the address contains no bucket",
                "write s3://BUCKET/PREFIX",
            )
        self._objects = ObjectStore(self._root)
        self._switching_to = ""
        self.mirror = _mirror(address)

    def pull(self) -> None:
        """Make the mirror's current generation the one that holds now; its tables and documents are fetched later."""
        with self.faults():
            generation = self.generation()
            if generation is None:
                return
            folder = self.mirror / GENERATIONS / generation
            mirrored = current_folder(self.mirror)
            if mirrored is not None and mirrored.name == generation and (folder / INDEX).exists():
                return
            self.fetch(folder / INDEX, MOST_BYTES)
        switch(self.mirror, generation)

    def generation(self) -> str | None:
        """Return the name of the generation that holds, or None."""
        pointers = self._pointers()
        return pointers[-1][2] if pointers else None

    def _pointers(self) -> list[tuple[str, str, str]]:
        """Return number, ticket and generation of all that were switched to and are still there; the last one holds."""
        pointers = (_POINTER.fullmatch(name) for name in self.names(CURRENT))
        return sorted((match[1], match[2], match[3]) for match in pointers if match and is_generation_name(match[3]))

    def fetch(self, path: Path, most_bytes: int) -> None:
        """Bring a file of the mirror from the object store, where it is not here yet.

        Parameters
        ----------
        path : in the mirror.
        most_bytes : what is longer is not what was written.
        """
        if path.exists():
            return
        name = path.relative_to(self.mirror).as_posix()
        path.parent.mkdir(parents=True, exist_ok=True)
        fresh = path.with_name(f".{path.name}-{secrets.token_hex(3)}")
        try:
            self._objects.fetch(name, fresh, most_bytes)
        except LongerError:
            reason = f"damaged (more than {most_bytes} bytes)"
            raise DamagedStoreError.at(FaultCode.STORE_DAMAGED, self.display_name, name, reason, REBUILD) from None
        except FileNotFoundError:
            reason, mend = "it was replaced while it was read, or is damaged", "do this again"
            raise InputError.at(FaultCode.STORE_DAMAGED, self.display_name, name, reason, mend) from None
        else:
            fresh.replace(path)
        finally:
            fresh.unlink(missing_ok=True)

    def publish(self, folder: Path, kept: dict[str, tuple[str, int]], began_from: str | None, ticket: Ticket) -> None:
        """Send a finished generation and make it the one that holds.

        Parameters
        ----------
        folder : of the mirror.
        kept : files carried over unchanged, to the generation that holds them, and their bytes.
        began_from : the generation that held when it was begun.
        ticket : this writer's number.
        """
        place = f"{GENERATIONS}/{folder.name}"
        for file, (generation, size) in kept.items():
            try:
                self._objects.copy(f"{GENERATIONS}/{generation}/{file}", f"{place}/{file}", size)
            except FileNotFoundError:
                reason = "damaged (the object is gone)"
                mend = "delete the store and run ingest again (its history goes too)"
                raise InputError.at(FaultCode.STORE_DAMAGED, self.display_name, file, reason, mend) from None
        sent = sorted((path for path in folder.rglob("*") if path.is_file()), key=lambda path: path.name == INDEX)
        for path in sent:
            self._objects.send(path, f"{place}/{path.relative_to(folder).as_posix()}")
        before = self._pointers()
        if not ticket.holds() or (before[-1][2] if before else None) != began_from:
            self._give_up(place)
        number = int(before[-1][0]) + 1 if before else 1
        entry_name = f"{number:010d}-{ticket.number:08d}-{folder.name}"
        self._switching_to = folder.name
        self._write(f"{CURRENT}/{entry_name}", folder.name.encode("ascii"))
        since = [pointer for pointer in self._pointers() if int(pointer[0]) >= number and pointer[2] != folder.name]
        if since:
            self.delete(f"{CURRENT}/{entry_name}")
            self._give_up(place)
        for pointer in before:
            self.delete(f"{CURRENT}/{'-'.join(pointer)}")
        self._remove_others({folder.name, began_from or folder.name})

    def _give_up(self, place: str) -> NoReturn:
        self._remove(place)
        reason = (
            "another stiffcal process took over the lock and wrote to the store; the results of this process "
            "are not stored"
        )
        raise InputError.at(FaultCode.STORE_LOCKED, self.display_name, "", reason, "do this again")

    def withdraw(self, folder: Path) -> None:
        """Remove what was sent of a generation that was given up.

        What a switch was asked for stays, also where no answer came: the switch may come late. If it does not, the next
        writer removes it.
        """
        if self._switching_to != folder.name:
            with suppress(OSError):
                self._remove(f"{GENERATIONS}/{folder.name}")

    def _remove_others(self, keep: set[str]) -> None:
        # Who reads the last generation may go on: it goes with the next writing.
        with suppress(OSError):
            for name in self.names(GENERATIONS):
                if name not in keep:
                    self._remove(f"{GENERATIONS}/{name}")

    def names(self, folder: str) -> dict[str, int]:
        """Return the objects (and folders) in a folder, each with the time of its last change, ns."""
        return self._objects.names(folder)

    def put(self, name: str, content: Document) -> None:
        """Write a small object of JSON."""
        self._write(name, json.dumps(content).encode())

    def get(self, name: str) -> Document:
        """Read a small object of JSON; empty where there is none."""
        try:
            return dict(json.loads(self._objects.read(name)))
        except (FileNotFoundError, LongerError, ValueError, TypeError, RecursionError):
            return {}

    def delete(self, name: str) -> None:
        """Remove an object, if it is there."""
        with suppress(FileNotFoundError):
            self._objects.delete(name)

    @contextmanager
    def faults(self) -> Iterator[None]:
        """Turn what the object store refuses into one line."""
        try:
            yield
        except OSError as error:
            message = mask(" ".join(str(error).split()))[:300]
            raise InputError.at(
                FaultCode.STORE_INACCESSIBLE, self.display_name, "", f"cannot be used: {message}", CHECK
            ) from None

    def _write(self, name: str, content: bytes) -> None:
        self._objects.write(name, content)

    def _remove(self, folder: str) -> None:
        with suppress(FileNotFoundError):
            self._objects.remove(folder)


class Ticket:
    """A writer's number in the queue, renewed by a thread until it is given back."""

    def __init__(self, remote: Remote, name: str, who: Document) -> None:
        self.name = name
        self.number = int(name.split("-")[1])
        self._remote, self._who = remote, who
        self._ended = threading.Event()
        remote.put(f"lock/{name}", who)
        self._thread = threading.Thread(target=self._renew, name="renew the store's lock", daemon=True)
        self._thread.start()

    def _renew(self) -> None:
        while not self._ended.wait(RENEW_S):
            with suppress(OSError):
                # One that was taken for dead must not come back.
                if self.holds():
                    self._remote.put(f"lock/{self.name}", self._who)

    def holds(self) -> bool:
        """True while nobody took this writer for dead."""
        return self.name in self._remote.names("lock")

    def give_back(self) -> None:
        """Leave the queue."""
        self._ended.set()
        self._thread.join()
        with suppress(OSError):
            self._remote.delete(f"lock/{self.name}")


@contextmanager
def remote_lock(remote: Remote, command: str, wait_s: float) -> Iterator[Ticket]:
    """Hold the right to write, among all that know the address.

    Raises
    ------
    InputError
        If another still writes after `wait_s` seconds; it is named.
    """
    token = secrets.token_hex(8)
    holder = {"command": command, "pid": os.getpid(), "host": socket.gethostname()}
    with remote.faults():
        remote.put(f"lock/{ENTERING}{token}", holder)
        try:
            numbers = [int(match[1]) for name in remote.names("lock") if (match := _TICKET.fullmatch(name))]
            ticket = Ticket(remote, f"{TICKET}{max(numbers, default=0) + 1:08d}-{token}", holder)
        finally:
            remote.delete(f"lock/{ENTERING}{token}")
    try:
        with remote.faults():
            _wait(remote, ticket, wait_s)
        yield ticket
    finally:
        ticket.give_back()


def _wait(remote: Remote, ticket: Ticket, wait_s: float) -> None:
    end = time.monotonic() + wait_s
    last_change: dict[str, tuple[int, float]] = {}
    while True:
        names = remote.names("lock")
        before = [name for name in names if name.startswith(ENTERING)]
        before += [name for name in names if name.startswith(TICKET) and name < ticket.name]
        now = time.monotonic()
        for name in before:
            changed, since = last_change.get(name, (names[name], now))
            last_change[name] = (names[name], since if changed == names[name] else now)
            if now - last_change[name][1] > LEASE_S:
                remote.delete(f"lock/{name}")
        if not before:
            return
        if now >= end:
            holder = remote.get(f"lock/{sorted(before, key=lambda name: name.startswith(ENTERING))[0]}")
            texts = [one_line(str(holder.get(key, "")), 60) for key in ("command", "pid", "host")]
            writer = f" ({texts[0]}, process {texts[1]} on {texts[2]})" if holder else ""
            mend = f"wait until it has ended, then do this again; if it was killed, its lock ends {LEASE_S:g} s later"
            raise InputError.at(
                FaultCode.STORE_LOCKED, remote.display_name, "", f"another stiffcal{writer} is writing to it", mend
            )
        time.sleep(POLL_S)


def _mirror(address: str) -> Path:
    """Return the folder of this process that stands for the address; it goes with the process."""
    key = (os.getpid(), address)
    if key not in _mirrors:
        _mirrors[key] = folder = Path(tempfile.mkdtemp(prefix="stiffcal-store-"))
        # Unlike atexit this is also called where a process that another one forked or spawned ends.
        Finalize(None, _clear, (folder, os.getpid()), exitpriority=0)
    return _mirrors[key]


def _clear(folder: Path, owner: int) -> None:
    if os.getpid() == owner:  # a forked process inherits the registration, not the folder
        shutil.rmtree(folder, ignore_errors=True)
