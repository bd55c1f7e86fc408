"""Child processes: messages, how they end, and that they end with the process that started them."""

from __future__ import annotations

import ast
import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator

import pytest

from stiffcal.processes import Channel, ChildEndedError, ChildProcess, ChildSilentError
from tests.laboratory import children

LONG_S = 120.0  # on a machine with many times as much to do as it can
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="signals are another matter there")
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="the system offers it on Linux only")
PARENT = """
import sys
from stiffcal.processes import ChildProcess
from tests.laboratory import children
child = ChildProcess(getattr(children, sys.argv[1]))
print(child.receive(100.0).decode(), flush=True)
child.receive(1000.0)
"""


@pytest.fixture
def started() -> Iterator[Callable[..., ChildProcess]]:
    """Return a function that starts a child; all are stopped at the end."""
    made: list[ChildProcess] = []

    def start(function: Callable[[Channel], None], **limits: int) -> ChildProcess:
        made.append(ChildProcess(function, **limits))
        return made[-1]

    yield start
    for child in made:
        child.stop()


def test_messages_of_any_size_come_back_in_their_order(started: Callable[..., ChildProcess]) -> None:
    child = started(children.answer_everything)
    for message in (b"", b"\n\0", bytes(range(256)) * 20_000):
        child.send(message)
        assert child.receive(LONG_S) == message


def test_what_a_child_prints_or_reads_is_no_message(started: Callable[..., ChildProcess]) -> None:
    child = started(children.print_and_answer)
    child.send(b"answer")
    assert child.receive(LONG_S) == b"answer"


def test_how_a_child_ended_is_reported_with_its_last_words(started: Callable[..., ChildProcess]) -> None:
    child = started(children.end)
    child.send(b"")
    with pytest.raises(ChildEndedError, match="ended with code 3: last words$"):
        child.receive(LONG_S)


def test_a_fault_of_the_function_is_the_last_word(started: Callable[..., ChildProcess]) -> None:
    with pytest.raises(ChildEndedError, match="ended with code 1: TypeError"):
        started(ast.parse).receive(LONG_S)


@POSIX
def test_an_end_is_noticed_though_another_process_holds_the_pipes(started: Callable[..., ChildProcess]) -> None:
    child = started(children.leave_a_process_behind)
    child.send(b"")
    with pytest.raises(ChildEndedError, match="ended with code 4"):
        child.receive(LONG_S)


@POSIX
@pytest.mark.parametrize("function", [children.wait, children.stop_itself, children.compute])
def test_a_silent_child_is_given_up_and_killed(
    function: Callable[[Channel], None], started: Callable[..., ChildProcess], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stiffcal.processes.STOP_S", 0.2)
    child = started(function)
    assert int(child.receive(LONG_S)) == child.pid
    with pytest.raises(ChildSilentError):
        child.receive(0.1)
    child.stop()
    with pytest.raises(ProcessLookupError):
        os.kill(child.pid, 0)


@LINUX
@pytest.mark.parametrize("function", ["wait", "compute", "stop_itself"])
def test_a_child_ends_with_its_parent_whatever_it_does(function: str) -> None:
    """The parent is killed, and can do nothing about it; the child ignores SIGTERM, computes or stands still."""
    with subprocess.Popen([sys.executable, "-c", PARENT, function], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        child = os.pidfd_open(int(parent.stdout.readline()))
        parent.kill()
        ended, _, _ = select.select([child], [], [], LONG_S)
        os.close(child)
        assert ended


def test_a_child_outlasts_the_thread_that_made_it(started: Callable[..., ChildProcess]) -> None:
    """Linux can only be asked to end a process with the thread that started it."""
    made: list[ChildProcess] = []

    def make() -> None:
        made.append(started(children.answer_everything))
        made[0].send(b"1")
        made[0].receive(LONG_S)

    thread = threading.Thread(target=make)
    thread.start()
    thread.join()
    made[0].send(b"2")
    assert made[0].receive(LONG_S) == b"2"


@LINUX
def test_an_idle_child_ends_when_the_pipe_from_its_parent_does(started: Callable[..., ChildProcess]) -> None:
    """What holds on every system: nothing but the pipe shows the end of the parent here."""
    child = started(children.answer_everything)
    child.send(b"")
    child.receive(LONG_S)
    assert child._process.stdin is not None
    child._process.stdin.close()
    with pytest.raises(ChildEndedError, match="ended with code 0"):
        child.receive(LONG_S)


@LINUX
def test_a_child_may_hold_so_much_and_no_more(started: Callable[..., ChildProcess]) -> None:
    assert started(children.take_memory, memory_bytes=200_000_000).receive(LONG_S) == b"refused"
    assert started(children.take_memory, memory_bytes=600_000_000).receive(LONG_S) == b"300000000"


@POSIX
def test_a_child_may_compute_so_long_and_no_longer(started: Callable[..., ChildProcess]) -> None:
    with pytest.raises(ChildEndedError, match=f"signal ({signal.SIGKILL:d}|{signal.SIGXCPU:d})"):
        started(children.burn, processor_s=1).receive(LONG_S)


def test_messages_that_nobody_takes_leave_no_thread_behind(started: Callable[..., ChildProcess]) -> None:
    before = threading.active_count()
    child = started(children.send_without_end)
    assert len(child.receive(LONG_S)) == 1 << 20
    child.stop()
    assert threading.active_count() <= before + 1  # one may be about to end
