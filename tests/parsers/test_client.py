"""Logs parsed in a child process: rows as they are, in step, in flat memory; what becomes of a parser that fails."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import h5py
import numpy as np
import pytest

from stiffcal.bounded_work.client import CHILDREN
from stiffcal.bounded_work.messages import fault_message, faults_of, parts_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.parsers.client import ParsedFile
from stiffcal.parsers.messages import batch_message, batch_of
from stiffcal.parsers.open_log import OpenLog
from stiffcal.processes import ChildProcess
from stiffcal.readers import Batch, WantedColumns

ROWS = 5 * OpenLog.BATCH_ROWS
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="signals are another matter there")
TWO = WantedColumns(("t", "Fx"))


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> ParsedFile:
    path = tmp_path_factory.mktemp("log") / "log.h5"
    with h5py.File(path, "w") as file:
        file["t"], file["Fx"] = np.arange(ROWS) * 0.5, -np.arange(ROWS, dtype=np.int32)
    return ParsedFile("hdf5", path, {}, "raw/log.h5")


def waiting() -> list[ChildProcess]:
    """Return the processes that wait, in the order in which they are taken."""
    return [child for _, child in reversed(CHILDREN._waiting)]


def test_rows_come_as_they_are(log: ParsedFile) -> None:
    header = log.header(None)
    assert (set(header.columns), header.n_rows) == ({"t", "Fx"}, ROWS)
    batches = list(log.batches(TWO))
    assert [batch.first_row for batch in batches] == [1 + k * OpenLog.BATCH_ROWS for k in range(5)]
    assert np.array_equal(np.concatenate([batch.numbers["Fx"] for batch in batches]), -np.arange(ROWS))
    batches[0].numbers["t"][0] = 1.0  # it is the caller's


def test_numbers_words_and_faults_travel_unchanged() -> None:
    batch = Batch(
        7,
        {"t": np.array([0.1, np.nan, -0.0]), "Fx": np.arange(3.0)},
        {"run": ["ä\n", "b", "ä\n"], "w": ["", "\udc80", "x"]},
    )
    found = batch_of(*parts_of(batch_message(batch)))
    assert (found.first_row, len(found), found.texts) == (7, 3, batch.texts)
    assert all(np.array_equal(found.numbers[name], batch.numbers[name], equal_nan=True) for name in ("t", "Fx"))
    assert len(batch_of(*parts_of(batch_message(Batch(1, {}, {"run": ["x"] * 9}))))) == 9
    error = InputError.at(FaultCode.CELL_EMPTY, "raw/log.h5", "row 3", "empty", "fill it in")
    assert faults_of(parts_of(fault_message(error))[0]).faults == error.faults


def test_logs_are_read_in_step_and_the_processes_serve_again(log: ParsedFile) -> None:
    for one, other in zip(log.batches(TWO), log.batches(TWO), strict=True):
        assert np.array_equal(one.numbers["t"], other.numbers["t"])
    before = {child.pid for child in waiting()}
    log.header(None)
    assert {child.pid for child in waiting()} == before


def test_a_log_that_is_not_read_to_its_end_leaves_nothing_behind(log: ParsedFile) -> None:
    log.header(None)
    child = waiting()[0]
    batches = log.batches(TWO)
    next(batches)
    batches.close()  # type: ignore[attr-defined]
    assert child.has_ended
    assert log.header(None).n_rows == ROWS


def test_threads_read_at_once_and_leave_processes_for_others(log: ParsedFile) -> None:
    found: list[int | None] = []
    threads = [threading.Thread(target=lambda: found.append(log.header(None).n_rows)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [ROWS, ROWS]
    assert log.header(None).n_rows == ROWS


@POSIX
def test_a_process_that_ended_while_it_waited_is_replaced(log: ParsedFile) -> None:
    log.header(None)
    for child in waiting():
        os.kill(child.pid, signal.SIGKILL)
        while not child.has_ended:
            pass
    assert log.header(None).n_rows == ROWS


@POSIX
@pytest.mark.parametrize(
    ("ended_by", "code"),
    [("SIGSEGV", FaultCode.FILE_DAMAGED), ("SIGXCPU", FaultCode.SIZE_EXCEEDED), ("SIGKILL", FaultCode.SIZE_EXCEEDED)],
)
def test_a_process_that_is_lost_over_a_log_is_a_fault_of_it(log: ParsedFile, ended_by: str, code: FaultCode) -> None:
    """As a library's own fault ends it, the limit of time, or a system that runs out of memory."""
    log.header(None)
    idle = waiting()
    batches = log.batches(TWO)
    next(batches)
    (child,) = (one for one in idle if one not in waiting())
    os.kill(child.pid, getattr(signal, ended_by))
    with pytest.raises(InputError) as refused:
        list(batches)
    assert (refused.value.code, refused.value.file) == (code, "raw/log.h5")


MEMORY = """
import resource, sys
from pathlib import Path
from stiffcal.parsers.client import ParsedFile
from stiffcal.readers import WantedColumns
file = ParsedFile("hdf5", Path(sys.argv[1]), {}, "log.h5")
file.header(None)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
assert sum(len(batch) for batch in file.batches(WantedColumns(("t", "Fx")))) == int(sys.argv[2])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="kilobytes there alone")
def test_a_long_log_takes_no_more_memory_than_some_batches(tmp_path: Path) -> None:
    rows = 6_000_000
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["t"], file["Fx"] = np.arange(rows, dtype=float), np.zeros(rows)
    words = [sys.executable, "-c", MEMORY, str(tmp_path / "log.h5"), str(rows)]
    grown = int(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    assert grown < 30_000  # kB; the rows are 96 MB, a batch 1 MB, of which some are on the way


def test_no_module_of_the_current_folder_is_taken(log: ParsedFile, tmp_path: Path) -> None:
    for name in ("h5py", "numpy", "json", "tempfile", "resource"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\nraise ImportError\n")
    code = (
        "import sys; from pathlib import Path; from stiffcal.module_path import leave_out_current_folder as leave\n"
        "from stiffcal.parsers.client import ParsedFile; import os; os.chdir(sys.argv[2]); sys.path.insert(0, '')\n"
        "print(ParsedFile('hdf5', Path(sys.argv[1]), {}, 'x').header(None).n_rows)\n"
    )
    end = subprocess.run([sys.executable, "-c", code, log.path, tmp_path], capture_output=True, text=True, check=False)
    assert end.stdout.strip() == str(ROWS), end.stderr
    assert not (tmp_path / "ran").exists()
