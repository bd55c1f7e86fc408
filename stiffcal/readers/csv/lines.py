"""The bytes of a text log, as the CSV parser is to see them: one line end, no empty lines, every line counted.

Why between the file and the parser: exact line numbers, a file that ends in the middle of a line and a quotation mark
that swallows lines can only be detected here. All steps are on whole chunks of bytes: far cheaper than parsing.
"""

from __future__ import annotations

import codecs
import io
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Lock
from typing import IO

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import LINE, check_unpacked
from stiffcal.packed_files import UNPACKING_ERRORS, unpacked_stream
from stiffcal.table_layout.sections import GAP_LINE
from stiffcal.table_layout.text import FIRST_BYTES, encoding_of

CHUNK = 1 << 20
TAIL = 1 << 14
# Encodings in which digits and delimiters are the bytes of ASCII and no other character contains such a byte:
# numbers can be parsed without decoding the file.
PLAIN = {"utf-8", "ascii", "cp1250", "cp1251", "cp1252"} | {f"iso8859-{number}" for number in range(1, 17)}


def find_codec(encoding: str, display_name: str) -> str:
    """Return the canonical name of a text encoding; raises `InputError` where there is none."""
    try:
        "".encode(encoding)
        return codecs.lookup(encoding).name
    except (LookupError, ValueError):
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            display_name,
            "csv.encoding",
            f"no encoding {encoding!r}",
            'give "utf-8", "latin-1", "cp1252", "utf-16" or "utf-32"',
        ) from None


