"""Straight and curved lines through a joint's own displacements, its 6×6 compliance, and what rises above the noise.

Paper 001 fits eq. 1 to each joint by linear least squares, takes a curve where a straight line does not do, and finds
a clear trend in the rotations and none in the translations. Each run has an offset of its own: the reference reading is
as noisy as the others. A pose from fewer points counts less.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.bodies.body_results import Component
from stiffcal.identification.bodies.joint_motion import JointMotion

COMPONENTS: tuple[Component, ...] = ("tx", "ty", "tz", "rx", "ry", "rz")
# A compliance rises above the noise where it is more than this many standard uncertainties: of 36 that are nothing one
# in twenty campaigns shows one.
ABOVE_NOISE = 3.0
# Couplings are thirty to a joint and looked for, not expected: a robot that has none shows one in so many campaigns.
FALSE_COUPLINGS = 0.01
# A curve is believed where a straight line would be so bent by chance: of 36 straight ones a curve is found in one
# campaign out of a hundred.
CURVED_P = 0.01 / 36.0
# A direction of the wrench below this share of the largest (lengths scaled by 0.5 m) is not loaded.
UNLOADED = 1e-3
LENGTH_M = 0.5


@dataclass(frozen=True)
class JointLine:
    """One component of a joint's displacement over the same component of its wrench: one of the 36."""

    component: Component
    """One of `COMPONENTS`."""
    compliance: float
    """m/N or rad/(N·m), slope of the straight line; NaN where no load turns it."""
    std: float
    """Standard uncertainty of ``compliance``; NaN where no load turns it."""
    curve: tuple[float, float, float]
    """(3,) of δ = c₁ w + c₂ w² + c₃ w³; c₁ alone where a straight line does."""
    p_curved: float
    """Chance of such a bend where there is none."""
    scatter: float
    """Standard deviation of single states about the line that holds, m or rad."""
    largest: float
    """The largest displacement that the line that holds gives to these loads, m or rad."""
    n: int
    """Number of states."""
    offsets: dict[int, float]
    """Run number to its offset, m or rad."""

    @property
    def above_noise(self) -> bool:
        """True where the compliance differs from zero significantly, and has the sign that a spring's has."""
        return bool(self.compliance > ABOVE_NOISE * self.std)

    @property
    def curved(self) -> bool:
        """True where a straight line does not do."""
        return bool(self.p_curved < CURVED_P)


@dataclass(frozen=True)
class JointComplianceMatrix:
    """What one joint's own displacements give for it."""

    joint: int
    """From 1."""
    lines: tuple[JointLine, ...]
    """The six components."""
    matrix: Floats | None
    """(6, 6) δ = C w; None where the loads do not turn all directions. The diagonal of a curved component is its slope
    at no load.
    """
    matrix_std: Floats | None
    """(6, 6) standard uncertainties of ``matrix``; None where that is."""
    coupled: float
    """Standard uncertainties beyond which an element off the diagonal is no chance (`FALSE_COUPLINGS`)."""

    @property
    def couplings(self) -> tuple[tuple[str, str], ...]:
        """Displacements that follow another component of the wrench beyond the noise: (displacement, of which load)."""
        if self.matrix is None or self.matrix_std is None:
            return ()
        significant = np.abs(self.matrix) > self.coupled * self.matrix_std
        return tuple((COMPONENTS[a], COMPONENTS[b]) for a, b in np.argwhere(significant & ~np.eye(6, dtype=np.bool_)))


def joint_compliance(motion: JointMotion, n_joints: int = 6) -> JointComplianceMatrix:
    """Fit one joint by itself.

    Parameters
    ----------
    n_joints : how many are looked at: couplings are distinguished from chance among those of all.
    """
    lines = tuple(_line(motion, axis) for axis in range(6))
    matrix, std = _matrix(motion, lines)
    coupled = NormalDist().inv_cdf(1.0 - FALSE_COUPLINGS / (2.0 * 30.0 * n_joints))
    return JointComplianceMatrix(motion.joint, lines, matrix, std, coupled)


