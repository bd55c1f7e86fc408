"""What drives carried before each row of an absolute run whose rows follow each other directly."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.state_order import PoseHistory


def pose_history(states: LoadStates, chain: Chain, keep: Integers) -> PoseHistory | None:
    """Return the history of the states at ``keep``; None where no run states that its rows follow each other.

    A row in between that is missing, or whose load or time is, ends a sequence: what the robot carried there is not
    known.
    """
    direct = np.array([run.direct for run in states.runs], dtype=np.bool_)[states.run]
    wrench = states.wrench[:, : 6 if states.setup.moments_measured else 3]
    rows = np.flatnonzero(direct & np.isfinite(states.time) & np.isfinite(wrench).all(axis=1))
    if not rows.size:
        return None
    names = np.array([states.runs[k].of for k in states.run[rows]])
    begins = np.ones(rows.size, dtype=np.bool_)
    begins[1:] = (np.diff(states.row[rows]) != 1) | (names[1:] != names[:-1])
    place = np.full(len(states), -1, dtype=np.int64)
    place[rows] = np.arange(rows.size)
    # moments that are not measured
    wrench = np.nan_to_num(states.wrench[rows])
    return PoseHistory(
        torque=rigid_drive_torques(chain, states.joints[rows], wrench, states.setup),
        segment=np.cumsum(begins),
        time=states.time[rows],
        hold=states.hold[rows],
        index=place[keep],
    )


def rigid_drive_torques(chain: Chain, logged: Floats, wrench: Floats, setup: MeasurementSetup) -> Floats:
    """Return (J, n) what each drive carries on the undeformed robot, N·m.

    Parameters
    ----------
    logged : (n, L) joint angles, rad.
    wrench : (n, 6) N and N·m in the set-up's wrench axes.
    """
    balance = solve_balance(CompliantRobot(chain, ()), chain.model_angles(logged), wrench, setup)
    return np.ascontiguousarray((balance.joint_torque @ chain.drive_axes).T)
