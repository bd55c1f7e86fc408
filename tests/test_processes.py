"""Independent tasks in several processes."""

from __future__ import annotations

import os
from functools import partial

import numpy as np
import pytest

from stiffcal.processes import run_in_processes


def test_answers_come_in_the_order_of_the_tasks() -> None:
    tasks = [partial(pow, number, 2) for number in range(11)]
    assert run_in_processes(tasks, processes=3) == run_in_processes(tasks, processes=1) == [n**2 for n in range(11)]


def test_tasks_are_shared_out() -> None:
    assert len(set(run_in_processes([os.getpid] * 6, processes=3))) == 3


def test_what_a_task_raises_is_raised_here() -> None:
    def fail() -> int:
        raise ValueError("task 3")

    for number in range(4):
        tasks = [partial(int, 0)] * 4
        tasks[number] = fail  # type: ignore[call-overload]
        with pytest.raises(ValueError, match="task 3"):
            run_in_processes(tasks, processes=2)


def test_a_process_that_ends_loses_no_answer() -> None:
    """A helper that is killed leaves its tasks to this process."""
    here = os.getpid()

    def end_elsewhere() -> int:
        if os.getpid() != here:
            os._exit(1)
        return 7

    assert run_in_processes([end_elsewhere] * 4, processes=2) == [7] * 4


def test_answers_larger_than_a_pipe_holds() -> None:
    arrays = run_in_processes([partial(np.full, 1_000_000, float(number)) for number in range(4)], processes=2)
    assert [float(array.sum()) for array in arrays] == [0.0, 1e6, 2e6, 3e6]
