"""Objects below an address of an object store, asked for in a child process: in bounded memory, and in bounded time."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any, cast
from urllib.parse import urlsplit

from stiffcal.bounded_work.object_child import ABSENT, LONGER, MORE, PIECE, REFUSED, serve
from stiffcal.bounded_work.waiting import WaitingChildren
from stiffcal.errors import InputError, one_line
from stiffcal.fault_codes import FaultCode
from stiffcal.processes import ChildEndedError, ChildSilentError

MEMORY = 512 << 20
"""Of the process that exchanges objects with the store, bytes: an answer longer than what was asked for ends it."""
ANSWER_S = 18.0
"""Until an answer of few bytes is there, s: an object store far away takes one."""
SLOWEST_PER_S = 100e3
"""Bytes for which a second more is allowed: a network of 1 Mbit/s has them."""
COPIED_PER_S = 10e6
"""Bytes for which a second more is allowed where the object store copies in itself."""
_PART = 10 << 20
"""Of a large object so many bytes are sent at once, as Arrow does."""
_REMOVED_S = 60.0
"""To remove a folder, all of whose objects have to be listed, s."""
_STARTED_S = 30.0
"""Until the process is there and its library loaded, s."""


class LongerError(Exception):
    """An object holds more than was written."""


class ObjectStore:
    """The objects of a bucket whose keys begin with a prefix, by the rest of their names.

    Every method raises OSError where the object store refuses, or the answer takes more time or memory than it may;
    FileNotFoundError where there is no such object. After an answer that did not come none is asked for at once again.

    Parameters
    ----------
    root : bucket and prefix, without a slash at the end.
    """

    def __init__(self, root: str) -> None:
        self._root = root
        self._access = {"options": _options(), "environment": _environment()}
        self._lost_until, self._loss = 0.0, ""

    def names(self, folder: str) -> dict[str, int]:
        """Return the objects (and folders) in a folder, each with the time of its last change, ns."""
        return cast(dict[str, int], self._ask("names", self._at(folder)))

    def read(self, name: str) -> bytes:
        """Return the bytes of a small object; raises `LongerError` where it is large."""
        return str(self._ask("read", self._at(name))).encode("latin-1")

    def fetch(self, name: str, path: Path, most_bytes: int) -> None:
        """Write an object to a file; raises `LongerError` where it is longer than it may be."""
        self._ask("fetch", self._at(name), str(path), most_bytes, wait_s=ANSWER_S + PIECE / SLOWEST_PER_S)

    def write(self, name: str, content: bytes) -> None:
        """Write a small object."""
        self._ask("write", self._at(name), content.decode("latin-1"))

    def send(self, path: Path, name: str) -> None:
        """Write a file to an object."""
        part = min(path.stat().st_size, _PART)
        self._ask("send", str(path), self._at(name), wait_s=ANSWER_S + part / SLOWEST_PER_S)

    def copy(self, source: str, target: str, size: int) -> None:
        """Copy an object of so many bytes inside the object store."""
        self._ask("copy", self._at(source), self._at(target), wait_s=ANSWER_S + size / COPIED_PER_S)

    def delete(self, name: str) -> None:
        """Remove an object."""
        self._ask("delete", self._at(name))

    def remove(self, folder: str) -> None:
        """Remove a folder with all that is in it."""
        self._ask("remove", self._at(folder), wait_s=_REMOVED_S)

    def _at(self, name: str) -> str:
        return f"{self._root}/{name}"

    def _ask(self, operation: str, *values: object, wait_s: float | None = None) -> object:
        """Return what a child process answers; `wait_s`: how long each sign of life may take, s."""
        if time.monotonic() < self._lost_until:
            raise OSError(self._loss)
        wait_s = ANSWER_S if wait_s is None else wait_s
        child, is_sound = _CHILDREN.take(), False
        try:
            child.send(json.dumps({"operation": operation, "values": values, "access": self._access}).encode())
            kind, value = json.loads(child.receive(_STARTED_S))
            while kind == MORE:
                kind, value = json.loads(child.receive(wait_s))
            is_sound = True
        except ChildSilentError:
            raise self._lost(f"no answer for {wait_s:.0f} s") from None
        except ChildEndedError as error:
            memory = f"{MEMORY >> 20} MiB of memory"
            raise self._lost(f"the answer cannot be read in {memory} ({error})") from None
        finally:
            if is_sound:
                _CHILDREN.give_back(child)
            else:
                child.kill()
        return _value_of(kind, value)

    def _lost(self, text: str) -> OSError:
        """Return the error of an answer that did not come, and remember it: what has to be put in order would wait."""
        self._lost_until, self._loss = time.monotonic() + 2.0 * ANSWER_S, text
        return OSError(text)


def _value_of(kind: str, value: object) -> object:
    if kind == ABSENT:
        raise FileNotFoundError
    if kind == LONGER:
        raise LongerError
    if kind == REFUSED:
        raise OSError(value)
    return value


def _environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name.startswith("AWS_")}


def _options() -> dict[str, Any]:
    options: dict[str, Any] = {}
    endpoint = os.environ.get("AWS_ENDPOINT_URL_S3") or os.environ.get("AWS_ENDPOINT_URL")
    if endpoint:
        try:
            pieces = urlsplit(endpoint if "://" in endpoint else f"https://{endpoint}")
        except ValueError as error:
            reason, mend = f"{one_line(endpoint)!r} is not an address ({error})", "write https://HOST:PORT"
            raise InputError.at(FaultCode.OPTION_INVALID, "", "AWS_ENDPOINT_URL", reason, mend) from None
        options |= {"endpoint_override": pieces.netloc, "scheme": pieces.scheme}
    region = os.environ.get("AWS_REGION") or os.environ.get("AWS_DEFAULT_REGION")
    if region:
        options["region"] = region
    return options


_CHILDREN = WaitingChildren(serve, memory_bytes=MEMORY)
