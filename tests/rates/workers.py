"""Processes beside each other, one thread of linear algebra each: two cores are no use to four threads."""

from __future__ import annotations

import os
import traceback
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from tests.rates.playing import CLASSES, simulate_runs
from tests.rates.scoring import Verdict, judge_campaign


def one_thread_each(workers: int) -> ProcessPoolExecutor:
    """Return a pool of fresh processes; libraries read the number of threads when they are first imported."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def one_campaign(job: tuple[int, str, int, str, tuple[str, ...]]) -> Verdict | str:
    """Draw and judge one campaign; a crash comes back as its traceback."""
    seed, kind, number, only, without = job
    rng = np.random.default_rng([seed, CLASSES.index(kind), number])
    try:
        return judge_campaign(simulate_runs(kind, rng, only), without)
    except Exception:
        return f"{kind} {number}: {traceback.format_exc()}"
