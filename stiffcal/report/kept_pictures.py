"""Pictures of a report kept by their content: one whose content has been drawn before is not drawn again.

The key is the SHA-256 of what draws a picture (the function and all its arguments) and of the code: units, curves and
poses that are drawn come from all over the package. Pictures lie in the user's state folder, which nobody else can
write to, and not in the campaign: a folder from somebody else cannot bring pictures with it.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import zlib
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from stiffcal.errors import InputError
from stiffcal.files import open_regular, replacing
from stiffcal.report.fonts import is_in_own_letters
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
            content = pickle.dumps(draw, protocol=5)
        except (pickle.PicklingError, AttributeError, TypeError):
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


@lru_cache(maxsize=1)
def _code() -> bytes:
    """Return what the looks of a picture rest on: matplotlib and this package."""
    digest = hashlib.sha256(version("matplotlib").encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.digest()
