"""Pictures of a report kept by their content: one whose content has been drawn before is not drawn again.

The key is the SHA-256 of what draws a picture (the function and all its arguments, by value: pickle's bytes differ with
which equal objects are one, so between what was computed and what was read from the store) and of the code: units,
curves and poses that are drawn come from all over the package. Pictures lie in the user's state folder, which nobody
else can write to, and not in the campaign: a folder from somebody else cannot bring pictures with it.
"""

from __future__ import annotations

import hashlib
import os
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache, partial
from importlib.metadata import version
from pathlib import Path
from types import FunctionType, MethodType
from typing import Any

import numpy as np

from stiffcal.errors import InputError
from stiffcal.files import open_regular, replacing
from stiffcal.report.fonts import is_in_own_letters
from stiffcal.report.pictures_of_fit import PictureOfFit
from stiffcal.trust.record import RECORD, open_record
from stiffcal.trust.state import fault_of_owner, make_private

FOLDER = "pictures"
PACKAGE = Path(__file__).parents[1]
MOST_KEPT = 2000
"""About 20 kB each."""
_MOST_BYTES = 64 << 20


class KeptPictures:
    """The pictures that were drawn before, none where nothing can be remembered."""

    def __init__(self) -> None:
        record = open_record().file
        self._folder = None if record is None else record.parent / FOLDER

    def key(self, draw: Callable[[], Any]) -> str:
        """Return the key of a picture, "" where its content has no bytes of its own or nothing is kept."""
        if self._folder is None:
            return ""
        try:
            content = b"".join(_bytes_of(draw))
        except TypeError:
            return ""
        return hashlib.sha256(_code() + content).hexdigest()

    def write(self, key: str, file: Path) -> bool:
        """Write a picture that was drawn before; False where it was not."""
        if not key or self._folder is None:
            return False
        kept = self._folder / key
        try:
            if fault_of_owner(kept.lstat()):
                return False
            with open_regular(kept) as opened:
                unpacked = zlib.decompressobj()
                text = unpacked.decompress(opened.read(_MOST_BYTES), _MOST_BYTES)
        except (OSError, InputError, zlib.error):
            return False
        if not unpacked.eof:
            return False
        file.write_bytes(text)
        os.utime(kept)
        return True

    def keep(self, key: str, file: Path) -> None:
        """Keep a picture, unless it shows letters that rest on the fonts of this machine."""
        text = file.read_text(encoding="utf-8")
        if not key or self._folder is None or not is_in_own_letters(text):
            return
        with suppress(OSError, InputError):
            make_private(self._folder.parent, RECORD)
            self._folder.mkdir(mode=0o700, exist_ok=True)
            with replacing(self._folder / key) as temporary:
                temporary.write_bytes(zlib.compress(text.encode()))
            self._forget_oldest(self._folder)

    @staticmethod
    def _forget_oldest(folder: Path) -> None:
        entries = list(os.scandir(folder))
        if len(entries) > MOST_KEPT:
            for entry in sorted(entries, key=lambda entry: entry.stat().st_mtime_ns)[: -MOST_KEPT // 2]:
                Path(entry).unlink(missing_ok=True)


def _bytes_of(value: Any) -> Iterator[bytes]:
    """Yield the bytes of a value: others for other values, the same whichever objects hold it.

    Raises
    ------
    TypeError : its content is not known, as that of a function inside another one.
    """
    match value:
        case None | bool() | int() | float() | complex() | str() | bytes() | Enum():
            # NumPy's scalars are numbers of Python too, and written as these are
            plain = value.item() if isinstance(value, np.generic) else value
            yield f"{type(plain).__qualname__} {plain!r};".encode()
        case np.ndarray() if value.dtype != object:
            yield f"{value.dtype.str} {value.shape} ".encode()
            yield np.ascontiguousarray(value).tobytes()
        case np.ndarray() | tuple() | list():
            yield from _bytes_of_several("(", value)
        case dict():
            yield from _bytes_of_several("{", (part for item in value.items() for part in item))
        case set() | frozenset():
            yield from sorted(b"".join(_bytes_of(part)) for part in value)
        case partial():
            yield from _bytes_of_several("partial", (value.func, value.args, value.keywords))
        case FunctionType() | type() if "<" not in value.__qualname__:
            yield f"{value.__module__}.{value.__qualname__};".encode()
        case MethodType():
            yield from _bytes_of_several("method", (value.__func__, value.__self__))
        case PictureOfFit():
            yield from _bytes_of_several("fit", (value.of, value.key, value.caption))
        case _ if is_dataclass(value):
            yield from _bytes_of_several(
                type(value).__qualname__, (getattr(value, field.name) for field in fields(value))
            )
        case _:
            raise TypeError(f"a {type(value).__qualname__} has no bytes of its own")


def _bytes_of_several(name: str, values: Iterable[Any]) -> Iterator[bytes]:
    yield f"{name}[".encode()
    for value in values:
        yield from _bytes_of(value)
    yield b"]"


@lru_cache(maxsize=1)
def _code() -> bytes:
    """Return what the looks of a picture rest on: matplotlib and this package."""
    digest = hashlib.sha256(version("matplotlib").encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.digest()
