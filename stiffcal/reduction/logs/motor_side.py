"""Motor-side logs at the joint's side: gear ratios, and motor angles that start anew at every turn.

What a controller logs of its motors is turned once, while the log streams past, so that nothing behind it need know of
motors: angles, commands, velocities and last motions are divided by the gear ratio, torques are multiplied with it
(physics, section 1: the joint's side counts). Currents stay what they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.source import Source
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.logs.log_rows import LogRows

TURN = 2.0 * np.pi
# A resolver's angle jumps by a whole turn, less what the motor moves in one sampling interval.
LEAST_JUMP = 0.7 * TURN
# Angles of a log that starts anew at every turn stay within one turn, noise included.
ONE_TURN = 1.02 * TURN


class MotorSide:
    """Bring the rows of one log to the joint's side, batch by batch, in order.

    Parameters
    ----------
    source : its manifest entry; rows of sources that are not motor-side pass unchanged.
    chain : gear ratios.
    name : the source's name, for faults.
    starts_anew : whether a log may start anew at every turn of a motor; states far apart show no turns.

    Raises
    ------
    InputError
        The log is motor-side, and the robot file gives no gear ratio.
    """

    def __init__(self, source: Source, chain: Chain, name: str = "", starts_anew: bool = True) -> None:
        self._starts_anew = starts_anew
        self._ratio: Floats | None = None
        if source.joints is not None and source.joints.motor:
            if bool(np.all(chain.gear_ratio == 1.0)):
                raise InputError.at(
                    FaultCode.KEY_MISSING, "robot.toml", "joints.gear_ratio",
                    f"sources.{name}.joints is motor-side, and no gear ratio is given",
                    "add gear_ratio (motor turns per joint turn) to each joint, or write motor = false",
                )  # fmt: skip
            self._ratio = chain.gear_ratio
        self._turns = np.zeros(chain.gear_ratio.size)
        self._last: Floats | None = None
        self._low = np.full(chain.gear_ratio.size, np.inf)
        self._high = np.full(chain.gear_ratio.size, -np.inf)
        self.wraps = np.zeros(chain.gear_ratio.size, dtype=np.int64)
        """How often each motor's angle started anew."""

    def joint_side(self, rows: LogRows) -> LogRows:
        """Return the rows at the joint's side."""
        ratio = self._ratio
        if ratio is None or len(rows) == 0:
            return rows
        signals = dict(rows.signals)
        if "joints" in signals:
            angles = self._unwrap(signals["joints"]) if self._starts_anew else signals["joints"]
            signals["joints"] = angles / ratio[:, None]
        for name in ("joints.command", "joints.velocity"):
            if name in signals:
                signals[name] = signals[name] / ratio[:, None]
        if "joints.torque" in signals:
            signals["joints.torque"] = signals["joints.torque"] * ratio[:, None]
        if "joints.approach" in signals:
            signals["joints.approach"] = signals["joints.approach"] / ratio[:, None]
        return replace(rows, signals=signals)

    def all(self, batches: Iterator[LogRows]) -> Iterator[LogRows]:
        """Yield the rows of a log at the joint's side."""
        for rows in batches:
            yield self.joint_side(rows)

    def _unwrap(self, angle: Floats) -> Floats:
        """Return (L, n) motor angles with whole turns put back where the log starts anew at every turn.

        Only a log that never leaves one turn can do that: beyond one turn a large step is a fast motor.
        """
        self._low = np.minimum(self._low, angle.min(axis=1))
        self._high = np.maximum(self._high, angle.max(axis=1))
        before = angle[:, :1] if self._last is None else self._last[:, None]
        self._last = angle[:, -1].copy()
        step = np.diff(np.concatenate([before, angle], axis=1), axis=1)
        within = (self._high - self._low <= ONE_TURN)[:, None]
        jump = np.where(within & (np.abs(step) >= LEAST_JUMP), -np.sign(step), 0.0)
        self.wraps += np.count_nonzero(jump, axis=1)
        turns = self._turns[:, None] + np.cumsum(jump, axis=1)
        self._turns = turns[:, -1]
        return np.asarray(angle + TURN * turns)
