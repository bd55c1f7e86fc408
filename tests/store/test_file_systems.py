"""On which file systems a change shows in a file's times, and that it is so on this one."""

from __future__ import annotations

import mmap
import sys
import time
from pathlib import Path

import pytest

from stiffcal.store.file_systems import shows_mapped_writes, write_back


@pytest.mark.skipif(sys.platform != "linux", reason="the table of mounts is Linux's")
@pytest.mark.parametrize("place", ["/dev/shm", "/proc/self"])
def test_file_systems_in_memory_are_not_relied_on(place: str) -> None:
    assert not shows_mapped_writes(Path(place))


def test_a_mapped_write_moves_the_time_after_the_pages_were_written_back(tmp_path: Path) -> None:
    """What the list of file systems states, tried where this folder is."""
    if not shows_mapped_writes(tmp_path):
        pytest.skip("this file system is not relied on")
    path = tmp_path / "log.csv"
    path.write_bytes(b"0" * 8192)
    with path.open("r+b") as file, mmap.mmap(file.fileno(), 0) as mapped:
        mapped[0] = 1
        assert write_back(path)
        before = path.stat().st_mtime_ns
        while time.time_ns() < before + 20_000_000:  # clocks of file systems tick every 10 ms or faster
            pass
        mapped[0] = 2
        assert path.stat().st_mtime_ns > before


def test_what_cannot_be_written_back_is_not_settled(tmp_path: Path) -> None:
    assert not write_back(tmp_path / "nothing")
    assert not write_back(tmp_path)
