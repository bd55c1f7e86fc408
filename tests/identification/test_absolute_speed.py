"""Fits of absolute places: seconds and memory grow no faster than the number of poses."""

from __future__ import annotations

import time
import tracemalloc
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import stiffcal.identification.derivatives.observation
import stiffcal.model.balance.equilibrium
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.rest import Rest, find_rest
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

PEERS = {1000: 4.4, 10_000: 2.6}
"""Seconds of a fit over those of its `peer`, at most, by number of poses.

At 3 GHz, where a product of 6 by 6 matrices takes 121 ns in C, the peers take 0.09 and 1.05 s: the limits are 0.4 and
2.7 s there, and issue 16 allows 1 s for 1000 poses and 8 s for 11 000. Measured: 3.0 to 3.1 of 1000 poses; of 10 000,
whose arrays leave the processor's cache, 1.3 to 2.0, as others use it too.
"""
TURNS = {1000: 5, 3000: 2, 10_000: 2}
LIMIT_BYTES_PER_POSE = 25_000
"""41 columns of three components of 8 bytes are 984 bytes; measured: 6000 to 12 000."""
STEEPEST = 1.6
"""Seconds per pose at 10 000 poses, at most, over those at 3000."""
ORDERS = [{"order": 1.0} for _ in range(6)]


@cache
def campaign(n: int) -> tuple[LoadStates, CompliantRobot]:
    """Return n poses of a robot with springs, geometry errors and eccentric joints, and the model without values."""
    chain, rng = six_axes(), np.random.default_rng(1)
    sizes = (2.5e-4, 2.5e-4, 5e-4, 5e-4)
    errors = [dict(zip(("x", "y", "rx", "ry"), rng.normal(0.0, sizes), strict=True)) for _ in range(6)]
    springs = [{"c": 1.0 / float(stiffness)} for stiffness in SIX_STIFFNESS]
    eccentric = [{**order, "a": 1e-4, "b": -1e-4} for order in ORDERS]
    true = CompliantRobot(
        chain,
        (
            *on_all_joints(LinkGeometry(), 6, errors),
            *on_all_joints(JointCompliance(), 6, springs),
            *on_all_joints(JointEccentricity(), 6, eccentric),
        ),
    )
    model = CompliantRobot(
        chain,
        (
            *on_all_joints(LinkGeometry(), 6),
            *on_all_joints(JointCompliance(), 6),
            *on_all_joints(JointEccentricity(), 6, ORDERS),
        ),
    )
    return measured_by(true, absolute_states(chain, n, 1), 2), model


def peer(n: int) -> None:
    """Work of the fit's kind and size: small arrays pose by pose, products over all poses, orthogonal factors."""
    rng = np.random.default_rng(0)
    frames, columns, poses = rng.normal(size=(n, 4, 4)), rng.normal(size=(41, 3 * n)), rng.normal(size=(3 * n, 3, 2))
    for pose in poses:
        np.nan_to_num(pose).max()
    for _ in range(20):
        np.einsum("nij,njk->nik", frames, frames)
        columns * columns + columns
    for _ in range(3):
        np.linalg.qr(columns.T)


@cache
def seconds(n: int) -> tuple[float, float]:
    """Return the processor seconds of a fit and of its peer, in turn, the least of each: caches are filled once."""
    states, model = campaign(n)
    times = []
    for _ in range(TURNS[n]):
        start = time.process_time()
        fit = identify_parameters(states, model)
        between = time.process_time()
        peer(n)
        times.append((between - start, time.process_time() - between))
    assert fit.last_step is None
    assert len(fit.free_names) >= 38
    # 4 standard deviations of χ² with 3 n
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / (3 * n)))
    return min(own for own, _ in times), min(other for _, other in times)


@pytest.mark.parametrize("n", [1000, pytest.param(10_000, marks=pytest.mark.practice)])
def test_processor_seconds(n: int) -> None:
    own, other = seconds(n)
    print(f"{n} poses: {own:.2f} s, peer {other:.2f} s")
    assert own < PEERS[n] * other


def test_orders_of_eccentricities_are_found_without_a_balance_for_every_parameter(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """48 parameters without values: by difference of balances their derivatives took 534 of these."""
    balances = []

    def counted(*arguments: Any, **named: Any) -> Rest:
        balances.append(arguments)
        return find_rest(*arguments, **named)

    monkeypatch.setattr(stiffcal.identification.derivatives.observation, "find_rest", counted)
    monkeypatch.setattr(stiffcal.model.balance.equilibrium, "find_rest", counted)
    states, model = campaign(200)
    fit = identify_parameters(states, replace(model, placed=tuple(replace(p, values={}) for p in model.placed)))
    assert len(balances) < 80
    assert {p.value for p in fit.parameters if p.name.endswith(".order")} == {1.0}


@pytest.mark.practice
def test_seconds_grow_with_the_number_of_poses() -> None:
    assert seconds(10_000)[0] / 10_000 < STEEPEST * seconds(3000)[0] / 3000


@pytest.mark.parametrize("n", [1000, 3000])
def test_memory_is_bounded_by_the_number_of_poses(n: int) -> None:
    states, model = campaign(n)
    tracemalloc.start()
    try:
        identify_parameters(states, model)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    print(f"{n} poses: {peak / n:.0f} bytes per pose")
    assert peak < LIMIT_BYTES_PER_POSE * n