class LogText(io.RawIOBase):
    """A text log opened for reading: header lines first by `next_line`, then the data by `read` or `lines`.

    Parameters
    ----------
    path : the file; one that begins like a gzip, bzip2, xz or zstd file is unpacked on the way.
    encoding : of the file, None: by its first bytes; everything comes out as UTF-8, or as it is where `decode` is False
        and the encoding agrees with ASCII.
    display_name : the file's name in messages.

    Attributes
    ----------
    ends_at_gap : take a line that holds nothing for the end, once lines pass through `rewrite_lines`.
    keep_empty_lines : hand empty lines between data lines on (in a log of one column an empty line is an empty cell).
    line_number : number of the last line taken, from 1.
    n_lines : data lines that `read` has handed out.
    not_yet_decoded : True where bytes are handed out undecoded.
    unfinished : True once the end was reached and the last line had no line end.
    tail : the last bytes that `read` has handed out.
    stray_quote : what a quotation mark inside a cell looks like; the parser drops it without a word.
    suspect : True once `read` came across that.
    """

    def __init__(self, path: Path, encoding: str | None, display_name: str, decode: bool = True) -> None:
        super().__init__()
        self._reading = Lock()
        self._abandoned = False
        self.display_name = display_name
        self.keep_empty_lines = self.ends_at_gap = False
        self.line_number = self.n_lines = 0
        self.unfinished = False
        self.tail = b""
        self.stray_quote: re.Pattern[bytes] | None = None
        self.suspect = False
        self._file, self._bytes = _open_bytes(path, display_name)
        self._packed = self._file is not self._bytes
        self._size = os.fstat(self._bytes.fileno()).st_size
        self._buffer = self._held = self._first = self._unwritten = b""
        self._rewrite: Callable[[bytes], bytes] | None = None
        self._ended = self._started = self._closed_off = self._ended_line = False
        self._ends = self._taken = 0
        self._decoder: codecs.IncrementalDecoder | None = None
        try:
            if encoding is None:
                self._first = self._raw(FIRST_BYTES)
                encoding = encoding_of(self._first)
            self.encoding = find_codec(encoding, display_name)
            self.not_yet_decoded = self.encoding == "utf-8" or (self.encoding in PLAIN and not decode)
            self._decoder = None if self.not_yet_decoded else codecs.getincrementaldecoder(encoding)("strict")
            while len(self._buffer) < 3 and self._pull():
                pass
        except BaseException:
            self.close()
            raise
        self._buffer = self._buffer.removeprefix(codecs.BOM_UTF8)

    def readable(self) -> bool:
        """Return True."""
        return True

    def close(self) -> None:
        """Close the file."""
        if not self.closed:
            self._file.close()
            self._bytes.close()
        super().close()

    def next_line(self) -> bytes | None:
        """Return the next line without its end, or None at the end of the file; empty lines are returned too."""
        looked_through = 0
        while (end := self._buffer.find(b"\n", looked_through)) < 0:
            looked_through = len(self._buffer)
            LINE.check(looked_through, self.display_name, f"line {self.line_number + 1}")
            if not self._pull():
                break
        if end < 0 and not self._buffer:
            return None
        line, end_mark, self._buffer = self._buffer.partition(b"\n")
        self._ended_line = bool(end_mark)
        self.line_number += 1
        return line

    def peek(self, size: int, skip: int = 0) -> bytes:
        """Return about the first `size` bytes as whole lines, without taking them; `skip` lines and one more at least.

        A last line without an end is left out: it may have been cut off, unless it is the only one.
        """
        while (len(self._buffer) < size or self._buffer.count(b"\n") <= skip) and self._pull():
            LINE.check(len(self._buffer) - self._buffer.rfind(b"\n"), self.display_name, "the first lines")
        if self._ended and self._buffer.count(b"\n") <= skip:
            return self._buffer
        start = 0
        for _ in range(skip + 1):
            start = self._buffer.find(b"\n", start) + 1
        end = self._buffer.rfind(b"\n", start - 1, max(size, start))
        return self._buffer[:end]

    def rewrite_lines(self, rewrite: Callable[[bytes], bytes]) -> None:
        """Let whole lines pass through `rewrite`, from where the text stands on; it keeps their number."""
        self._rewrite = rewrite
        self._unwritten, self._buffer = self._buffer, b""
        self._take_whole_lines()

    def find_line(self, pattern: re.Pattern[bytes]) -> bool:
        """Take the lines before the next one that a pattern finds; False where there is none."""
        while True:
            end = len(self._buffer) if self._ended else self._buffer.rfind(b"\n") + 1
            found = pattern.search(self._buffer, 0, end)
            before = end if found is None else found.start()
            self.line_number += self._buffer.count(b"\n", 0, before)
            self._buffer = self._buffer[before:]
            if found is not None:
                return True
            LINE.check(len(self._buffer), self.display_name, f"line {self.line_number + 1}")
            if not self._pull(CHUNK):
                return False

    def lines(self) -> Iterator[bytes]:
        """Yield the remaining lines, empty ones included, `line_number` following; to find a place, not to parse."""
        rest = b""
        while self._buffer or self._pull(CHUNK):
            *complete, rest = (rest + self._buffer).split(b"\n")
            self._buffer = b""
            LINE.check(len(rest), self.display_name, f"line {self.line_number + len(complete) + 1}")
            for line in complete:
                self.line_number += 1
                yield line
        self.unfinished = bool(rest)
        if rest:
            self.line_number += 1
            yield rest

    def read(self, size: int = -1) -> bytes:
        """Return at most `size` bytes of data lines; b"" at the end, or where the reader has been abandoned."""
        with self._reading:
            return b"" if self._abandoned else self._read(size)

    def abandon(self) -> None:
        """Let no `read` go on: the parser reads ahead in a thread, in which Python must not be when it ends."""
        self._abandoned = True
        with self._reading:
            pass

    def _read(self, size: int) -> bytes:
        size = CHUNK if size < 0 else max(size, 8)
        pieces: list[bytes] = []
        room = size
        # Short answers would cut a line into more than two blocks, which the parser refuses.
        while room > size // 2 and (self._buffer or self._pull(room)):
            chunk, self._buffer = self._buffer[: room - 2], self._buffer[room - 2 :]
            if data := self._whole_lines(chunk):
                pieces.append(data)
                room -= len(data)
        if self._ended and not self._buffer and self._started and not self._closed_off:
            # Together with the last data: alone it could come as the third block of one line.
            self._closed_off = True
            self.unfinished = self._ends == 0
            self.n_lines += self.unfinished
            pieces += [b"\n"] * bool(self._ends)
        data = pieces[0] if len(pieces) == 1 else b"".join(pieces)
        self.n_lines += data.count(b"\n")
        before = self.tail[-8:]
        quoted = b'"' in data or b'"' in before
        if quoted and self.stray_quote is not None and self.stray_quote.search(before + data):
            self.suspect = True
        self.tail = data[-TAIL:] if len(data) >= TAIL else (self.tail + data)[-TAIL:]
        return data

    def _whole_lines(self, chunk: bytes) -> bytes:
        """Drop empty lines; line ends at the chunk's end are held back until data follows them."""
        body = chunk.rstrip(b"\n")
        ends = len(chunk) - len(body)
        if not body:
            self._ends += ends
            return b""
        before, self._ends = self._ends, ends
        if self.keep_empty_lines:
            # Two line ends in a row are one empty cell already, and that is a fault however many there are.
            before = min(before, 2)
        else:
            bare = body.lstrip(b"\n")
            before = min(before + len(body) - len(bare), 1) if self._started else 0
            body = re.sub(rb"\n\n+", b"\n", bare) if b"\n\n" in bare else bare
        self._started = True
        return b"\n" * before + body if before else body

    def _pull(self, size: int = 1 << 16) -> bool:
        """Take one more chunk into the buffer, decoded, with one kind of line end; False at the end."""
        while not self._ended:
            raw = self._held + self._decoded(size)
            self._held = b""
            if b"\r" in raw:
                if raw.endswith(b"\r") and not self._ended:
                    raw, self._held = raw[:-1], b"\r"
                raw = raw.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
            if self._rewrite is not None:
                self._unwritten += raw
                if self._take_whole_lines():
                    return True
            elif raw:
                self._buffer += raw
                return True
        return False

    def _take_whole_lines(self) -> bool:
        """Hand on the whole lines that are there, rewritten; at the end of the file also what is left."""
        assert self._rewrite is not None
        end = len(self._unwritten) if self._ended else self._unwritten.rfind(b"\n") + 1
        LINE.check(len(self._unwritten) - end, self.display_name, "a line")
        lines, self._unwritten = self._unwritten[:end], self._unwritten[end:]
        if self.ends_at_gap and (gap := GAP_LINE.search(lines)) is not None:
            lines, self._unwritten, self._ended = lines[: gap.start()], b"", True
        self._buffer += self._rewrite(lines)
        return bool(lines)

    def _raw(self, size: int) -> bytes:
        """Return the next bytes of the file, unpacked."""
        if self._first:
            raw, self._first = self._first[:size], self._first[size:]
            return raw
        try:
            return self._file.read(size)
        except UNPACKING_ERRORS as error:
            if not self._packed:
                raise
            reason = f"the compressed file is damaged or cut off ({error})"
            raise InputError.at(
                FaultCode.FILE_DAMAGED, self.display_name, "", reason, "copy it again from its origin"
            ) from None

    def _decoded(self, size: int) -> bytes:
        raw = self._raw(size)
        self._ended = not raw
        self._taken += len(raw)
        if self._packed:
            check_unpacked(self._taken, self._size, self.display_name)
        if self._decoder is None:
            return raw
        try:
            return self._decoder.decode(raw, final=self._ended).encode("utf-8")
        except UnicodeError as error:
            place = f"byte {self._taken - len(raw) + getattr(error, 'start', 0) + 1}"
            if self._ended and getattr(error, "end", -1) == len(getattr(error, "object", b"")):
                reason = f"the file is cut off in the middle of a character ({self.encoding})"
                mend = "log again, or copy the file again from its origin"
                raise InputError.at(FaultCode.FILE_INCOMPLETE, self.display_name, place, reason, mend) from None
            reason = f"the bytes are not {self.encoding} ({getattr(error, 'reason', error)})"
            raise InputError.at(
                FaultCode.ENCODING_WRONG,
                self.display_name,
                place,
                reason,
                "set csv.encoding to the encoding of the file",
            ) from None


def _open_bytes(path: Path, display_name: str) -> tuple[IO[bytes], IO[bytes]]:
    """Return the bytes of the log, and of the file itself, which are others where it is packed."""
    try:
        file = open_regular(path, display_name, buffering=0)
        return unpacked_stream(file), file
    except OSError as error:
        raise InputError.at(
            FaultCode.FILE_UNREADABLE,
            display_name,
            "",
            f"cannot be read: {error.strerror}",
            "correct the file's name or rights",
        ) from None
