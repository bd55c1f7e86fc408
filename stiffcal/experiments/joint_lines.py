"""Straight and curved lines through a joint's own displacements, its 6×6 compliance, and what rises above the noise.

Paper 001 fits eq. 1 to each joint by linear least squares, takes a curve where a straight line does not do, and finds
a clear trend in the rotations and none in the translations. Each run has an offset of its own: the reference reading is
as noisy as the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.experiments.joint_motion import JointMotion

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

COMPONENTS = ("tx", "ty", "tz", "rx", "ry", "rz")
# A compliance rises above the noise where it is more than this many standard uncertainties: of 36 that are nothing one
# in twenty campaigns shows one.
ABOVE_NOISE = 3.0
# Couplings are thirty to a joint and looked for, not expected, and loads of one pose make many of them look alike: more
# is asked of them.
COUPLED = 5.0
# A curve is believed where a straight line would be so bent by chance once in so many joints' components.
CURVED_P = 1e-3
# A direction of the wrench below this share of the largest (lengths scaled by 0.5 m) is not loaded.
UNLOADED = 1e-3
LENGTH_M = 0.5


@dataclass(frozen=True)
class JointLine:
    """One component of a joint's displacement over the same component of its wrench: one of the 36.

    Attributes
    ----------
    component : one of `COMPONENTS`.
    compliance, std : of the straight line, m/N or rad/(N·m); NaN where no load turns it.
    curve : (3,) of δ = c₁ w + c₂ w² + c₃ w³; c₁ alone where a straight line does.
    p_curved : chance of such a bend where there is none.
    scatter : standard deviation of single states about the line that holds, m or rad.
    largest : the largest displacement that the line that holds gives to these loads, m or rad.
    n : states.
    offsets : run number to its offset, m or rad.
    """

    component: str
    compliance: float
    std: float
    curve: tuple[float, float, float]
    p_curved: float
    scatter: float
    largest: float
    n: int
    offsets: dict[int, float]

    @property
    def above_noise(self) -> bool:
        """True where the compliance is told from nothing, and has the sign that a spring's has."""
        return bool(self.compliance > ABOVE_NOISE * self.std)

    @property
    def curved(self) -> bool:
        """True where a straight line does not do."""
        return bool(self.p_curved < CURVED_P)


@dataclass(frozen=True)
class JointCompliance:
    """What one joint's own displacements say of it.

    Attributes
    ----------
    joint : from 1.
    lines : the six components.
    matrix, matrix_std : (6, 6) δ = C w, and standard uncertainties; None where the loads do not turn all directions.
    """

    joint: int
    lines: tuple[JointLine, ...]
    matrix: Floats | None
    matrix_std: Floats | None

    @property
    def couplings(self) -> tuple[tuple[str, str], ...]:
        """Displacements that follow another component of the wrench beyond the noise: (displacement, of which load)."""
        if self.matrix is None or self.matrix_std is None:
            return ()
        told = np.abs(self.matrix) > COUPLED * self.matrix_std
        return tuple((COMPONENTS[a], COMPONENTS[b]) for a, b in np.argwhere(told & ~np.eye(6, dtype=np.bool_)))


def joint_compliance(motion: JointMotion) -> JointCompliance:
    """Fit one joint by itself."""
    lines = tuple(_line(motion, axis) for axis in range(6))
    matrix, std = _matrix(motion)
    return JointCompliance(motion.joint, lines, matrix, std)


def _line(motion: JointMotion, axis: int) -> JointLine:
    seen = np.isfinite(motion.displacement[:, axis])
    load, moved, run = motion.wrench[seen, axis], motion.displacement[seen, axis], motion.run[seen]
    size = float(np.max(np.abs(load), initial=0.0))
    runs = np.unique(run)
    dof = len(load) - len(runs) - 1
    nothing = (math.nan, math.nan, math.nan)
    if size == 0.0 or dof < 3:
        return JointLine(COMPONENTS[axis], math.nan, math.nan, nothing, 1.0, math.nan, 0.0, len(load), {})
    powers = np.stack([(load / size) ** k for k in (1, 2, 3)], axis=1)
    own, left = _about_runs(powers, run), _about_runs(moved[:, None], run)[:, 0]
    straight = float(own[:, 0] @ left / (own[:, 0] @ own[:, 0]))
    bent = np.linalg.lstsq(own, left, rcond=None)[0]
    squares = float(np.sum((left - straight * own[:, 0]) ** 2))
    squares_bent = float(np.sum((left - own @ bent) ** 2))
    p_curved = _chance_of_bend(squares, squares_bent, dof - 2)
    curved = p_curved < CURVED_P
    fitted = bent if curved else np.array([straight, 0.0, 0.0])
    whole = powers @ fitted
    rest = moved - whole
    scatter = math.sqrt((squares_bent if curved else squares) / (dof - 2 if curved else dof))
    std = math.sqrt(squares / dof) / math.sqrt(float(own[:, 0] @ own[:, 0]))
    curve = tuple((fitted / size ** np.arange(1, 4)).tolist())
    return JointLine(
        COMPONENTS[axis], straight / size, std / size, (curve[0], curve[1], curve[2]), p_curved, scatter,
        float(np.max(np.abs(whole))), len(load), {int(k): float(np.mean(rest[run == k])) for k in runs},
    )  # fmt: skip


def _about_runs(values: Floats, run: Integers) -> Floats:
    """Return the values less their runs' means."""
    result = values.copy()
    for k in np.unique(run):
        result[run == k] -= values[run == k].mean(axis=0)
    return result


def _chance_of_bend(straight: float, bent: float, dof: int) -> float:
    """Return the chance that two more powers lower the squares so much where there is no bend: the F test's tail.

    For two degrees of freedom above, the tail has the closed form (1 + 2 F / ν)^(−ν/2).
    """
    if bent <= 0.0:
        return 0.0
    ratio = max(straight - bent, 0.0) / bent
    return float((1.0 + ratio) ** (-dof / 2.0))


def _matrix(motion: JointMotion) -> tuple[Floats | None, Floats | None]:
    """Return the 6×6 compliance and its standard uncertainties, all six wrench components at once."""
    seen = np.isfinite(motion.displacement).all(axis=1)
    run = motion.run[seen]
    own = _about_runs(motion.wrench[seen], run)
    left = _about_runs(motion.displacement[seen], run)
    dof = len(own) - len(np.unique(run)) - 6
    scale = np.repeat([1.0, 1.0 / LENGTH_M], 3)
    if dof < 6:
        return None, None
    singular = np.linalg.svd(own * scale, compute_uv=False)
    if singular[-1] < UNLOADED * singular[0]:
        return None, None
    inverse = np.linalg.inv(own.T @ own)
    matrix = left.T @ own @ inverse
    variance = np.sum((left - own @ matrix.T) ** 2, axis=0) / dof
    return matrix, np.sqrt(np.outer(variance, np.diag(inverse)))
