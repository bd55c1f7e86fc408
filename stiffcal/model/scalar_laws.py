"""Laws of one load and one displacement, as data: a form and its numbers, for code that runs without stiffcal.

A law's `terms` are functions of arrays of states, and nobody can print a Python function as code of a controller. An
effect whose law is not proportional to its load therefore also returns it as one of the forms below
(`Effect.scalar_laws`). `tests/model/test_scalar_laws.py` compares both for every effect that is found.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.model.laws.cubic_curve import angle_of_torque, monotonic_range


class LawForm(Enum):
    """Displacement x over load w; its numbers are in the order in which they stand here."""

    POLYNOMIAL = "polynomial"
    """x = c1 w + c2 w² + c3 w³: c1, c2, c3."""
    CLIPPED = "clipped"
    """x = c clip(w, ±knee): c, knee."""
    POSITIVE = "positive"
    """x = c max(w, 0): c."""
    CROSSING = "crossing"
    """x = h tanh(w / band): h, band."""
    PLAY = "play"
    """x = c P, P ← min(max(P, w − slip), w + slip): c, slip. The only form with a memory."""
    PERIODIC = "periodic"
    """x = (a cos m(q − q0) + b sin m(q − q0)) w, q the model angle of a joint: a, b, m, q0."""
    CUBIC_TORQUE = "cubic torque"
    """w = p1 x + p2 x² + p3 x³, on a tangent outside the range in which this rises: p1, p2, p3."""


@dataclass(frozen=True)
class ScalarLaw:
    """One load, weighted over components of nodes, and one displacement, with the same weights."""

    form: LawForm
    """The formula."""
    numbers: tuple[float, ...]
    """Its numbers, SI."""
    weights: tuple[tuple[int, int, float], ...]
    """(node, component, factor): w = Σ factor × wrench[node, component]; each component moves by factor × x."""
    joint: int = 0
    """Joint whose model angle the law follows, from 1; 0 for none."""

    def respond(self, load: Floats, angle: Floats, memory: Floats | None = None) -> Floats:
        """Return (n,) the displacement.

        Parameters
        ----------
        load : (n,) w, N or N·m.
        angle : (n,) model angle of the law's joint, rad.
        memory : (n,) P before, of laws with a memory; None: one monotonic move from no load.
        """
        numbers = self.numbers
        if self.form is LawForm.POLYNOMIAL:
            return np.asarray(load * (numbers[0] + load * (numbers[1] + load * numbers[2])))
        if self.form is LawForm.CLIPPED:
            return np.asarray(numbers[0] * np.clip(load, -numbers[1], numbers[1]))
        if self.form is LawForm.POSITIVE:
            return np.asarray(numbers[0] * np.maximum(load, 0.0))
        if self.form is LawForm.CROSSING:
            return np.asarray(numbers[0] * np.tanh(load / numbers[1]))
        if self.form is LawForm.PLAY:
            return np.asarray(numbers[0] * self.remembered(load, memory))
        if self.form is LawForm.PERIODIC:
            phase = numbers[2] * (angle - numbers[3])
            return np.asarray((numbers[0] * np.cos(phase) + numbers[1] * np.sin(phase)) * load)
        return angle_of_torque(load, (numbers[0], numbers[1], numbers[2]))

    def remembered(self, load: Floats, memory: Floats | None) -> Floats:
        """Return (n,) what a law with a memory remembers after this load, N or N·m."""
        slip = self.numbers[1]
        before = load - np.clip(load, -slip, slip) if memory is None else memory
        return np.minimum(np.maximum(before, load - slip), load + slip)

    @property
    def straight_between(self) -> tuple[float, float]:
        """Angles, rad, between which a `CUBIC_TORQUE` is the cubic; outside it is a tangent."""
        return monotonic_range((self.numbers[0], self.numbers[1], self.numbers[2]))


@dataclass(frozen=True)
class BalancingSpring:
    """A spring between the link before a joint and the link that it moves, which puts a torque on the drive."""

    joint: int
    """From 1."""
    anchor: tuple[float, float, float]
    """m, in the joint's frame at zero model angle."""
    arm: tuple[float, float, float]
    """m, in the joint's frame, turning with it."""
    rate: float
    """N/m."""
    free_length: float
    """m, at which it does not pull."""

    def length(self, angle: Floats | float) -> Floats:
        """Return (n,) m at model angles (n,), rad."""
        x, y = self._end(angle)
        away = (x - self.anchor[0]) ** 2 + (y - self.anchor[1]) ** 2 + (self.arm[2] - self.anchor[2]) ** 2
        return np.asarray(np.sqrt(away))

    def torque(self, angle: Floats | float) -> Floats:
        """Return (n,) −rate (l − l0) ∂l/∂q, N·m, about the joint's axis at model angles (n,), rad."""
        x, y = self._end(angle)
        length = self.length(angle)
        return np.asarray(-self.rate * (length - self.free_length) * (y * self.anchor[0] - x * self.anchor[1]) / length)

    def _end(self, angle: Floats | float) -> tuple[Floats, Floats]:
        cosine, sine = np.cos(angle), np.sin(angle)
        return cosine * self.arm[0] - sine * self.arm[1], sine * self.arm[0] + cosine * self.arm[1]
