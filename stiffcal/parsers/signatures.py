"""Bytes by which a file of a format is known, without its library."""

from __future__ import annotations

import re
from pathlib import Path

from stiffcal.files import open_regular

_JSON = re.compile(rb'(?:\xef\xbb\xbf)?\s*(?:\[\s*)?\{\s*"')
_HDF5 = b"\x89HDF\r\n\x1a\n"


def begins_like_hdf5(path: Path) -> bool:
    """Return True for a file that begins like HDF5, behind nothing or behind 512, 1024, 2048, … bytes of the user's."""
    try:
        with open_regular(path) as file:
            at = 0
            while len(start := file.read(len(_HDF5))) == len(_HDF5):
                if start == _HDF5:
                    return True
                at = max(2 * at, 512)
                file.seek(at)
    except OSError:
        return False
    return False


def begins_like_json(path: Path) -> bool:
    """Return True for a text that begins with an object that has a key, or a list of objects."""
    try:
        with open_regular(path) as file:
            start = file.read(256)
    except OSError:
        return False
    return _JSON.match(start) is not None