def _line(motion: JointMotion, axis: int) -> JointLine:
    measured = np.isfinite(motion.displacement[:, axis])
    load, displacement, run = motion.wrench[measured, axis], motion.displacement[measured, axis], motion.run[measured]
    weight = 1.0 / motion.std[measured, axis]
    size = float(np.max(np.abs(load), initial=0.0))
    runs = np.unique(run)
    dof = len(load) - len(runs) - 1
    nothing = (math.nan, math.nan, math.nan)
    if size == 0.0 or dof < 3:
        return JointLine(COMPONENTS[axis], math.nan, math.nan, nothing, 1.0, math.nan, 0.0, len(load), {})
    powers = np.stack([(load / size) ** k for k in (1, 2, 3)], axis=1)
    centred_powers, centred_displacement = (
        _about_runs(powers, run, weight),
        _about_runs(displacement[:, None], run, weight)[:, 0],
    )
    straight = float(centred_powers[:, 0] @ centred_displacement / (centred_powers[:, 0] @ centred_powers[:, 0]))
    curve_fit = np.linalg.lstsq(centred_powers, centred_displacement, rcond=None)[0]
    squares = float(np.sum((centred_displacement - straight * centred_powers[:, 0]) ** 2))
    squares_bent = float(np.sum((centred_displacement - centred_powers @ curve_fit) ** 2))
    p_curved = _chance_of_bend(squares, squares_bent, dof - 2)
    curved = p_curved < CURVED_P
    fitted = curve_fit if curved else np.array([straight, 0.0, 0.0])
    modelled = powers @ fitted
    offsets_left = displacement - modelled
    scatter = math.sqrt((squares_bent if curved else squares) / (dof - 2 if curved else dof))
    std = math.sqrt(squares / dof) / math.sqrt(float(centred_powers[:, 0] @ centred_powers[:, 0]))
    curve = tuple((fitted / size ** np.arange(1, 4)).tolist())
    offsets = {int(k): float(np.average(offsets_left[run == k], weights=weight[run == k] ** 2)) for k in runs}
    return JointLine(
        COMPONENTS[axis], straight / size, std / size, (curve[0], curve[1], curve[2]), p_curved, scatter,
        float(np.max(np.abs(modelled))), len(load), offsets,
    )  # fmt: skip


def _about_runs(values: Floats, run: Integers, weight: Floats) -> Floats:
    """Return weighted rows (n, k) of values less their runs' weighted means."""
    result = np.empty_like(values)
    for k in np.unique(run):
        in_run = run == k
        result[in_run] = (values[in_run] - np.average(values[in_run], axis=0, weights=weight[in_run] ** 2)) * weight[
            in_run, None
        ]
    return result


def _chance_of_bend(straight: float, bent: float, dof: int) -> float:
    """Return the chance that two more powers lower the squares so much where there is no bend: the F test's tail.

    For two degrees of freedom above, the tail has the closed form (1 + 2 F / ν)^(−ν/2).
    """
    if bent <= 0.0:
        return 0.0
    ratio = max(straight - bent, 0.0) / bent
    return float((1.0 + ratio) ** (-dof / 2.0))


def _matrix(motion: JointMotion, lines: Sequence[JointLine]) -> tuple[Floats | None, Floats | None]:
    """Return the 6×6 compliance and its standard uncertainties, all six wrench components at once.

    A curved component keeps its square and cube: what they leave would look like couplings.
    """
    measured = np.isfinite(motion.displacement).all(axis=1)
    run, wrench = motion.run[measured], motion.wrench[measured]
    dof = len(wrench) - len(np.unique(run)) - 8
    scale = np.repeat([1.0, 1.0 / LENGTH_M], 3)
    if dof < 6:
        return None, None
    singular = np.linalg.svd(_about_runs(wrench, run, np.ones(len(run))) * scale, compute_uv=False)
    if singular[-1] < UNLOADED * singular[0]:
        return None, None
    matrix, variance = np.empty((6, 6)), np.empty((6, 6))
    for axis, line in enumerate(lines):
        size = float(np.max(np.abs(wrench[:, axis])))
        curve_columns = [(wrench[:, axis] / size) ** k for k in (2, 3)] if line.curved else []
        weight = 1.0 / motion.std[measured, axis]
        centred_loads = _about_runs(np.column_stack([wrench, *curve_columns]), run, weight)
        centred_displacement = _about_runs(motion.displacement[measured, axis, None], run, weight)[:, 0]
        length = np.sqrt(np.sum(centred_loads**2, axis=0))
        coefficients = np.linalg.lstsq(centred_loads / length, centred_displacement, rcond=None)[0] / length
        inverse = np.linalg.inv((centred_loads / length).T @ (centred_loads / length)) / np.outer(length, length)
        matrix[axis] = coefficients[:6]
        variance[axis] = np.sum((centred_displacement - centred_loads @ coefficients) ** 2) / dof * np.diag(inverse)[:6]
    return matrix, np.sqrt(variance)
