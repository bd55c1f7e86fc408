"""Order and time of states, for laws with a memory."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class PoseHistory:
    """N poses that a robot went through one after the other, those of which nothing was measured among them.

    Why apart from the states: each row of an absolute run is left out of a fit by itself, and what a drive carried
    before counts all the same.
    """

    torque: Floats
    """(J, N) N·m, what each drive carries at rest on the undeformed robot of the robot file, payload included."""
    segment: NDArray[np.int64]
    """(N,) number of the uninterrupted sequence that the pose belongs to; contiguous and in order."""
    time: Floats
    """(N,) s, as of the states."""
    hold: Floats
    """(N,) s since the pose was reached, NaN where not known."""
    index: NDArray[np.int64]
    """(n,) the pose of each of n states; −1 for a state of which no history is known."""


@dataclass(frozen=True)
class StateOrder:
    """Order and time of states, for laws with a memory."""

    run: NDArray[np.int64]
    """(n,) run number; states of a run are contiguous and in order."""
    time: Floats
    """(n,) s on the run's clock, NaN where not logged."""
    hold: Floats
    """(n,) s since the load was reached, NaN where not known."""
    motor: Floats
    """(J, n) model-joint motion of the motors since the run's reference, rad; zero where not logged."""
    temperature: Floats
    """(n,) K, rise of the first temperature channel since the run's reference state; NaN where none is logged."""
    since_reference: Floats
    """(n,) s since the run's reference state."""
    number: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n,) the state's number in the campaign, from 1; empty where the states stand in no campaign."""
    swept: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(n,) True for moments of a load that moves; empty where all loads are held."""
    motor_torque: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(n,) True where the load is the torque of a clamped robot's motor; empty where a sensor measures all loads."""
    kelvin: Floats = field(default_factory=lambda: np.zeros(0))
    """(n,) K, the first temperature channel itself; NaN where none is logged."""
    approach: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    """(J, n) direction of each drive's last motion: 1, −1, 0 where it is not known; no rows where it is of no state."""
    history: PoseHistory | None = None
    """What the drives carried before, where states are poses of a known order; None: nowhere."""

    def __post_init__(self) -> None:
        if self.kelvin.size == 0:
            object.__setattr__(self, "kelvin", np.full(len(self.run), np.nan))

    @property
    def logs_temperature(self) -> bool:
        """Whether a temperature is known of any state; drift then follows it, else the time."""
        return bool(np.isfinite(self.temperature).any())

    @property
    def reference_kelvin(self) -> Floats:
        """(n,) K, the temperature of the run's reference state; NaN where none is logged."""
        return np.asarray(self.kelvin - self.temperature)

    def block(self, rows: slice | NDArray[np.bool_] | NDArray[np.int64]) -> StateOrder:
        """Return some of the states."""
        return StateOrder(
            self.run[rows],
            self.time[rows],
            self.hold[rows],
            self.motor[:, rows],
            self.temperature[rows],
            self.since_reference[rows],
            self.number[rows] if self.number.size else self.number,
            self.swept[rows] if self.swept.size else self.swept,
            self.motor_torque[rows] if self.motor_torque.size else self.motor_torque,
            self.kelvin[rows],
            self.approach[:, rows] if self.approach.size else self.approach,
            None if self.history is None else replace(self.history, index=self.history.index[rows]),
        )

    def direction(self, joint: int) -> Floats:
        """Return (n,) the direction of the last motion of the drive of ``joint`` (from 1): 1, −1, 0: not known."""
        return self.approach[joint - 1] if self.approach.size else np.zeros(len(self.run))
