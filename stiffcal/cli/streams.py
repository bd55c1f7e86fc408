"""The standard streams as a command needs them: closed ones, full disks behind them and readers that have gone.

Why wrapped: rich and click end the process themselves, with 1, when a write to a stream fails, and 1 means that a
threshold did not hold. Here a stream that cannot take more decides only what it has to:

- the reader of standard output has gone (``| head``): what is left is discarded, the command ends with its own code;
- standard output cannot be written (a full disk): an `InputError`, as the answer is lost;
- standard error cannot be written: what it should hold is discarded, nothing else changes;
- a stream that was closed by the caller (``>&-``) stands for the null device.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import sys
from collections.abc import Iterable, Iterator
from typing import Any, TextIO, cast

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import refusal

NAME = "standard output"


class StandardStream:
    """Standard output or standard error, with the rules above; everything else is the stream's own.

    Parameters
    ----------
    stream : what is written to.
    needed : True where a text that cannot be written is an error.
    """

    def __init__(self, stream: TextIO, needed: bool) -> None:
        self._stream = stream
        self._needed = needed
        self.failure: InputError | None = None
        self.lost = False
        """True from the first failure on: what is written is discarded."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text, or discard it after a failure.

        Raises
        ------
        InputError : standard output cannot be written.
        TypeError : it is no text; click finds out by this that a stream takes texts.
        """
        if not isinstance(text, str):
            raise TypeError(f"text is needed, not {type(text).__name__}")
        if text and not self.lost:
            try:
                self._stream.write(text)
            except OSError as error:
                self._failed(error)
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write texts; raises `InputError` as `write` does."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Hand on what is held back; raises `InputError` as `write` does, after a failure each time."""
        if self.failure is not None:
            raise self.failure
        if not self.lost:
            try:
                self._stream.flush()
            except OSError as error:
                self._failed(error)

    def _failed(self, error: OSError) -> None:
        self.lost = True
        # Windows raises EINVAL for a pipe whose reader has gone
        reader_gone = isinstance(error, BrokenPipeError) or (os.name == "nt" and error.errno == errno.EINVAL)
        if self._needed and not reader_gone:
            self.failure = unwritable(error)
            raise self.failure from None

    def move_to(self, stream: TextIO) -> None:
        """Write to another stream from now on."""
        self._stream = stream

    def release(self) -> None:
        """Write what is held back; where that fails let it go, so that Python can close the stream in peace."""
        with contextlib.suppress(InputError):
            self.flush()
        if self.lost:
            with contextlib.suppress(OSError, ValueError):
                null = os.open(os.devnull, os.O_WRONLY)
                os.dup2(null, self._stream.fileno())
                os.close(null)


def unwritable(error: OSError) -> InputError:
    """Return the error of an answer that standard output does not take."""
    text = os.strerror(error.errno) if error.errno else type(error).__name__
    mend = "redirect it to a file or a pipe that can be written"
    return refusal(error, NAME) or InputError.at(
        FaultCode.FILE_UNWRITABLE, NAME, "", f"cannot be written: {text}", mend
    )


@contextlib.contextmanager
def guarded_streams() -> Iterator[None]:
    """Put the rules of this module on the standard streams.

    Raises
    ------
    InputError : from within, where standard output cannot be written.
    """
    _open_closed_ones()
    originals = sys.stdin, sys.stdout, sys.stderr
    if sys.stdin is None:
        sys.stdin = _null("r")
    answer = StandardStream(_as_utf8(originals[1] or _null("w")), needed=True)
    notes = StandardStream(_as_utf8(originals[2] or _null("w")), needed=False)
    sys.stdout, sys.stderr = cast(TextIO, answer), cast(TextIO, notes)
    try:
        yield
    finally:
        answer.release()
        notes.release()
        sys.stdin, sys.stdout, sys.stderr = originals


def _open_closed_ones() -> None:
    """Open the null device under the numbers 0 to 2 that are closed, or the next log that is opened would get one.

    What a library writes to number 2 would then get into that file.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            with contextlib.suppress(OSError):
                null = os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
                if null != number:
                    os.dup2(null, number)
                    os.close(null)


def _null(mode: str) -> TextIO:
    return cast(TextIO, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123 - as long as the process


def _as_utf8(stream: TextIO) -> TextIO:
    """Let a stream write every character: our answers are UTF-8 whatever the machine's own coding is."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(encoding="utf-8", errors="backslashreplace")
    return stream
