"""How far a log is: absent, growing, cut in a line, settled, quiet; by clocks of the test's own, without waiting."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from stiffcal.live.log_files import QUIET_S, SETTLED_S, LogFiles, Stage

FILE = "raw/a.csv"


class Bench:
    """A folder with one log, and a clock that is set."""

    def __init__(self, folder: Path) -> None:
        (folder / "raw").mkdir()
        self.path, self.now = folder / FILE, 1000.0
        self.logs = LogFiles(folder, lambda: self.now, lambda: self.now)

    def write(self, text: str) -> None:
        """Append, at the time of the clock."""
        with self.path.open("a", encoding="utf-8", newline="") as file:
            file.write(text)
        os.utime(self.path, (self.now, self.now))

    def stage(self, later: float = 0.0, is_text: bool = True) -> Stage:
        self.now += later
        return self.logs.look([(FILE, is_text)])[FILE].stage


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


def test_a_log_from_its_first_line_to_its_end(bench: Bench) -> None:
    assert bench.stage() is Stage.ABSENT
    bench.path.touch()
    assert bench.stage() is Stage.ABSENT  # nothing is in it yet
    bench.write("t,Fx\n0,1\n")
    assert bench.stage() is Stage.GROWING
    assert bench.stage(0.9 * SETTLED_S) is Stage.GROWING
    bench.write("1,2\n")
    assert bench.stage(0.2 * SETTLED_S) is Stage.GROWING
    assert bench.stage(SETTLED_S) is Stage.SETTLED
    assert bench.stage(QUIET_S) is Stage.QUIET
    bench.write("2,3\n")
    assert bench.stage() is Stage.GROWING


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_line_that_is_cut_is_waited_for(bench: Bench, end: str) -> None:
    bench.write(f"t,Fx{end}0,1")
    bench.stage()
    assert bench.stage(2.0 * SETTLED_S) is Stage.CUT
    bench.write(f"5{end}")
    bench.stage()
    assert bench.stage(2.0 * SETTLED_S) is Stage.SETTLED


def test_a_logger_that_ends_no_last_line_is_read_once_it_is_quiet(bench: Bench) -> None:
    bench.write("t,Fx\n0,1")
    bench.stage()
    assert bench.stage(QUIET_S) is Stage.QUIET
    assert bench.logs.look([(FILE, True)])[FILE].cut


def test_a_log_that_was_there_before_is_read_at_once_and_binary_ones_have_no_lines(bench: Bench) -> None:
    bench.write("t,Fx\n0,1\n")
    assert bench.stage(2.0 * QUIET_S) is Stage.QUIET
    bench.write("\x00\x01")
    bench.stage()
    assert bench.stage(2.0 * SETTLED_S, is_text=False) is Stage.SETTLED


def test_utf_16_ends_its_lines_too(bench: Bench) -> None:
    bench.path.write_bytes("t;Fx\n0;1\n".encode("utf-16"))
    os.utime(bench.path, (bench.now, bench.now))
    bench.stage()
    assert bench.stage(2.0 * SETTLED_S) is Stage.SETTLED


def test_what_is_no_file_of_the_campaign_is_not_opened(bench: Bench, tmp_path: Path) -> None:
    secret = tmp_path.parent / f"{tmp_path.name}-secret"
    secret.write_text("t,Fx\n")
    bench.path.symlink_to(secret)
    assert bench.stage(2.0 * QUIET_S) is Stage.ABSENT
    bench.path.unlink()
    os.mkfifo(bench.path)
    assert bench.stage() is Stage.ABSENT
