"""A file that is hashed while it is written: a table of gigabytes is not read again for its SHA-256."""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import Any


class HashedFile(io.RawIOBase):
    """A new file that is hashed while it is written.

    Attributes
    ----------
    size : bytes so far. digest : their SHA-256.
    """

    def __init__(self, path: Path) -> None:
        self.size = 0
        self.digest = hashlib.sha256()
        self._file = path.open("xb")

    def write(self, content: Any) -> int:
        """Append bytes."""
        piece = memoryview(content)
        self._file.write(piece)
        self.digest.update(piece)
        self.size += piece.nbytes
        return piece.nbytes

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self.size

    def writable(self) -> bool:
        """Return True."""
        return True

    def flush(self) -> None:
        """Hand what was written to the system."""
        if not self._file.closed:
            self._file.flush()

    def fileno(self) -> int:
        """Return the file's descriptor."""
        return self._file.fileno()

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()
