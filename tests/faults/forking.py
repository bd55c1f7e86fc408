"""Runs commands in forks of a process that has imported everything: a try costs what the command itself costs.

    python -m tests.faults.forking

reads one JSON object a line (words, environment, fault, out, err, events, patience) and answers each with its exit
code (a negative one: the signal that ended it; null: it hung) and the seconds it took.
"""

from __future__ import annotations

import fcntl
import json
import os
import random
import signal
import subprocess
import sys
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.faults import injection

IMPORTED = (
    "stiffcal.cli.app", "stiffcal.commands.run", "stiffcal.commands.improve", "stiffcal.commands.export",
    "stiffcal.commands.plot", "stiffcal.commands.predict", "stiffcal.commands.simulate", "stiffcal.commands.init",
    "stiffcal.batch.campaigns", "stiffcal.model.editing", "stiffcal.ingest.reading.reducing",
    "stiffcal.report.gathering.content", "stiffcal.report.effect_pictures.drawing", "stiffcal.report.building",
    "stiffcal.simulation.simulate", "stiffcal.judgement.states", "stiffcal.validation.validate",
    "stiffcal.identification.fitting.identify", "stiffcal.propose.from_table", "stiffcal.propose.templates",
    "matplotlib.backends.backend_svg", "matplotlib.figure", "pyarrow.csv", "pyarrow.parquet", "typst", "h5py",
    "rich.console", "rich.table", "rich.progress", "stiffcal.stages.diagnoses.stored_curves",
    "stiffcal.identification.answers.state_tables",
)  # fmt: skip


class Forker:
    """The process that forks. Made by `forker`."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def run(self, **request: Any) -> dict[str, Any]:
        """Run a command with a fault; its answer."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        answer: dict[str, Any] = json.loads(self._process.stdout.readline())
        return answer


@contextmanager
def forker() -> Iterator[Forker]:
    """Start one; it ends with this context."""
    command = [sys.executable, "-m", "tests.faults.forking"]
    root = Path(__file__).parents[2]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=root) as process:
        yield Forker(process)
        assert process.stdin is not None
        process.stdin.close()


def main() -> None:
    import importlib

    import stiffcal  # noqa: F401  (one BLAS thread, before numpy)

    for name in IMPORTED:
        importlib.import_module(name)
    from stiffcal.model.catalogue.catalogue import find_effects

    find_effects()
    answers = os.fdopen(os.dup(1), "w")
    for line in sys.stdin:
        request = json.loads(line)
        began = time.monotonic()
        # Through pipes: a limit on the size of files holds for files.
        pipes = [_pipe() for _ in range(2)]
        child = os.fork()
        if child == 0:
            _child(request, [writing for _, writing in pipes])
        code = _wait(child, request["patience"])
        for name, (reading, writing) in zip(("out", "err"), pipes, strict=True):
            os.close(writing)
            Path(request[name]).write_bytes(_all_of(reading))
        answers.write(json.dumps({"code": code, "seconds": time.monotonic() - began}) + "\n")
        answers.flush()


def _pipe() -> tuple[int, int]:
    reading, writing = os.pipe()
    fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, 1 << 20)
    os.set_blocking(reading, False)
    return reading, writing


def _all_of(reading: int) -> bytes:
    try:
        return os.read(reading, 1 << 20)
    except BlockingIOError:
        return b""
    finally:
        os.close(reading)


def _wait(child: int, patience: float) -> int | None:
    end = time.monotonic() + patience
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def _child(request: dict[str, Any], outputs: list[int]) -> None:
    """Run the command in this fork and end; never returns."""
    code, watch = 70, None
    try:
        os.setpgid(0, 0)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        with open(os.devnull, "rb") as nothing:  # noqa: PTH123
            os.dup2(nothing.fileno(), 0)
        for descriptor, writing in zip((1, 2), outputs, strict=True):
            os.dup2(writing, descriptor)
        sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
        sys.stderr = os.fdopen(2, "w", encoding="utf-8", closefd=False)
        from stiffcal.cli.app import main as stiffcal

        os.environ.update(request["environment"])
        watch = _prepare(request["fault"])
        try:
            stiffcal(request["words"])
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 70
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except BaseException:
        os.write(2, traceback.format_exc().encode())
    finally:
        if watch is not None and request["fault"]["kind"] == "none":
            Path(request["events"]).write_text(f"{watch.changes} {watch.count}")
        os._exit(code)


def _prepare(fault: dict[str, Any]) -> injection.Watch | None:
    kind = fault["kind"]
    if kind == "none":
        return injection.counted(fault["folder"])
    if kind in ("killed", "interrupted", "terminated"):
        how = {"killed": signal.SIGKILL, "interrupted": signal.SIGINT, "terminated": signal.SIGTERM}[kind]
        if "after" in fault:
            injection.later(fault["after"], lambda: os.kill(os.getpid(), how))
            return None
        return injection.killed(fault["folder"], fault["at"], how)
    if kind == "killed in time":
        injection.killed_after(fault["after"])
    elif kind == "a process killed":
        injection.later(fault["after"], lambda: injection.kill_a_child(random.Random(fault["seed"])))
    elif kind == "disk full":
        return injection.full(fault["folder"], fault["at"])
    elif kind == "files cut":
        injection.cut_writes(fault["size"])
    elif kind == "right revoked":
        return injection.revoked(fault["folder"], fault["at"], fault["target"], fault["mode"])
    elif kind == "file truncated":
        return injection.truncated(fault["folder"], fault["at"], fault["target"], fault["share"])
    elif kind != "disk really full":
        raise ValueError(kind)
    return None


if __name__ == "__main__":
    main()
