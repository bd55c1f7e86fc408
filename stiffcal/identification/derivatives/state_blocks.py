"""Blocks of states that are predicted together."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.identification.readings.observations import Observations
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import blocks
from stiffcal.model.effect import Instrument


def state_blocks(robot: CompliantRobot, data: Observations) -> Iterator[slice]:
    """Cut states into blocks, between runs only where that is needed: else a run of any length takes no more memory."""
    return blocks(data.run, data.n_states, keep_runs=depends_on_run(robot, data))


def depends_on_run(robot: CompliantRobot, data: Observations) -> bool:
    """Return whether what is read of a state depends on others of its run.

    It does so of laws with a memory, of what acts on the measurement (a seat that shifts, a clock), of clamped motors.
    """
    on_measurement = any(isinstance(placed.effect, Instrument) for placed in robot.acting)
    return robot.has_memory or on_measurement or data.layout.motors is not None
