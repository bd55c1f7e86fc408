"""The log file of an internal fault: what a user sends to the authors, without secrets."""

from __future__ import annotations

import os
import sys
import tempfile
import time
import traceback
from contextlib import suppress

from stiffcal.masking import mask


def write_fault_log(error: BaseException, version: str, command: str) -> str | None:
    """Write the traceback of an internal fault to a new file that only its user can read.

    Why `tempfile`: on a machine that several people share, a name that can be guessed could be a link that somebody
    else has put there.

    Parameters
    ----------
    error : the fault.
    version : of stiffcal.
    command : the command line.

    Returns
    -------
    The file's path, None where no file could be written.
    """
    head = f"stiffcal {version}, Python {sys.version}, {sys.platform}\n{command}\n\n"
    text = mask(head + "".join(traceback.format_exception(error)))
    stamp, path = time.strftime("%Y%m%d-%H%M%S"), None
    try:
        descriptor, path = tempfile.mkstemp(prefix=f"stiffcal-fault-{stamp}-", suffix=".log")  # mode 0600
        with os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace") as log:
            log.write(text)
    except OSError:
        if path is not None:
            with suppress(OSError):
                os.unlink(path)  # noqa: PTH108
        return None
    return path
