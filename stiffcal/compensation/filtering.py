"""What is done to a force sensor's reading before it is compensated: noise filtered, the tool's weight taken out.

The block diagrams of 001 (Fig. 3) and 002 (Fig. 5). A filter in a loop looks at the past alone and is late by its group
delay; over a finished log it runs forward and backward and is not late at all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import cross_matrix, inverse_transform

Floats = NDArray[np.float64]


class LowPass:
    """A second-order Butterworth low-pass of several channels, by the bilinear transform.

    Parameters
    ----------
    cutoff_hz : where a sine comes through with 71 % of its size; below half the rate.
    rate_hz : samples per second.
    channels : how many there are.

    Examples
    --------
    >>> import numpy as np
    >>> smooth = LowPass(10.0, 1000.0, 1)
    >>> step = smooth.run(np.concatenate([[[0.0]], np.ones((300, 1))]))
    >>> abs(step[-1, 0] - 1.0) < 1e-3
    np.True_
    >>> round(1e3 * smooth.delay_s, 1)  # ms
    22.5
    """

    def __init__(self, cutoff_hz: float, rate_hz: float, channels: int = 6) -> None:
        if not 0.0 < cutoff_hz < 0.5 * rate_hz:
            raise ValueError(f"a cut-off of {cutoff_hz:g} Hz does not lie below half of {rate_hz:g} samples per second")
        warped = np.tan(np.pi * cutoff_hz / rate_hz)
        scale = 1.0 + np.sqrt(2.0) * warped + warped * warped
        self.b = np.array([1.0, 2.0, 1.0]) * warped * warped / scale
        self.a = np.array([2.0 * (warped * warped - 1.0), 1.0 - np.sqrt(2.0) * warped + warped * warped]) / scale
        self.delay_s = float(np.sqrt(2.0) / (2.0 * np.pi * cutoff_hz))
        self._first, self._second, self._term = np.zeros(channels), np.zeros(channels), np.zeros(channels)
        self._b0, self._b1, self._b2 = (np.full(channels, value) for value in self.b)
        self._a1, self._a2 = (np.full(channels, value) for value in self.a)

    def settle(self, reading: Floats) -> None:
        """Put the filter into the state that a reading (c,) which always stood leaves."""
        np.multiply(reading, 1.0 - self.b[0], out=self._first)
        np.multiply(reading, self.b[2] - self.a[1], out=self._second)

    def step(self, reading: Floats, out: Floats) -> None:
        """Filter one sample (c,) into ``out`` (c,), which must be another array; allocates nothing."""
        term = self._term
        np.multiply(self._b0, reading, out=out)
        np.add(out, self._first, out=out)
        np.multiply(self._b1, reading, out=self._first)
        np.add(self._first, self._second, out=self._first)
        np.multiply(self._a1, out, out=term)
        np.subtract(self._first, term, out=self._first)
        np.multiply(self._b2, reading, out=self._second)
        np.multiply(self._a2, out, out=term)
        np.subtract(self._second, term, out=self._second)

    def run(self, readings: Floats) -> Floats:
        """Filter a log (n, c) as the loop would, starting settled on its first sample."""
        result = np.empty_like(readings)
        self.settle(readings[0])
        for number, reading in enumerate(readings):
            self.step(reading, result[number])
        return result

    def without_delay(self, readings: Floats) -> Floats:
        """Filter a finished log (n, c) forward and backward: twice the damping, no delay."""
        return np.ascontiguousarray(self.run(np.ascontiguousarray(self.run(readings)[::-1]))[::-1])


def weight_on_sensor(chain: Chain, angles: Floats, sensor: Attachment, mass: float, com: Floats) -> Floats:
    """Return (n, 6) what the weight of a tool beyond the sensor makes it read, as a wrench on the robot, sensor axes.

    Parameters
    ----------
    angles : (n, J) model angles, rad.
    sensor : its axes and origin; on the base: base axes about the base's origin.
    mass : kg of all that hangs on the sensor. com : (3,) its centre in the flange frame, m.
    """
    _, rotation = attached_poses(chain, angles, sensor)
    if sensor.body != 0:
        force = mass * np.einsum("nji,j->ni", rotation, chain.gravity)
        arm = tool_arm(chain, sensor, com)
        return np.concatenate([force, np.cross(arm, force)], axis=1)
    place, turned = attached_poses(chain, angles, Attachment(chain.n_joints + 1, np.eye(4)))
    force = np.broadcast_to(mass * sensor.transform[:3, :3].T @ chain.gravity, place.shape)
    arms = (place + turned @ com - sensor.transform[:3, 3]) @ sensor.transform[:3, :3]
    return np.concatenate([force, np.cross(arms, force)], axis=1)


def tool_arm(chain: Chain, sensor: Attachment, com: Floats) -> Floats:
    """Return (3,) from the origin of a sensor on the last link or flange to a point of the flange frame, sensor axes.

    Raises
    ------
    ValueError : the sensor rides on another body, so that the arm turns with the joints.
    """
    if sensor.body == chain.n_joints + 1:
        flange_from_sensor = sensor.transform
    elif sensor.body == chain.n_joints:
        flange_from_sensor = inverse_transform(chain.flange) @ sensor.transform
    else:
        raise ValueError("a tool's weight can be taken out of a sensor on the flange or the last link only")
    return np.asarray((inverse_transform(flange_from_sensor) @ np.append(com, 1.0))[:3])


def without_tool(
    reading: Floats, chain: Chain, angles: Floats, setup: MeasurementSetup, tool: tuple[float, Floats], zeroed: bool
) -> Floats:
    """Return (n, 6) readings without the weight of the tool beyond the sensor.

    Parameters
    ----------
    reading : (n, 6) on the robot, in the set-up's wrench axes about its wrench point, both of one frame.
    angles : (n, J) model angles, rad.
    tool : mass, kg, and centre in the flange frame, m, of what hangs beyond the sensor.
    zeroed : True where the sensor read zero in the first state, tool and all.
    """
    weight = weight_on_sensor(chain, angles, setup.wrench_axes, *tool)
    return np.asarray(reading - (weight - weight[0] if zeroed else weight))


def weight_matrix(arm: Floats, mass: float) -> Floats:
    """Return (6, 3): a mass's wrench from the direction and size of gravity in sensor axes, m/s²."""
    return np.concatenate([mass * np.eye(3), mass * cross_matrix(arm)])
