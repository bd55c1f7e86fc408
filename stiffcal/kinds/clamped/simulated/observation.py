"""Observation effects in the simulation of clamped runs: a fixture that gives, encoders that drift.

They are asked for their columns as the fit asks, with a held frame on which each component stands for itself.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Instrument, Observed, StateOrder
from stiffcal.model.held_frame import HeldFrame


def compliance_of_fixture(robot: CompliantRobot) -> Floats:
    """Return (6, 6) what the model's effects add to the fixture's compliance, m/N and rad/(N·m), base axes."""
    unit = HeldFrame(0, np.zeros((1, 6, 6)), np.zeros((6, robot.chain.coupling.shape[1], 6)), np.eye(6))
    still = _order(robot, np.zeros(6), np.zeros(6))
    columns = [_shift(placed, unit, still) for placed in robot.placed]
    return np.asarray(sum(columns, np.zeros((6, 6))))


def drift_of_readings(robot: CompliantRobot, time: Floats, warmer: Floats) -> Floats:
    """Return (s, L) rad by which the readings of the logged joints run ahead.

    Parameters
    ----------
    time : (s,) s from the run's start. warmer : (s,) K above the run's start.
    """
    n, logged = len(time), robot.chain.coupling.shape[1]
    drift = np.zeros((n, logged))
    for placed in robot.placed:
        for joint in placed.place.joints:
            # A joint whose turn moves the frame by as much along x alone.
            jacobian = np.zeros((6, logged, n))
            jacobian[0, joint - 1] = 1.0
            held = HeldFrame(0, np.zeros((1, 6, n)), jacobian, np.zeros((6, n)))
            drift[:, joint - 1] -= _shift(placed, held, _order(robot, time, warmer))[0]
    return drift


def _shift(placed: PlacedEffect, held: HeldFrame, order: StateOrder) -> Floats:
    """Return (6, n) what an observation effect adds to the held frame's motion because the frame is held."""
    shift = np.zeros_like(held.wrench)
    if isinstance(placed.effect, Instrument):
        for sign, frame in ((1.0, held), (-1.0, None)):
            observed = Observed(np.zeros((1, *held.wrench.shape)), order, frame)
            columns = placed.observation_columns(observed)
            for symbol, column in columns.items():
                shift = shift + sign * placed.amplitude(symbol) * column[0]
    return shift


def _order(robot: CompliantRobot, time: Floats, warmer: Floats) -> StateOrder:
    n = len(time)
    return StateOrder(
        run=np.zeros(n, dtype=np.int64), time=time, hold=np.full(n, np.nan), motor=np.zeros((robot.chain.n_joints, n)),
        temperature=warmer, since_reference=time, number=np.arange(1, n + 1),
    )  # fmt: skip
