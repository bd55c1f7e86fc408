"""One name of a file or folder, made from a name that anybody may have chosen."""

from __future__ import annotations

import hashlib
import os
import re
from functools import lru_cache
from urllib.parse import quote

_SAFE = " -_+=@#(),"
# What Windows takes for a device, with any ending: learn.microsoft.com, "Naming Files, Paths, and Namespaces".
_DEVICES = re.compile(r"(?:CON|PRN|AUX|NUL|COM[0-9]|LPT[0-9]|CONIN\$|CONOUT\$)(?=$|[ .])", re.IGNORECASE)
LONGEST = 180  # bytes: file systems take 255, and an ending, a lock's or a temporary file's name have to fit as well
_DIGEST = 16
_TAKEN = 240  # bytes that a name can have without the longest ending, `.parquet`


def escaped(text: str) -> str:
    """Return a name that every file system takes, and that leads nowhere; different texts give different names.

    Examples
    --------
    >>> escaped("pose 1?"), escaped(".."), escaped("a/b"), escaped("NUL.pdf"), escaped("end.")
    ('pose 1%3F', '%2E%2E', 'a%2Fb', '%4EUL.pdf', 'end%2E')
    """
    name = quote(text, safe=_SAFE, errors="surrogatepass")
    if _DEVICES.match(name) or name.startswith((" ", "-")):
        name = f"%{ord(name[0]):02X}{name[1:]}"
    if not name.strip("."):
        name = name.replace(".", "%2E")
    elif name.endswith((".", " ")):
        name = f"{name[:-1]}%{ord(name[-1]):02X}"
    if len(name) <= LONGEST:
        return name or "%"
    digest = hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:_DIGEST]
    return f"{re.sub('%.?$', '', name[: LONGEST - _DIGEST - 1])}~{digest}"


@lru_cache(maxsize=1 << 15)
def stored(text: str) -> str:
    """Return a name of a part of a store, which stays what it was in stores of earlier versions where one could be.

    Examples
    --------
    >>> stored("pose 1?"), stored(".."), stored("-rf"), stored(""), len(stored("x" * 300))
    ('pose 1%3F', '%2E%2E', '-rf', '', 180)
    """
    name = quote(text, safe=_SAFE, errors="surrogatepass")
    if not name.strip("."):
        return name.replace(".", "%2E")
    return escaped(text) if len(name) > _TAKEN or _DEVICES.match(name) else name


def with_short_name(path: str, ending: str) -> str:
    """Return a relative path with an ending, its last name shortened where it is too long for a file system.

    Examples
    --------
    >>> with_short_name("cells/a", ".pdf"), len(with_short_name("cells/" + "x" * 255, ".pdf"))
    ('cells/a.pdf', 190)
    """
    folder, slash, name = path.rpartition("/")
    return folder + slash + (escaped(name) if len(os.fsencode(name)) > _TAKEN else name) + ending
