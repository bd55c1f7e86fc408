"""The child process that exchanges objects with an object store through Arrow's library.

The library holds an answer whole before it reads it, and its time limits are those of waiting without any answer.
Whoever runs the endpoint, or can change what it sends, decides how long an answer is. So the system bounds this
process's memory, and the process that asks bounds its time.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Generator, Mapping
from pathlib import Path

from stiffcal.processes import IDLE_S, Channel

MORE, DONE, ABSENT, LONGER, REFUSED = "more", "done", "absent", "longer", "refused"
"""Kinds of answers. `MORE` is a sign of life, one of the others the last."""
PIECE = 1 << 20
"""Bytes that are asked for at once at first, where nobody knows how fast the network is."""
_MOST_PIECE = 1 << 24
_QUICK_S = 0.5
_CHUNK = 1 << 22
MOST_NAMES = 10_000
"""Of a folder: a store's have one for each generation or process."""
_MOST_NAME = 300
_MOST_SMALL = 1 << 16
_MOST_TEXT = 2000
_CONNECT_S, _READ_S = 6.0, 60.0


def serve(channel: Channel) -> None:
    """Do what is asked for, until nobody asks any more."""
    # Arrow's file systems do without numpy, whose import takes as long as all else here.
    sys.modules["numpy"] = None  # type: ignore[assignment]
    os.environ["ARROW_DEFAULT_MEMORY_POOL"] = "system"
    objects = None
    for message in channel.requests(IDLE_S):
        request = json.loads(message)
        try:
            if objects is None or objects.access != request["access"]:
                objects = _Objects(request["access"])
            for kind, value in getattr(objects, request["operation"])(*request["values"]):
                channel.send(json.dumps([kind, value]).encode())
        except BrokenPipeError:
            raise
        except FileNotFoundError:
            channel.send(json.dumps([ABSENT, None]).encode())
        except (OSError, ValueError) as error:  # Arrow's own errors are of one of these
            channel.send(json.dumps([REFUSED, str(error)[:_MOST_TEXT]]).encode())


class _Objects:
    """Objects by bucket and key; each operation yields signs of life and its answer."""

    def __init__(self, access: Mapping[str, Mapping[str, str]]) -> None:
        from pyarrow.fs import AwsStandardS3RetryStrategy, S3FileSystem

        self.access = access
        # the user may have changed them since this process was started
        for name in [name for name in os.environ if name.startswith("AWS_")]:
            del os.environ[name]
        os.environ.update(access["environment"])
        retry = AwsStandardS3RetryStrategy(max_attempts=3)
        self._files = S3FileSystem(
            connect_timeout=_CONNECT_S,
            request_timeout=_READ_S,
            retry_strategy=retry,
            # one part of a large object after the other, so that it shows how it goes on
            background_writes=False,
            **access["options"],
        )

    def names(self, folder: str) -> Generator[tuple[str, object], None, None]:
        from pyarrow.fs import FileSelector

        yield MORE, None
        infos = self._files.get_file_info(FileSelector(folder, allow_not_found=True))
        if len(infos) > MOST_NAMES:
            raise ValueError(f"more than {MOST_NAMES} objects in {folder}")
        yield DONE, {info.base_name: info.mtime_ns or 0 for info in infos if len(info.base_name) <= _MOST_NAME}

    def read(self, place: str) -> Generator[tuple[str, object], None, None]:
        yield MORE, None
        with self._files.open_input_stream(place) as source:
            content = source.read(_MOST_SMALL + 1)
        yield (DONE, content.decode("latin-1")) if len(content) <= _MOST_SMALL else (LONGER, None)

    def fetch(self, place: str, path: str, most: int) -> Generator[tuple[str, object], None, None]:
        yield MORE, None
        size, left = PIECE, most
        with self._files.open_input_stream(place) as source, Path(path).open("wb") as target:
            began = time.monotonic()
            while piece := source.read(size):
                left -= len(piece)
                if left < 0:
                    yield LONGER, None
                    return
                target.write(piece)
                size = min(2 * size, _MOST_PIECE) if time.monotonic() - began < _QUICK_S else PIECE
                yield MORE, None
                began = time.monotonic()
        yield DONE, None

    def write(self, place: str, content: str) -> Generator[tuple[str, object], None, None]:
        yield MORE, None
        with self._files.open_output_stream(place) as target:
            target.write(content.encode("latin-1"))
        yield DONE, None

    def send(self, path: str, place: str) -> Generator[tuple[str, object], None, None]:
        yield MORE, None
        with Path(path).open("rb") as source, self._files.open_output_stream(place) as target:
            while piece := source.read(_CHUNK):
                target.write(piece)
                yield MORE, None
        yield DONE, None

    def copy(self, source: str, target: str) -> Generator[tuple[str, object], None, None]:
        yield MORE, None
        self._files.copy_file(source, target)
        yield DONE, None

    def delete(self, place: str) -> Generator[tuple[str, object], None, None]:
        yield MORE, None
        self._files.delete_file(place)
        yield DONE, None

    def remove(self, folder: str) -> Generator[tuple[str, object], None, None]:
        yield MORE, None
        self._files.delete_dir(folder)
        yield DONE, None
