"""A low-pass for a sensor's noise, as a controller's loop runs it, or over a finished log.

In a loop it looks at the past alone and is late by its group delay; over a finished log it runs forward and backward
and is not late at all.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats


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
            raise ValueError(f"a cut-off of {cutoff_hz:g} Hz is not below half of {rate_hz:g} samples per second")
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
