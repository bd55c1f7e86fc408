"""A test bench for effects: a robot with a beam, loads at chosen nodes, orders of states, terms summed up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, MeasurementSetup, RunInfo
from stiffcal.mechanics.chain import BeamFrame, Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import Balance, solve_balance
from stiffcal.model.effect import Effect, NodeLoads, Place, StateOrder
from tests.laboratory.robots import force_sensor_setup, six_axes

BEAM_LENGTH = 0.8


def robot_chain() -> Chain:
    """Return the medium robot, with a beam between joints 2 and 3 and gear orders at joint 4."""
    end = np.eye(4)
    end[0, 3] = BEAM_LENGTH
    return replace(
        six_axes(), beams={"swing": BeamFrame(2, end, BEAM_LENGTH)}, gear_orders=((), (), (), (80, 160), (), ())
    )


def loads(
    entries: Mapping[tuple[int, int], Sequence[float] | Floats],
    order: StateOrder | None = None,
    weight: Mapping[tuple[int, int], float] | None = None,
    angles: Floats | None = None,
) -> NodeLoads:
    """Return loads that are zero but for (node, component): values; ``weight`` is constant over the states."""
    n = len(next(iter(entries.values())))
    wrench, resting = np.zeros((14, 6, n)), np.zeros((14, 6, n))
    for place, values in entries.items():
        wrench[place] = values
    for place, value in (weight or {}).items():
        resting[place] = value
    return NodeLoads(wrench, np.zeros((6, n)) if angles is None else angles, order, None if weight is None else resting)


def order_of(
    run: Sequence[int],
    time: Sequence[float] | Floats | None = None,
    hold: Sequence[float] | None = None,
    motor: Floats | None = None,
    temperature: Sequence[float] | None = None,
) -> StateOrder:
    """Return an order of states, numbered from 1; what is not given is not known."""
    n = len(run)
    missing = np.full(n, np.nan)
    stamps = missing if time is None else np.array(time, dtype=np.float64)
    runs = np.array(run, dtype=np.int64)
    start = np.array([stamps[runs == number][0] for number in runs])
    return StateOrder(
        run=runs,
        time=stamps,
        hold=missing if hold is None else np.array(hold, dtype=np.float64),
        motor=np.zeros((6, n)) if motor is None else motor,
        temperature=missing if temperature is None else np.array(temperature, dtype=np.float64),
        since_reference=stamps - start,
        number=np.arange(1, n + 1),
    )


def displacement(
    effect: Effect,
    place: Place,
    values: Mapping[str, float],
    carried: NodeLoads,
    chain: Chain | None = None,
) -> Floats:
    """Return (14, 6, n) the nodes' displacements: terms times amplitudes."""
    one = PlacedEffect(effect, place, values)
    total: Floats = np.zeros_like(carried.wrench)
    for term in one.terms(chain or robot_chain(), carried):
        assert term.value.shape == (carried.wrench.shape[2],)
        total[term.node, term.component] += one.amplitude(term.symbol) * term.value
    return total


def nonzero(moved: Floats) -> set[tuple[int, int]]:
    """Return the (node, component) pairs that move."""
    return {(int(node), int(component)) for node, component in np.argwhere(np.abs(moved).max(axis=2) > 0.0)}


def settled(
    effects: Sequence[tuple[Effect, Place, Mapping[str, float]]],
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup | None = None,
    order: StateOrder | None = None,
    chain: Chain | None = None,
) -> Balance:
    """Return the exact balance of the medium robot, rigid but for the given effects."""
    robot = CompliantRobot(
        chain or robot_chain(), tuple(PlacedEffect(effect, place, values) for effect, place, values in effects)
    )
    return solve_balance(robot, joints, wrench, setup or force_sensor_setup(robot.chain), order)


def bare_states(
    run: Sequence[int], joints: Floats | None = None, setup: MeasurementSetup | None = None, **known: Any
) -> LoadStates:
    """Return load states of which nothing is known but runs, joint angles and what is given by keyword."""
    n = len(run)
    nan = np.full
    fields: dict[str, Any] = {
        "time": nan(n, np.nan),
        "hold": nan(n, np.nan),
        "wrench": np.zeros((n, 6)),
        "position": np.zeros((n, 1, 3)),
        "rotation": nan((n, 1, 3, 3), np.nan),
        "deflection": nan((n, 1, 6), np.nan),
        "temperature": np.zeros((n, 0)),
        "wrench_scatter": nan((n, 6), np.nan),
        "position_scatter": nan((n, 1, 3), np.nan),
        **known,
    }
    runs = np.array(run, dtype=np.int64)
    return LoadStates(
        runs=tuple(RunInfo(f"run{k}") for k in range(int(runs.max()) + 1)),
        run=runs,
        joints=np.zeros((n, 6)) if joints is None else joints,
        reference=np.concatenate([[True], runs[1:] != runs[:-1]]),
        row=np.arange(1, n + 1),
        n_readings=np.ones(n, dtype=np.int64),
        set_aside=np.full(n, "", dtype=np.str_),
        setup=setup or force_sensor_setup(robot_chain()),
        **fields,
    )
