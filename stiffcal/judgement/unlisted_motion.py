"""Laws of moving joints that nobody has written down: flexible functions of what was logged of their motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.fitting.regressors import RegressorMaker
from stiffcal.judgement.numbers import FORGOTTEN, MOTION_POWERS, MOTION_WAVES
from stiffcal.judgement.unlisted import UnlistedLaw
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import ParameterSpec, Place, Values
from stiffcal.model.motion import Motion


def unlisted_motion_laws(state: RegressorMaker, joints: Sequence[int]) -> Iterator[UnlistedLaw]:
    """Give the laws of some joints, from 1, that these readings can show."""
    for joint in joints:
        for follows, functions in FUNCTIONS.items():
            columns = state.regressor(_Law(functions), Place("joints", (joint,)), {}).columns
            shows = columns.any(axis=(1, 2)) & np.isfinite(columns).all(axis=(1, 2))
            if shows.any():
                yield UnlistedLaw(f"joint {joint}", follows, columns[shows])


def _along(values: Floats) -> Floats | None:
    """Return values (n,) from 0 to 1; None where they do not change, or were not logged."""
    range_ = float(np.ptp(values)) if np.isfinite(values).all() and len(values) else 0.0
    return (values - values.min()) / range_ if range_ > 0.0 else None


def _waves(values: Floats, count: int = MOTION_WAVES) -> list[Floats]:
    """Return half waves over values (n,), from one on."""
    along = _along(values)
    return [] if along is None else [np.cos(np.pi * k * along) for k in range(1, count + 1)]


def _curves(values: Floats) -> list[Floats]:
    """Return polynomials of values (n,) up to `POWERS`, from the constant on."""
    along = _along(values)
    if along is None:
        return [np.ones(len(values))]
    return [np.polynomial.legendre.Legendre.basis(k)(2.0 * along - 1.0) for k in range(MOTION_POWERS + 1)]


def _speeds(motion: DriveMotion) -> Floats:
    return np.log(np.maximum(np.abs(motion.velocity), 1e-9))


def _with_sign(functions: list[Floats], motion: DriveMotion) -> list[Floats]:
    sign = np.sign(motion.velocity)
    return [sign * one for one in functions]


def _of_speed(motion: DriveMotion) -> list[Floats]:
    """Return curves over the speed that change their sign with the direction."""
    return _with_sign(_curves(_speeds(motion)), motion)


def _of_speed_alone(motion: DriveMotion) -> list[Floats]:
    """Return curves over the speed, the same in both directions."""
    return _curves(_speeds(motion))


def _of_position(motion: DriveMotion) -> list[Floats]:
    """Return waves over the joint's angle, the same in both directions."""
    return _waves(motion.angle, 2 * MOTION_WAVES)


def _of_position_and_direction(motion: DriveMotion) -> list[Floats]:
    """Return waves over the joint's angle that change their sign with the direction."""
    return _with_sign(_waves(motion.angle, 2 * MOTION_WAVES), motion)


def _of_temperature(motion: DriveMotion) -> list[Floats]:
    """Return curves over the temperature, of friction at all speeds and of what grows with the speed."""
    if _along(motion.temperature) is None:
        return []
    curves = _curves(motion.temperature)[1:4]
    return [*_with_sign(curves, motion), *(motion.velocity * one for one in curves), *curves]


def _of_time(motion: DriveMotion) -> list[Floats]:
    """Return waves over time, of friction at all speeds, of what grows with the speed, and of the sensor's zero."""
    waves = _waves(motion.time)
    return [*_with_sign(waves, motion), *(motion.velocity * one for one in waves[: MOTION_WAVES // 2]), *waves]


def _of_load(motion: DriveMotion) -> list[Floats]:
    """Return curves over the weight's torque, and over its size with the direction's sign."""
    if _along(motion.load) is None:
        return []
    return [*_curves(motion.load)[1:5], *_with_sign(_curves(np.abs(motion.load))[1:5], motion)]


def _of_past(motion: DriveMotion) -> list[Floats]:
    """Return what is left of the speed before, and what was travelled since the last reversal."""
    order = np.argsort(motion.time, kind="stable")
    left = [_left_of(motion.time, np.abs(motion.velocity), order, over) for over in FORGOTTEN]
    since = [] if not np.isfinite(motion.travel).all() else [np.exp(-motion.travel / d) for d in (1e-3, 1e-2, 1e-1)]
    return _with_sign([*left, *since], motion)


def _left_of(time: Floats, speed: Floats, order: Integers, over: float) -> Floats:
    """Return (n,) the largest speed before each sample, as far as it is not forgotten."""
    found, left, last, now = np.zeros(len(time)), 0.0, float(time[order[0]]), 0.0
    for k in order.tolist():
        left = max(left, now) * float(np.exp(-(time[k] - last) / over))
        found[k] = left
        last, now = float(time[k]), float(speed[k])
    return found


Functions = Callable[[DriveMotion], list[Floats]]
"""Of a joint's motion (n,)."""
FUNCTIONS: dict[str, Functions] = {
    "its speed": _of_speed,
    "its speed, the same in both directions": _of_speed_alone,
    "its angle": _of_position,
    "its angle and direction": _of_position_and_direction,
    "its temperature": _of_temperature,
    "time": _of_time,
    "the torque of its weight": _of_load,
    "what it did before": _of_past,
}
"""By what a law of them follows."""


class _Law(Motion):
    """A torque that is a sum of functions of a joint's motion."""

    name = "unlisted"

    def __init__(self, functions: Functions) -> None:
        self.functions = functions
        self.parameters = tuple(_size(f"a{k}") for k in range(4 * MOTION_WAVES))  # type: ignore[misc]

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """Return the functions, each with an amplitude of its own."""
        return {f"a{k}": value for k, value in enumerate(self.functions(motion))}


def _size(symbol: str) -> ParameterSpec:
    return ParameterSpec(symbol, "N·m", "size", -1.0, 1.0, 1.0, "")
