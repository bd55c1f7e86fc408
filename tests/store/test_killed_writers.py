"""Writers killed at any moment, and two at once: the store holds the old generation or the new one, never a mix."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import pytest

from stiffcal.errors import InputError
from stiffcal.store import Store

# Forks a writer for every line it reads: one process to start instead of a hundred.
WRITERS = """
import os, sys
import numpy as np
from stiffcal.store import Store

# A killed process leaves what it wrote to the system; flushing to the disk matters for power cuts and only takes time.
os.fsync = lambda descriptor: None

def say(word, number):
    # In one piece, which a pipe keeps together: several processes write to it, and some are killed meanwhile.
    os.write(1, f"{word} {number}\\n".encode())

def write(start):
    store = Store(sys.argv[1])
    for value in range(start, start + 1000):
        with store.begin("ingest") as writing:
            stream = writing.stream("recordings/ft", ["Fx"])
            for _ in range(4):
                stream.append({"Fx": np.full(500, float(value))})
            writing.write_table("states", {"value": np.full(3, value)})
            writing.write_document("fit", {"value": value})
            writing.commit()
            say("committed", value)

write_start = 0
for line in sys.stdin:
    child = os.fork()
    if child == 0:
        write(int(line))
        os._exit(0)
    say("started", child)
"""

LONGEST = 120.0  # s
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="SIGKILL and fork are of POSIX")


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    """Return a store in memory where the system has a folder for that: a busy disk would stretch this to minutes."""
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=memory if os.access(memory, os.W_OK) else tmp_path) as folder:
        yield Store(Path(folder) / "store", display_name="store")


@pytest.fixture
def writers(store: Store) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-W", "ignore", "-c", WRITERS, str(store.folder)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        # Whatever is lost between two processes ends the test, and does not hold it up.
        watch = threading.Timer(LONGEST, process.kill)
        watch.start()
        yield process
        watch.cancel()
        assert process.stdin is not None
        process.stdin.close()


def start(process: subprocess.Popen[str], value: int) -> int:
    assert process.stdin is not None
    process.stdin.write(f"{value}\n")
    process.stdin.flush()
    return int(wait_for(process.stdout, "started"))


def wait_for(lines: IO[str] | None, word: str) -> str:
    assert lines is not None
    for line in lines:
        # What a killed writer had begun to print may stand before it on the same line.
        if word in line:
            return line.split(word)[1].split()[0]
    raise AssertionError(f"never {word}")


def value_of(store: Store) -> int:
    with store.snapshot() as snapshot:
        values = {
            *snapshot.read_table("states").column("value").to_pylist(),
            *(int(value) for value in snapshot.read_table("recordings/ft").column("Fx").to_pylist()),
            snapshot.read_document("fit")["value"],
        }
    assert len(values) == 1, f"a mix of generations: {values}"
    return int(values.pop())


@pytest.mark.long
def test_a_hundred_kills(store: Store, writers: subprocess.Popen[str]) -> None:
    chance = random.Random(2)
    seen: set[int] = set()
    first = later = 0.0
    for attempt in range(100):
        child = start(writers, attempt * 1000)
        if attempt % 2 == 0:
            began = time.monotonic()
            wait_for(writers.stdout, "committed")
            first = min(time.monotonic() - began, 0.1)
            wait_for(writers.stdout, "committed")
            later = min(time.monotonic() - began - first, 0.1)
        # In its later generations, or in the first, which clears up after the writer killed before it.
        time.sleep(chance.uniform(0, 2 * later if attempt % 2 == 0 else 1.5 * first))
        os.kill(child, signal.SIGKILL)
        seen.add(value_of(store))
    assert len(seen) > 20, "the kills came too early to test anything"
    with store.begin("identify") as writing:
        writing.keep_rest()
        writing.commit()
    assert len(list((store.folder / "generations").iterdir())) == 1


def test_readers_next_to_two_writers_never_see_a_mix(store: Store, writers: subprocess.Popen[str]) -> None:
    children = [start(writers, 0), start(writers, 5000)]
    wait_for(writers.stdout, "committed")
    seen: set[int] = set()
    end = time.monotonic() + LONGEST
    while len(seen) < 20 and time.monotonic() < end:
        seen.add(value_of(store))
    for child in children:
        os.kill(child, signal.SIGKILL)
    assert len(seen) > 2


def test_a_second_writer_waits_or_is_reported_who_writes(store: Store) -> None:
    with store.begin("ingest") as writing:
        with (
            pytest.raises(InputError, match=rf"store: another stiffcal \(ingest, process {os.getpid()}\) is writing"),
            store.begin("identify", wait_s=0.1),
        ):
            pass
        writing.write_document("fit", {"value": 1})
        writing.commit()
    assert store.read_document("fit") == {"value": 1}
