"""Places of stores, compared part by part: `s3://lab/cells` holds `s3://lab/cells/a`, not `s3://lab/cells-of-others`."""

from __future__ import annotations

import os


def normal_place(uri: str) -> str:
    """Return a place in the form in which places are kept and compared: a URI, or an absolute path without links.

    Examples
    --------
    >>> normal_place("S3://lab/cells/")
    's3://lab/cells'
    """
    scheme, separator, rest = uri.partition("://")
    if not separator or len(scheme) < 2:
        return os.path.realpath(uri)
    if scheme.lower() == "file":
        return os.path.realpath(rest)
    return f"{scheme.lower()}://{rest.rstrip('/')}"


def is_within(place: str, allowed: str) -> bool:
    """Return whether a place is an allowed one or lies below it; both as `normal_place` gives them.

    Examples
    --------
    >>> is_within("s3://lab/cells/a", "s3://lab/cells"), is_within("s3://lab/cells-2", "s3://lab/cells")
    (True, False)
    >>> is_within("s3://lab/cells/../secret", "s3://lab/cells")
    False
    >>> is_within("s3://lab/cells/a?endpoint_override=elsewhere", "s3://lab/cells")
    False
    """
    if place == allowed:
        return True
    if "://" not in allowed:
        return "://" not in place and place.startswith(allowed.rstrip(os.sep) + os.sep)
    # what follows the question mark can name another server: such a place is allowed as a whole or not at all
    if "?" in place + allowed or "#" in place + allowed:
        return False
    pieces = place.split("/")
    return place.startswith(allowed + "/") and not {"", ".", ".."} & set(pieces[3:])
