"""Bytes by which a file of a format is known, without its library."""

from __future__ import annotations

import re
from pathlib import Path

from stiffcal.files import open_regular

_UNPACK = "unpack it, and give the files that are in it; a workbook needs its ending, .xlsx or .ods"
_EXPORT = "export the readings as text (CSV) or as a workbook from the program that recorded them"
_NO_READINGS = "a log is the file that the instrument's program wrote: export it as text (CSV) or as a workbook"
# first bytes of what lies next to logs and is none, what it is, and what to do
_NO_LOGS: tuple[tuple[bytes, str, str], ...] = (
    (rb"%PDF", "a PDF document", _EXPORT),
    (rb"\x89PNG|\xff\xd8\xff|GIF8|II\*\0|MM\0\*|BM.{4}\0{4}|RIFF.{4}WEBP|\0\0..ftyp(?:heic|mif1|avif)", "a picture",
     _NO_READINGS),
    (rb"\0\0..ftyp|RIFF.{4}AVI |\x1aE\xdf\xa3", "a video", _NO_READINGS),
    (rb"PK\x03\x04.{26}(?:\[Content_Types\]|_rels/|word/|ppt/|xl/|docProps/|mimetype)",
     "a packed document of an office program",
     "name a workbook .xlsx or .ods; of another document save the table as CSV"),
    (rb"PK\x03\x04|Rar!|7z\xbc\xaf\x27\x1c|.{257}ustar", "an archive of files", _UNPACK),
    (rb"\xd0\xcf\x11\xe0", "a document of an office program of 1997 to 2003", "save the table as .xlsx, .ods or CSV"),
    (rb"\{\\rtf", "a text document with its formatting", "save the table as .xlsx, .ods or CSV"),
    (rb"(?i:\xef?\xbb?\xbf?\s{0,9}<(?:!doctype html|html))", "a web page", "save its table as .xlsx, .ods or CSV"),
    (rb"\x80[\x02-\x05][\x80-\xff}\]c(]", "an object pickled by Python, which may run any program when it is loaded",
     "write its columns in Python: numpy.savez, or to_csv of a DataFrame"),
    (rb"MZ\x90\0|\x7fELF", "a program", _NO_READINGS),
)  # fmt: skip
LENGTH_OF_START = 512
"""So many first bytes show what a file is."""

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


def not_a_log(start: bytes) -> tuple[str, str] | None:
    """Return what a file is that lies next to logs and is none, and what to do; None where its start shows nothing.

    Parameters
    ----------
    start : its first `LENGTH_OF_START` bytes, fewer where it is shorter.
    """
    found = ((what, mend) for pattern, what, mend in _NO_LOGS if re.match(pattern, start, re.DOTALL))
    return next(found, None)
