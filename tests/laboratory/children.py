"""What child processes of `tests/test_processes.py` do: functions of a module, as `ChildProcess` takes them."""

from __future__ import annotations

import json
import os
import signal
import sys
import time

from stiffcal.processes import Channel


def answer_everything(channel: Channel) -> None:
    """Send back what comes."""
    for request in channel.requests():
        channel.send(request)


def answer_with_the_campaigns_name(channel: Channel) -> None:
    """Send back what stands where a task has its campaign's name."""
    for request in channel.requests():
        channel.send(str(json.loads(request)["campaign"]).encode())


def print_and_answer(channel: Channel) -> None:
    """Print where answers go, read where requests come from, then answer."""
    os.write(1, b"printed by a library\n")
    print("printed")
    read = sys.stdin.read()
    for request in channel.requests():
        channel.send(request + read.encode())


def end(channel: Channel) -> None:
    """End at the first request, with some last words."""
    for _ in channel.requests():
        os.write(2, b"first words\nlast words\n\n")
        os._exit(3)


def write_much_and_end(channel: Channel) -> None:
    """Write 64 MB to standard error, and be killed."""
    for _ in range(64):
        os.write(2, bytes(1 << 20))
    os.write(2, b"\nno memory is left\n")
    os.kill(os.getpid(), signal.SIGKILL)


def leave_a_process_behind(channel: Channel) -> None:
    """End while a process that this one has started keeps all its pipes open."""
    for _ in channel.requests():
        if os.fork() == 0:
            os.setsid()
            time.sleep(600.0)
        os._exit(4)


def wait(channel: Channel) -> None:
    """Send the process's number, and nothing more for ten minutes, whatever it is asked."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    channel.send(b"%d" % os.getpid())
    time.sleep(600.0)


def compute(channel: Channel) -> None:
    """Send the process's number, and compute for minutes in one call in which nothing else of Python runs."""
    channel.send(b"%d" % os.getpid())
    pow(3, 10**9)


def stop_itself(channel: Channel) -> None:
    """Send the process's number, and have the system stop it."""
    channel.send(b"%d" % os.getpid())
    os.kill(os.getpid(), signal.SIGSTOP)


def take_memory(channel: Channel) -> None:
    """Hold 300 MB, and send what came of it."""
    try:
        held = b"x" * 300_000_000
    except MemoryError:
        channel.send(b"refused")
    else:
        channel.send(b"%d" % len(held))


def burn(channel: Channel) -> None:
    """Compute without end."""
    while True:
        pass


def send_without_end(channel: Channel) -> None:
    """Send a megabyte, again and again."""
    while True:
        channel.send(bytes(1 << 20))
