"""How much sooner many campaigns are done by two processes than by one, what memory they take, and what a repeat costs.

A hundred small campaigns (four poses, 100 load states each) in one batch, from nothing: with one process, with two, and
as two batches of half of them next to each other, in turns; then once more with nothing changed. The batches apart have
nothing to do with each other: how much sooner they are done than one after the other is what processors, caches and
disk of this machine allow. The peak memory of the processes must not grow with the number of campaigns. Half as many
campaigns come first: as in an installation, Python's compiled modules are there.

    python -m tests.benchmarks.batch_speed [--campaigns 100] [--turns 1] [--report] [--jobs 2]

Limits: two processes take at most 10 % more time than the batches apart; twice the campaigns take at most 10 % more
memory in any process. ``--report`` has the PDFs made too (ten seconds each).
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

MOST_OVER_APART = 1.10
MOST_MEMORY_GROWTH = 1.10


def make_campaigns(folder: Path, count: int) -> None:
    """Write the campaigns; ten or half of them are made, the others are copies with another name."""
    from tests.laboratory.small_campaign import write_small_campaign

    different = max(1, min(10, count // 2))
    for number in range(count):
        target = folder / f"cell-{number:03d}"
        if number < different:
            write_small_campaign(target, seed=number)
        else:
            shutil.copytree(folder / f"cell-{number % different:03d}", target)


def run_apart(halves: Sequence[Path], stores: Path, report: bool) -> float:
    """Run a batch of one process for each folder, all at the same time; return what all of them took in s."""
    began = time.perf_counter()
    with ThreadPoolExecutor(len(halves)) as pool:
        tuple(pool.map(lambda half: run_batch(half, stores / half.name, 1, report), halves))
    return time.perf_counter() - began


def run_batch(folder: Path, stores: Path, jobs: int, report: bool) -> dict[str, Any]:
    """Run the command; return its document, with what the whole call took in s."""
    command = [sys.executable, "-m", "stiffcal", "batch", str(folder), "--jobs", str(jobs), "--store", str(stores)]
    began = time.perf_counter()
    means = ["--reports", str(stores / "pdf")] if report else ["--no-report"]
    compiled = dict(os.environ)
    if compiled.pop("PYTHONDONTWRITEBYTECODE", ""):
        compiled["PYTHONPYCACHEPREFIX"] = str(stores.parent / "compiled")
    done = subprocess.run(
        [*command, *means, "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True, env=compiled
    )
    document: dict[str, Any] = json.loads(done.stdout)
    assert document["passed"]
    lost = [entry["campaign"] for entry in document["campaigns"] if entry["warnings"]]
    assert not lost, f"processes were lost, and {lost} tried again"
    return document | {"whole_s": time.perf_counter() - began}


def main(campaigns: int = 100, turns: int = 1, jobs: int = 2, report: bool = False) -> bool:
    """Measure and print; return whether the limits are met."""
    with tempfile.TemporaryDirectory(prefix="batch-speed-") as place:
        folder = Path(place) / "cells"
        make_campaigns(folder, campaigns)
        parts = [Path(place) / f"part-{number}" for number in range(jobs)]
        for part in (Path(place) / "few", *parts):
            make_campaigns(part, max(campaigns // jobs, 1))
        taken: dict[int, list[float]] = {1: [], jobs: []}
        apart = []
        few = run_batch(Path(place) / "few", Path(place) / "stores-few", jobs, report)
        memory = {"few": few["peak_memory_bytes"], "all": 0}
        for turn in range(turns):
            for count in (1, jobs):
                stores = Path(place) / f"stores-{turn}-{count}"
                document = run_batch(folder, stores, count, report)
                taken[count].append(document["whole_s"])
                memory["all"] = max(memory["all"], document["peak_memory_bytes"])
            apart.append(run_apart(parts, Path(place) / f"stores-{turn}-apart", report))
        again = run_batch(folder, stores, jobs, report)
        assert again["counts"]["unchanged"] == campaigns
    speed_up, growth = min(taken[1]) / min(taken[jobs]), memory["all"] / memory["few"]
    over_apart = min(taken[jobs]) / min(apart)
    for count, seconds in taken.items():
        print(f"{campaigns} campaigns with {count} process(es): {min(seconds):7.1f} s, best of {turns}")
    print(f"once more, nothing changed: {again['whole_s']:.1f} s")
    print(
        f"peak memory of a process: {memory['all'] / 1e6:.0f} MB; with half the campaigns {memory['few'] / 1e6:.0f} MB"
    )
    print(f"{jobs} processes over 1: {speed_up:.2f} times as fast")
    print(f"{jobs} batches apart, at the same time: {min(apart):.1f} s")
    print(f"{jobs} processes over batches apart: {over_apart:.2f} times the time (at most {MOST_OVER_APART})")
    print(f"peak memory at twice the campaigns: {growth:.3f} times (at most {MOST_MEMORY_GROWTH})")
    good = over_apart <= MOST_OVER_APART and growth <= MOST_MEMORY_GROWTH
    print("met" if good else "NOT MET")
    return good


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--campaigns", type=int, default=100)
    options.add_argument("--turns", type=int, default=1)
    options.add_argument("--jobs", type=int, default=2)
    options.add_argument("--report", action="store_true")
    chosen = options.parse_args()
    sys.exit(0 if main(chosen.campaigns, chosen.turns, chosen.jobs, chosen.report) else 1)
