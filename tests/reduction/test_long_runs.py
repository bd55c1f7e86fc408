"""One run of thousands of states: what is looked for in it takes time and memory in proportion to its states."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mistakes.force_zero import large_steps
from stiffcal.mistakes.force_zero.accounts import moved_zeros
from stiffcal.mistakes.force_zero.faults import force_zero_faults
from stiffcal.reduction.set_aside.outliers import outlier_readings
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

UP_AND_DOWN = np.array([0.0, 100.0, 200.0, 300.0, 200.0, 100.0])
AND_BACK = np.array([0.0, 100.0, 0.0, 200.0, 0.0, 300.0])


def long_run(n: int, levels: Floats) -> LoadStates:
    """Return one run of n states: loads of so many N along one direction, again and again."""
    rng = np.random.default_rng(2)
    wrench = np.zeros((n, 6))
    wrench[:, :3] = (levels[np.arange(n) % levels.size] * (1.0 + 0.01 * rng.normal(size=n)))[:, None] * [1.0, 0.1, 0.0]
    springs = joint_springs(six_axes(), np.array(SIX_STIFFNESS), deformed=False)
    return played(springs, 1, wrench=[wrench], noise=Sigma(translation=16e-6, force=0.3), full_pose=False)


def test_states_among_which_a_moved_zero_is_looked_for_do_not_grow_with_the_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    compared, search = [0], large_steps._new_zeros

    def counted(stretches: list[large_steps._Stretch]) -> list[list[int]]:
        compared[-1] += sum(one.end - one.start for one in stretches)
        return search(stretches)

    monkeypatch.setattr(large_steps, "_new_zeros", counted)
    for n in (900, 3000):
        compared.append(0)
        moved_zeros(long_run(n, UP_AND_DOWN))
    assert 0 < compared[2] < 2 * compared[1]


@pytest.mark.parametrize(("n", "at"), [(900, 501), (6000, 3501)])
def test_a_zero_that_moves_as_much_as_a_load_is_found(n: int, at: int) -> None:
    states = long_run(n, AND_BACK)
    assert force_zero_faults(states, six_axes()) == []
    wrench = states.wrench.copy()
    wrench[at:, 1] += 120.0
    changed = replace(states, wrench=wrench)
    (fault,) = force_zero_faults(changed, six_axes())
    assert fault.code is FaultCode.WRENCH_REZEROED
    ((*_, account),) = moved_zeros(changed)
    assert abs(account.between[1] - at) < 10


def test_a_few_bumped_readings_of_a_long_run_are_found() -> None:
    states, bumped = long_run(4000, UP_AND_DOWN), [601, 1997, 2003, 3555]
    position = states.position.copy()
    position[bumped, 0, 2] += 5e-4
    tracemalloc.start()
    found = outlier_readings(replace(states, position=position))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert sorted(found) == bumped
    assert peak < 1e4 * len(states)
