"""The correction of a clamped run's wrench: the driven motor's torque moves, what other drives carry does not."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.noise.wrench_correction import _as_one_drive

STATES, DRIVEN = 12, 1
RUN = np.repeat([3, 5], STATES // 2)


def turns() -> Floats:
    """Return (6, 6, n) of two poses far from singular ones, m and rad per rad."""
    rng = np.random.default_rng(2)
    poses = [np.linalg.qr(rng.normal(size=(6, 6)))[0] + 0.1 * rng.normal(size=(6, 6)) for _ in range(2)]
    return np.stack([poses[int(run == 5)] for run in RUN], axis=-1)


def moved() -> tuple[Floats, Floats]:
    """Return wrenches (6, n) that move all drives, and the variances of the sensor's components."""
    variance = np.repeat(np.array([[0.4], [0.5], [0.45], [0.05], [0.04], [0.06]]) ** 2, STATES, axis=1)
    return np.random.default_rng(3).normal(size=(6, STATES)), variance


def torques(wrench: Floats, columns: Floats) -> Floats:
    """Return (6, n) what each drive carries."""
    return np.asarray(np.einsum("ijn,in->jn", columns, wrench))


def test_no_other_drive_carries_a_share_of_the_correction() -> None:
    wrench, variance = moved()
    columns = turns()
    before, after = (torques(one, columns) for one in (wrench, _as_one_drive(wrench, columns, DRIVEN, variance, RUN)))
    np.testing.assert_allclose(after[DRIVEN], before[DRIVEN], rtol=1e-9)
    others = np.delete(np.arange(6), DRIVEN)
    assert np.abs(after[others]).max() < 1e-9 * np.abs(before[others]).max()


def test_a_drive_that_others_can_replace_keeps_its_correction() -> None:
    """Two axes in line: no wrench loads one of them alone."""
    wrench, variance = moved()
    columns = turns()
    columns[:, 4] = columns[:, DRIVEN]
    np.testing.assert_array_equal(_as_one_drive(wrench, columns, DRIVEN, variance, RUN), wrench)
