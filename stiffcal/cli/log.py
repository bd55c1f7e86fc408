"""What a command does, line by line: on standard error with ``--verbose``, in a file with ``--log-file FILE``.

The lines go through Python's ``logging``, as of the logger ``stiffcal``; where another program has handlers for it,
they get them as well.
"""

from __future__ import annotations

import re
import shlex
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal import __version__
from stiffcal.errors import InputError, one_line
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_stream, open_regular
from stiffcal.masking import mask
from stiffcal.trust.outputs import holds_something, not_ours

if TYPE_CHECKING:
    import logging

    from stiffcal.cli.common_options import CommonOptions

NAME = "stiffcal"
LOG_FILE = "--log-file"
_verbose = [False]
_FIRST = re.compile(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z INFO version \S+: stiffcal ")
_LINE, _TIME = "%(asctime)s.%(msecs)03dZ %(levelname)s %(message)s", "%Y-%m-%dT%H:%M:%S"


@contextmanager
def logging_to(options: CommonOptions, given: Sequence[str]) -> Iterator[None]:
    """Write the lines of `record` inside the block, and the command line before and the duration after it.

    Parameters
    ----------
    options : where to. given : the command line.

    Raises
    ------
    InputError : the file cannot be written, or holds something else than such lines.
    """
    if not options.verbose and options.log_file is None:
        yield
        return
    import logging

    logger = logging.getLogger(NAME)
    handlers = _handlers(options)
    level, propagate = logger.level, logger.propagate
    logger.setLevel(logging.DEBUG)
    logger.propagate = False
    for handler in handlers:
        logger.addHandler(handler)
    _verbose.append(options.verbose)
    start = time.monotonic()
    try:
        record(f"version {__version__}: stiffcal {shlex.join(given)}")
        yield
    except Exception as error:
        record(f"{type(error).__name__}: {error}", "ERROR", is_printed=isinstance(error, InputError))
        raise
    finally:
        _verbose.pop()
        record(f"done after {time.monotonic() - start:.2f} s")
        for handler in handlers:
            logger.removeHandler(handler)
            handler.close()
        logger.setLevel(level)
        logger.propagate = propagate


def _handlers(options: CommonOptions) -> list[logging.Handler]:
    import logging

    handlers: list[logging.Handler] = []
    if options.verbose:
        handlers.append(logging.StreamHandler(sys.stderr))
        handlers[0].addFilter(lambda line: not getattr(line, "is_printed", False))
    if options.log_file is not None:
        file = Path(options.log_file)
        if not options.log_file or options.log_file.startswith("-"):
            reason = f"{options.log_file!r} is no name of a file"
            raise InputError.at(FaultCode.OPTION_INVALID, "command line", LOG_FILE, reason, f"{LOG_FILE} stiffcal.log")
        try:
            check_stream(file)
            if not options.overwrite and holds_something(file) and not _is_log(file):
                raise not_ours(file)
            handlers.append(logging.FileHandler(file, encoding="utf-8", errors="backslashreplace"))
        except OSError as error:
            reason = f"cannot be written ({error.strerror or error})"
            raise InputError.at(
                FaultCode.FILE_UNWRITABLE, options.log_file, LOG_FILE, reason, "choose a file that can"
            ) from error
    form = logging.Formatter(_LINE, _TIME)
    form.converter = time.gmtime
    for handler in handlers:
        handler.setFormatter(form)
    return handlers


def _is_log(file: Path) -> bool:
    """Return whether a file begins as a log of ours does."""
    with open_regular(file) as opened:
        return _FIRST.match(opened.read(100)) is not None


def record(text: str, level: str = "INFO", is_printed: bool = False) -> None:
    """Log one line, without passwords of addresses and without control characters.

    Parameters
    ----------
    text : the line. level : ``INFO``, ``DEBUG``, ``WARNING`` or ``ERROR``.
    is_printed : the command itself prints it on standard error, where it need not appear twice.
    """
    if "logging" not in sys.modules:
        return
    import logging

    logger = logging.getLogger(NAME)
    if logger.handlers:
        logger.log(getattr(logging, level), "%s", one_line(mask(text), 2000), extra={"is_printed": is_printed})


def is_verbose() -> bool:
    """Return whether lines go to standard error, where they and a progress bar would overwrite each other."""
    return _verbose[-1]
