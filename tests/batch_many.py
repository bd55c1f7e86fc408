"""Many small campaigns with their reports in one batch, some of them broken, killed in the middle and called again.

    python -m tests.batch_many [--campaigns 200] [--jobs 2] [--idle-timeout 20]

One in twenty is broken, in turn in each way of `BROKEN`: files that are wrong, logs that are missing or a pipe, code
that ends its process, stands still or computes without end. When two of five campaigns are done, the batch is killed
with its whole process group, which can do nothing about it. Its processes must end. The same command then does the
rest: every campaign that is not broken holds and has its report, what was done is not done again, every broken one is
named.

Limits: in the second call the peak memory of a process grows by at most 10 % from the second quarter of the campaigns
to the last, and so does the memory of the command itself; not judged below a hundred campaigns, where the first ones
load what all need. Linux only: it looks at processes where that system shows them.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stiffcal.trust.record import open_record
from tests.laboratory.batch_plugins import COMPUTES, KILLED, LEAVES_A_PROCESS, STANDS, WAITS, with_plugin
from tests.laboratory.small_campaign import write_small_campaign

BROKEN_SHARE = 20
"""One of so many is broken."""
MADE = 5
"""Campaigns of different numbers; the others are copies of these."""
MOST_GROWTH, JUDGED_FROM = 1.10, 100
LONGEST_S = 7200.0  # on a machine with ten times as much to do as it can
LINE = re.compile(r"(\d+) of \d+: \S*?/(\S+): ")


def _spoil_robot(folder: Path) -> None:
    (folder / "robot.toml").write_text("name =", encoding="utf-8")


def _spoil_log(folder: Path) -> None:
    (folder / "raw" / "states.csv").write_text("run,A1\na,b\n", encoding="utf-8")


def _lose_log(folder: Path) -> None:
    shutil.rmtree(folder / "raw")


def _pipe_for_log(folder: Path) -> None:
    (folder / "raw" / "states.csv").unlink()
    os.mkfifo(folder / "raw" / "states.csv")


def _plugin(*lines: str) -> Callable[[Path], object]:
    return lambda folder: with_plugin(folder, *lines)


BROKEN: dict[str, tuple[str, Callable[[Path], object]]] = {
    "computes": ("lost", _plugin(COMPUTES)),
    "killed": ("broken", _plugin(KILLED)),
    "robot": ("broken", _spoil_robot),
    "stands": ("lost", _plugin(STANDS)),
    "log": ("broken", _spoil_log),
    "waits": ("lost", _plugin(WAITS)),
    "pipe": ("broken", _pipe_for_log),
    "leaves": ("broken", _plugin(LEAVES_A_PROCESS)),
    "no-log": ("broken", _lose_log),
    "ends": ("broken", _plugin("os._exit(0)\n")),
}
"""How a campaign is broken: the state that it must have, and what is done to its folder."""


def make_campaigns(folder: Path, count: int, n_broken: int) -> dict[str, str]:
    """Write campaigns; return the state that each must have by its name."""
    expected = {}
    kinds = list(BROKEN.items())
    for number in range(count):
        target = folder / f"cell-{number:03d}"
        if number < MADE:
            write_small_campaign(target, seed=number, poses=2)
        else:
            # what is broken now stands at equal distances among the others
            shutil.copytree(folder / f"cell-{number % MADE:03d}", target)
        expected[target.name] = "held"
    for place in range(n_broken):
        kind, (state, spoil) = kinds[place % len(kinds)]
        name = f"cell-{MADE + (count - MADE) * place // n_broken:03d}"
        spoil(folder / name)
        (folder / name).rename(folder / f"{name}-{kind}")
        del expected[name]
        expected[f"{name}-{kind}"] = state
        if (folder / f"{name}-{kind}" / "own.py").exists():
            open_record().allow_folder(folder / f"{name}-{kind}")  # anew: where it lies is part of what is allowed
    return expected


@dataclass
class Call:
    """What one call of the command has shown."""

    order: list[str] = field(default_factory=list)
    """Campaigns in the order in which they ended."""
    own_bytes: list[int] = field(default_factory=list)
    """Memory of the command itself at these times."""
    document: dict[str, Any] = field(default_factory=dict)
    """Its answer; empty where it was killed."""
    seconds: float = 0.0
    """How long it took, s."""


def run_batch(folder: Path, jobs: int, idle_timeout: float, kill_after: int | None = None) -> Call:
    """Run the command; kill it with its group, and see its processes end, once so many campaigns are done."""
    command = [sys.executable, "-P", "-m", "stiffcal", "batch", str(folder), "--jobs", str(jobs)]
    command += ["--idle-timeout", str(idle_timeout), "--json"]
    call, began = Call(), time.perf_counter()
    with (
        tempfile.TemporaryFile("w+") as answer,
        subprocess.Popen(command, stdout=answer, stderr=subprocess.PIPE, text=True, process_group=0) as process,
    ):
        assert process.stderr is not None
        # Whatever goes wrong ends this: the pipe closes, and the reading below with it.
        watch = threading.Timer(LONGEST_S, os.killpg, (process.pid, signal.SIGKILL))
        watch.start()
        for line in process.stderr:
            if (found := LINE.match(line)) is None:
                continue
            call.order.append(found[2])
            call.own_bytes.append(_memory_bytes(process.pid))
            if len(call.order) == kill_after:
                with _children_of(process.pid) as children:
                    os.killpg(process.pid, signal.SIGKILL)
                    _wait_for_the_end_of(children)
                break
        process.wait()
        watch.cancel()
        call.seconds = time.perf_counter() - began
        if kill_after is None:
            answer.seek(0)
            call.document = json.load(answer)
    return call


def _memory_bytes(pid: int) -> int:
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
    found = re.search(r"VmRSS:\s*(\d+)", status)
    return 0 if found is None else 1024 * int(found[1])


@contextlib.contextmanager
def _children_of(pid: int) -> Iterator[list[int]]:
    """Give descriptors of the processes that a process has started."""
    numbers = [
        int(number)
        for tasks in Path(f"/proc/{pid}/task").iterdir()
        for number in (tasks / "children").read_text(encoding="ascii").split()
    ]
    descriptors = [os.pidfd_open(number) for number in numbers]
    try:
        yield descriptors
    finally:
        for descriptor in descriptors:
            os.close(descriptor)


def _wait_for_the_end_of(children: list[int], longest_s: float = 60.0) -> None:
    if not children:
        raise AssertionError("the batch had no process when it was killed")
    deadline = time.monotonic() + longest_s
    for child in children:
        if not select.select([child], [], [], max(deadline - time.monotonic(), 0.0))[0]:
            raise AssertionError("a process of the batch has not ended with it")


def growth(values: list[float]) -> float:
    """Return how much the largest of the last quarter exceeds the largest of the second one, as a ratio."""
    quarter = max(len(values) // 4, 1)
    return max(values[-quarter:]) / max(values[quarter : 2 * quarter] or values[:1])


def main(campaigns: int = 200, jobs: int = 2, idle_timeout: float = 20.0, n_broken: int | None = None) -> bool:
    """Make campaigns, run the batch, kill it, run it again; print what came of it, and return whether all is well."""
    n_broken = campaigns // BROKEN_SHARE if n_broken is None else n_broken
    with tempfile.TemporaryDirectory(prefix="batch-many-") as place, contextlib.ExitStack() as stack:
        for variable, name in (("STIFFCAL_STATE", "state"), ("TMPDIR", "temporary")):
            (Path(place) / name).mkdir(mode=0o700)
            stack.enter_context(_environment(variable, str(Path(place) / name)))
        folder = Path(place) / "cells"
        expected = make_campaigns(folder, campaigns, n_broken)
        killed = run_batch(folder, jobs, idle_timeout, kill_after=2 * campaigns // 5)
        call = run_batch(folder, jobs, idle_timeout)
        left = [file.name for file in (Path(place) / "temporary").iterdir()]
        complaints = list(_complaints(call, killed, expected, folder))
    # a process that was killed leaves the folder of the pages that it was making
    if len(left) > jobs:
        complaints.append(f"temporary files are left: {', '.join(left)}")
    outcomes = {Path(entry["folder"]).name: entry for entry in call.document["campaigns"]}
    computed = [name for name in call.order if name not in killed.order and outcomes[name]["memory_bytes"]]
    memory = growth([outcomes[name]["memory_bytes"] for name in computed])
    own = growth([float(size) for size in call.own_bytes])
    if campaigns >= JUDGED_FROM and max(memory, own) > MOST_GROWTH:
        complaints.append(f"memory grows beyond {MOST_GROWTH:.2f} times")
    counts = call.document["counts"]
    print(f"{campaigns} campaigns, {n_broken} of them broken, {jobs} processes")
    print(f"killed when {len(killed.order)} were done, after {killed.seconds:.0f} s; its processes ended with it")
    print(f"the same command again: {call.seconds:.0f} s, {counts['unchanged']} unchanged, {counts['held']} held")
    print(f"peak memory of a process: {call.document['peak_memory_bytes'] / 1e6:.0f} MB, {memory:.3f} times at the end")
    print(f"memory of the command: {max(call.own_bytes) / 1e6:.0f} MB, {own:.3f} times at the end")
    for complaint in complaints:
        print(f"NOT KEPT: {complaint}")
    return not complaints


@contextlib.contextmanager
def _environment(variable: str, value: str) -> Iterator[None]:
    before = os.environ.get(variable)
    os.environ[variable] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[variable]
        else:
            os.environ[variable] = before


def _complaints(call: Call, killed: Call, expected: dict[str, str], folder: Path) -> Iterator[str]:
    outcomes = {Path(entry["folder"]).name: entry for entry in call.document["campaigns"]}
    if outcomes.keys() != expected.keys():
        yield f"not named: {sorted(expected.keys() ^ outcomes.keys())}"
    for name, outcome in outcomes.items():
        if outcome["state"] != expected[name]:
            yield f"{name} is {outcome['state']}, not {expected[name]}: {outcome['error']}"
        is_good = expected[name] == "held"
        if is_good and not (folder / name / "report.pdf").read_bytes().startswith(b"%PDF"):
            yield f"{name} has no report"
        again = [step for step, done in outcome["steps"].items() if done["done"]]
        if is_good and name in killed.order and again:
            yield f"{name} was done, and is done again: {', '.join(again)}"


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--campaigns", type=int, default=200)
    options.add_argument("--jobs", type=int, default=2)
    options.add_argument("--idle-timeout", type=float, default=20.0)
    chosen = options.parse_args()
    sys.exit(0 if main(chosen.campaigns, chosen.jobs, chosen.idle_timeout) else 1)
