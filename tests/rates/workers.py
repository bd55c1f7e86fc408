"""Processes next to each other, one thread of linear algebra each: two cores are no use to four threads."""

from __future__ import annotations

import os
import traceback
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from tests.rates import absolute_robots, benches, clamped_robots
from tests.rates.bench_scoring import judge_bench
from tests.rates.faulty import judge_faulty, simulate_faulty
from tests.rates.measuring import Player
from tests.rates.playing import CLASSES, FAULTY, simulate_runs
from tests.rates.scoring import Verdict, crashed, judge_campaign

BENCHES = (*benches.CLASSES, *clamped_robots.CLASSES, *absolute_robots.CLASSES)
"""Classes of clamped and turning joints, and of absolute places."""


@dataclass(frozen=True)
class Job:
    """One campaign to draw and to judge.

    Attributes
    ----------
    seed, kind, number : which.
    player : what moves the robot.
    only : hides only this effect in the classes of one; "" for any.
    without : effects that are left out of the catalogue.
    """

    seed: int
    kind: str
    number: int
    player: Player = "balance"
    only: str = ""
    without: tuple[str, ...] = ()


def one_thread_each(workers: int) -> ProcessPoolExecutor:
    """Return a pool of fresh processes; libraries read the number of threads when they are first imported."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def one_campaign(job: Job) -> Verdict:
    """Draw and judge one campaign; a crash is a verdict too, with its traceback."""
    classes = (*CLASSES, *BENCHES)
    rng = np.random.default_rng([job.seed, classes.index(job.kind), job.number])
    try:
        if job.kind in absolute_robots.CLASSES:
            drawn = absolute_robots.draw_absolute(job.kind, rng, job.number)
            return replace(judge_campaign(drawn, job.without), kind=job.kind)
        if job.kind in BENCHES:
            return judge_bench(job.kind, rng, job.player)
        if job.kind in FAULTY:
            return judge_faulty(simulate_faulty(job.kind, rng, job.player))
        return judge_campaign(simulate_runs(job.kind, rng, job.only, job.player), job.without)
    except Exception:
        return crashed(job.kind, job.player, traceback.format_exc())
