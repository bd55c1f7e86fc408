"""Torque against angle of one driven joint: spring and play in series, friction between the branches.

The joint's angle is what the arm turns against the motor, φ = φ_a − φ_m (004, section 4.4), its torque what the
surroundings do about the axis. With τ₀ the torque at which the play is crossed (weight, a sensor's zero), P the
spring's cubic (004, Table 2), F the friction between the branches at all angles (physics, section 7) and μ what of it
grows with the load, as it does between teeth:

    φ = φ₀ + x + (b/2) tanh(P(x)/w),    τ = τ₀ + P(x) ± (F + μ |P(x)|) (up, down)

so that P counts its angle x from the flanks, not from the middle of the play. P rises everywhere in the range x₀ … x₁
that was reached: its slope is written in Bernstein's basis there, with end values s₀, s₁ ≥ 0 and a middle value of no
less than −√(s₀ s₁), which gives every quadratic that stays positive between the ends and no other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.kinds.clamped.loops.branches import Branches

# The play is the segment about the crossing whose slope stays below this share of the outer slope.
SLOPE_SHARE = 0.25
# A flank is reached where the spring carries this many times the torque in which the play is crossed.
FLANK_BANDS = 2.0
# Points of the law between its ends; they stand denser towards the crossing.
_LAW_POINTS = 201
_CROWDING = 7.0
# Times that the way between two points of the law is divided by as many, to the last digits.
CLOSER = 6


@dataclass(frozen=True)
class TorqueAngleLaw:
    """Spring, play and friction of one joint."""

    middle: float
    """φ₀, rad: the middle of the play."""
    width: float
    """b, rad: the play."""
    band: float
    """w, N·m: half the torque over the play."""
    zero: float
    """τ₀, N·m: the torque's zero error."""
    friction: float
    """F, N·m: half the torque between the branches."""
    lag: float
    """rad by which the torque stays behind the angle (two clocks)."""
    curve: tuple[float, float, float]
    """(3,) p1, p2, p3 in N·m/rad, N·m/rad², N·m/rad³."""
    reach: tuple[float, float]
    """x₀, x₁, rad: the spring's angles that were reached, counted from the flanks."""
    drag: float = 0.0
    """μ, friction that grows with the load, as a share of it."""

    def spring(self, x: Floats) -> Floats:
        """Return P(x), N·m, at angles counted from the flank, rad."""
        p1, p2, p3 = self.curve
        return np.asarray(x * (p1 + x * (p2 + x * p3)))

    def tangent(self, x: Floats) -> Floats:
        """Return dP/dx, N·m/rad."""
        p1, p2, p3 = self.curve
        return np.asarray(p1 + x * (2.0 * p2 + x * 3.0 * p3))

    @property
    def flank_not_reached(self) -> str:
        """The flank of the play, "upper" or "lower", that the motion did not reach; "" where both were."""
        ends = self.spring(np.array(self.reach))
        for side, end in (("lower", -float(ends[0])), ("upper", float(ends[1]))):
            if end < FLANK_BANDS * self.band:
                return side
        return ""

    def grid(self) -> tuple[Floats, Floats]:
        """Return angle (k,) and torque (k,) of the law without friction, both rising, over what was reached."""
        _, angle, torque = self._spring_grid()
        return angle, torque

    def _spring_grid(self) -> tuple[Floats, Floats, Floats]:
        """Return (k,) the spring's angle from the flank, and what `grid` returns."""
        low, high = self.reach
        # a margin: where the crossing is broad, the spring is reached a little further
        margin, shares = 0.02 * (high - low), crowded(_LAW_POINTS // 2 + 1)
        x = np.concatenate([(low - margin) * shares[:0:-1], (high + margin) * shares])
        torque = self.spring(x)
        half = len(x) // 2
        torque[half:] = np.maximum.accumulate(torque[half:])
        torque[half::-1] = np.minimum.accumulate(torque[half::-1])
        return x, self.middle + x + 0.5 * self.width * np.tanh(torque / self.band), self.zero + torque

    def angle(self, x: Floats) -> Floats:
        """Return φ, rad, at the spring's angles (k,) from the flank, rad."""
        return np.asarray(self.middle + x + 0.5 * self.width * np.tanh(self.spring(x) / self.band))

    def slope(self, x: Floats) -> Floats:
        """Return dτ/dφ, N·m/rad, of spring and play in series at the spring's angles (k,) from the flank, rad.

        P′/(1 + ½ w sech²(P/b) P′/b); 0 past the turn of a printed cubic, which goes on level as in `grid`.
        """
        tangent = np.maximum(self.tangent(x), 0.0)
        crossed = 0.5 * self.width * (1.0 - np.tanh(self.spring(x) / self.band) ** 2) / self.band
        return np.asarray(tangent / (1.0 + crossed * tangent))

    def torque_at(self, angle: Floats, up: NDArray[np.bool_]) -> Floats:
        """Return (m,) the torque on the branches, N·m."""
        grid, torque = self.grid()
        sign = np.where(up, 1.0, -1.0)
        even = np.interp(angle - sign * self.lag, grid, torque)
        return np.asarray(even + sign * (self.friction + self.drag * np.abs(even - self.zero)))

    def slopes(self, angle: Floats, up: NDArray[np.bool_]) -> Floats:
        """Return (m, 10) derivatives of `torque_at` by middle, width, log band, zero, friction, lag, drag, p1, p2, p3.

        The angle α = c + x + ½ w tanh(P/b) is kept: with k = ½ w sech²(P/b)/b and dP = P′ dx + x dp1 + x² dp2 + x³ dp3,
        dP (1 + k P′) = x dp1 + x² dp2 + x³ dp3 − P′ (s dlag + dc + ½ tanh dw − k P d ln b).
        """
        spring, grid, torque = self._spring_grid()
        sign = np.where(up, 1.0, -1.0)
        at = angle - sign * self.lag
        x, even = np.interp(at, grid, spring), np.interp(at, grid, torque) - self.zero
        shape = np.tanh(even / self.band)
        k = 0.5 * self.width * (1.0 - shape**2) / self.band
        # past its turn a printed cubic goes on level, as in `grid`
        tangent = np.maximum(self.tangent(x), 0.0)
        of_angle, of_curve = -tangent / (1.0 + k * tangent), 1.0 / (1.0 + k * tangent)
        direct = 1.0 + sign * self.drag * np.sign(even)
        by_spring = np.stack(
            [of_angle, 0.5 * shape * of_angle, -k * even * of_angle, sign * of_angle, x * of_curve, x**2 * of_curve,
             x**3 * of_curve]
        )  # fmt: skip
        middle, width, band, lag, *curve = by_spring * direct
        columns = [middle, width, band, np.ones_like(x), sign, lag, sign * np.abs(even), *curve]
        return np.stack(columns, axis=1)

    def width_correction(self, data: Branches) -> float:
        """Return by how much a few branches would have the play wider: one Gauss-Newton step, middle and zero free."""
        slopes = self.slopes(data.angle, data.up)
        # width, middle, zero, friction
        columns = slopes[:, [1, 0, 3, 4]]
        base = self.torque_at(data.angle, data.up)
        sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        answer, *_ = np.linalg.lstsq(columns / sizes, data.torque - base, rcond=1e-8)
        return float(answer[0] / sizes[0])


@dataclass(frozen=True)
class PlaySegment:
    """The segment about the crossing where the slope stays low."""

    low: float
    """rad, where the segment begins."""
    high: float
    """rad, where it ends."""
    band: float
    """N·m, half the torque that it takes."""
    outer_slope: float
    """N·m/rad, the slope outside that the slope inside is compared with."""

    @property
    def length(self) -> float:
        """The play, rad."""
        return self.high - self.low


def play_segment(law: TorqueAngleLaw, share: float = SLOPE_SHARE) -> PlaySegment | None:
    """Return the segment about the crossing whose slope stays below `share` of the outer slope; None without one.

    The outer slope is the chord from the flanks to the ends of what was reached, both sides together. The law stands
    for both branches: friction shifts them in torque and leaves their slopes alike.
    """
    low, high = law.reach
    first, last = law.spring(np.array(law.reach))
    outer = float(last - first) / max(high - low, 1e-15)
    if law.slope(np.zeros(1))[0] >= share * outer:
        return None
    ends = np.array([_where_steep(law, end, share * outer) for end in law.reach])
    angle, torque = law.angle(ends), law.spring(ends)
    return PlaySegment(float(angle[0]), float(angle[1]), 0.5 * float(torque[1] - torque[0]), outer)


def _where_steep(law: TorqueAngleLaw, end: float, slope: float) -> float:
    """Return the spring's angle from the flank, rad, at which the law first gets as steep on the way to ``end``.

    ``end`` itself where it does not. The points of the law lie denser than it bends; those between two of them are
    looked at again.
    """
    x = end * crowded(_LAW_POINTS // 2 + 1)
    for _ in range(CLOSER):
        steep = np.flatnonzero(law.slope(x) >= slope)
        if not steep.size:
            return end
        x = np.linspace(x[steep[0] - 1], x[steep[0]], _LAW_POINTS)
    return float(x.mean())


def crowded(count: int) -> Floats:
    """Return (k,) shares from 0 to 1, denser towards 0, where a play is crossed."""
    return np.asarray(np.sinh(_CROWDING * np.linspace(0.0, 1.0, count)) / np.sinh(_CROWDING))
