"""What a command does, line by line: on standard error with ``--verbose``, in a file with ``--log FILE``.

Both work with every command. They are taken out of the arguments before the command reads its own, so that a command
without them loads nothing for it. The lines go through Python's ``logging``, as of the logger ``stiffcal``; where
another program has handlers for it, they get them as well.
"""

from __future__ import annotations

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
from stiffcal.masking import mask

if TYPE_CHECKING:
    import logging

VERBOSE, LOG = "--verbose", "--log"
NAME = "stiffcal"
_verbose = [False]
_LINE, _TIME = "%(asctime)s.%(msecs)03dZ %(levelname)s %(message)s", "%Y-%m-%dT%H:%M:%S"


def taken_out(given: Sequence[str]) -> tuple[list[str], bool, str | None]:
    """Return the arguments without ``--verbose`` and ``--log FILE``, whether there was the one, and the file.

    Raises
    ------
    InputError : `--log` has no file.

    Examples
    --------
    >>> taken_out(["check", "robot", "--log=run.log", "--verbose"])
    (['check', 'robot'], True, 'run.log')
    """
    kept: list[str] = []
    verbose, file = False, None
    words = iter(given)
    for word in words:
        if word == "--":
            kept += [word, *words]
        elif word == VERBOSE:
            verbose = True
        elif word == LOG or word.startswith(f"{LOG}="):
            file = next(words, "") if word == LOG else word.partition("=")[2]
            if not file or file.startswith("-"):
                raise InputError.at(
                    FaultCode.OPTION_INVALID, "command line", LOG, "it needs a file", f"{LOG} stiffcal.log"
                )
        else:
            kept.append(word)
    return kept, verbose, file


@contextmanager
def logging_to(verbose: bool, file: str | None, given: Sequence[str]) -> Iterator[None]:
    """Write the lines of `record` inside the block, and the command line before and the duration after it.

    Parameters
    ----------
    verbose : to standard error. file : appended to; None: to no file. given : the command line.

    Raises
    ------
    InputError : the file cannot be written.
    """
    if not verbose and file is None:
        yield
        return
    import logging

    logger = logging.getLogger(NAME)
    handlers = _handlers(verbose, file)
    level, propagate = logger.level, logger.propagate
    logger.setLevel(logging.DEBUG)
    logger.propagate = False
    for handler in handlers:
        logger.addHandler(handler)
    _verbose.append(verbose)
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


def _handlers(verbose: bool, file: str | None) -> list[logging.Handler]:
    import logging

    handlers: list[logging.Handler] = []
    if verbose:
        handlers.append(logging.StreamHandler(sys.stderr))
        handlers[0].addFilter(lambda line: not getattr(line, "is_printed", False))
    if file is not None:
        try:
            handlers.append(logging.FileHandler(Path(file), encoding="utf-8", errors="backslashreplace"))
        except OSError as error:
            reason = f"cannot be written ({error.strerror or error})"
            raise InputError.at(FaultCode.FILE_UNWRITABLE, file, LOG, reason, "choose a file that can") from error
    form = logging.Formatter(_LINE, _TIME)
    form.converter = time.gmtime
    for handler in handlers:
        handler.setFormatter(form)
    return handlers


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
