"""How noisy the readings are: from repeats of the same load, else from what the manifest states.

The scatter of repeats has four sources: the tracker's translation and rotation, and the force sensor's force and moment
carried through the robot's compliance S (with gauges or rods: theirs next to the tracker's). Repeats never hit the same
load, so the model's displacement is subtracted first: of two like loads it only has to hold to a few per cent. With d a
contrast of a group of repeats (coefficients that sum to zero, squares that sum to one):

    d ~ N(0, σ_t² I_t + σ_r² I_r + S (σ_F² I_F + σ_M² I_M) Sᵀ)

and the variances follow by maximum likelihood (Searle, Casella and McCulloch, Variance Components, 1992, ch. 6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.noise.contrasts import LEAST_DOF, contrasts, some_groups, without_wild
from stiffcal.identification.noise.noise_source import NoiseSource
from stiffcal.identification.noise.variance_components import variance_components
from stiffcal.identification.readings.observations import ClampedSigma, Observations
from stiffcal.identification.readings.row_layout import (
    GAUGE,
    LENGTH,
    MEASURES,
    MOTOR,
    N_KINDS,
    OPTIONAL,
    ROTATION,
    TRANSLATION,
    layout_of,
)
from stiffcal.measurements.load_states import Sigma

# m and rad: repeats that agree to what a balance is found to are copies, and carry no information on the noise.
LEAST_SCATTER = 1e-12

# With fewer degrees of freedom the scatter of repeats is itself known to no better than 18 %, and the manifest's word
# is taken instead where it gives one.
ENOUGH_DOF = 30


@dataclass(frozen=True)
class Noise:
    """Standard uncertainty of one load state, per component."""

    translation: float
    """m, of the measured displacement."""
    rotation: float
    """rad, of the measured displacement."""
    force: float
    """N, of the wrench."""
    moment: float
    """N·m, of the wrench."""
    source: NoiseSource
    """"repeats", "manifest" or "none"."""
    dof: float
    """Degrees of freedom behind it; infinite for the manifest's word."""
    gauge: float = 0.0
    """m, of gauges."""
    length: float = 0.0
    """m, of rods."""
    motor_angle: float = 0.0
    """rad, of clamped motors' angles."""
    clamped_wrench: tuple[float, float] | None = None
    """Of force and moment in clamped states, N and N·m, where it is not that of the others: a sweep averages fewer
    readings than a hold. None: alike.
    """
    absolute: tuple[float, float] | None = None
    """Of translation and rotation of absolute places, m and rad, where it is not that of the others: repeated loads
    scatter by how well they were set as well, and a place is often one reading. None: alike.
    """

    @classmethod
    def of_kinds(cls, sizes: Floats, wrench: tuple[float, float], source: NoiseSource, dof: float) -> Noise:
        """Make noise from sizes by kind of row (`identification.readings.row_layout`), and of force and moment."""
        return cls(
            float(sizes[TRANSLATION]), float(sizes[ROTATION]), *wrench, source, dof,
            float(sizes[GAUGE]), float(sizes[LENGTH]), float(sizes[MOTOR]),
        )  # fmt: skip

    def of_rows(self, kind: Integers) -> Floats:
        """Return (m,) the standard uncertainty of rows by their kind."""
        return np.array([self.translation, self.rotation, self.gauge, self.length, self.motor_angle])[kind]

    @property
    def of_wrench(self) -> bool:
        """True where the wrench has a noise of its own."""
        return any((self.force, self.moment, *(self.clamped_wrench or ())))

    def of_wrenches(self, data: Observations) -> Floats:
        """Return (6, n) the standard uncertainty of the wrenches, N and N·m."""
        size = np.repeat([[self.force], [self.moment]], 3, axis=0) * np.ones(data.n_states)
        if self.clamped_wrench is not None:
            clamped = data.measured_mask[data.kind == MOTOR].any(axis=0)
            size[:, clamped] = np.repeat([[self.clamped_wrench[0]], [self.clamped_wrench[1]]], 3, axis=0)
        if data.clamped is not None:
            size = np.where(np.isfinite(data.clamped.wrench), data.clamped.wrench, size)
        # Where the robot has no load there is none to be uncertain of.
        size[:, data.absolute & ~data.wrench.any(axis=0)] = 0.0
        return np.asarray(size)


@dataclass(frozen=True)
class Whitening:
    """What turns residuals into independent numbers of unit variance."""

    scale: Floats
    """(m, n) 1/σ where the covariance is diagonal; zero where nothing was measured."""
    lower: Floats | None = None
    """(m, m, n) inverse of the covariance's Cholesky factor, or None where it is diagonal."""

    @property
    def diagonal(self) -> bool:
        """True where components are independent."""
        return self.lower is None

    def subset(self, pick: slice | NDArray[np.bool_] | Integers) -> Whitening:
        """Return the whitening of some states."""
        return Whitening(self.scale[:, pick], None if self.lower is None else self.lower[:, :, pick])

    def apply(self, stack: Floats) -> Floats:
        """Whiten (k, m, n) or (m, n) stacks."""
        if self.lower is None:
            return np.asarray(stack * self.scale)
        return _lower_times(self.lower, stack)

    def precision(self) -> Floats:
        """Return the inverse covariances (m, m, n)."""
        if self.lower is None:
            m, n = self.scale.shape
            result = np.zeros((m, m, n))
            result[range(m), range(m)] = self.scale**2
            return result
        m = len(self.lower)
        result = np.empty_like(self.lower)
        for a in range(m):
            for b in range(a + 1):
                # the factor is lower triangular: rows above a are zero
                result[a, b] = result[b, a] = np.einsum("cn,cn->n", self.lower[a:, a], self.lower[a:, b])
        return result


def _lower_times(matrix: Floats, stack: Floats) -> Floats:
    """Return matrix @ stack for (m, m, n) lower triangular matrices and (…, m, n) stacks, state by state."""
    m = len(matrix)
    result = np.empty_like(stack)
    term = np.empty_like(stack[..., 0, :])
    for a in range(m):
        np.multiply(stack[..., 0, :], matrix[a, 0], out=result[..., a, :])
        for b in range(1, a + 1):
            np.multiply(stack[..., b, :], matrix[a, b], out=term)
            result[..., a, :] += term
    return result


def covariance(noise: Noise, data: Observations, sensitivity: Floats | None) -> Floats:
    """Return the covariance (m, m, n) of the observations, wrench noise carried through the model included.

    Parameters
    ----------
    noise : the instruments'.
    data : the observations.
    sensitivity : (m, 6, n) derivative of the prediction by the wrench, or None to leave wrench noise out.
    """
    m = len(data.measured)
    result = np.zeros((m, m, data.n_states))
    result[range(m), range(m)] = own_variance(noise, data)
    if data.spread is not None:
        turns = np.full(data.n_states, noise.rotation)
        if noise.absolute is not None:
            turns[data.absolute] = noise.absolute[1]
        rotation_part = turns**2 * data.spread.rotation
        rotation_part[range(m), range(m)] = 0.0
        result += rotation_part
    if sensitivity is not None:
        weighted = sensitivity * noise.of_wrenches(data) ** 2
        for a in range(m):
            for b in range(a + 1):
                shared = np.einsum("kn,kn->n", weighted[a], sensitivity[b])
                result[a, b] += shared
                if a != b:
                    result[b, a] += shared
    return result


def own_variance(noise: Noise, data: Observations) -> Floats:
    """Return (m, n) the variances of the rows without the wrench's share."""
    variance: Floats = np.repeat(noise.of_rows(data.kind)[:, None] ** 2, data.n_states, axis=1)
    sizes = np.repeat([[noise.translation], [noise.rotation]], data.n_states, axis=1)
    if noise.absolute is not None:
        sizes[:, data.absolute] = np.array(noise.absolute)[:, None]
        poses = data.kind <= ROTATION
        variance[poses] = sizes[data.kind[poses]] ** 2
    if data.clamped is not None:
        motors = data.rows_of(MOTOR)
        variance[motors] = np.where(np.isfinite(data.clamped.motor), data.clamped.motor**2, variance[motors])
    if data.spread is not None:
        rows = data.kind <= ROTATION
        rotation_spread = np.einsum("aan->an", data.spread.rotation)[rows]
        variance[rows] = sizes[0] ** 2 * data.spread.translation[rows] + sizes[1] ** 2 * rotation_spread
    return variance


def whiten(noise: Noise, data: Observations, sensitivity: Floats | None) -> Whitening:
    """Return the whitening of the observations."""
    scale = np.where(data.measured_mask, 1.0 / np.sqrt(own_variance(noise, data)), 0.0)
    exact = sensitivity is None or not noise.of_wrench
    if exact and data.spread is None:
        return Whitening(scale)
    full = covariance(noise, data, sensitivity)
    unmeasured = ~data.measured_mask
    if unmeasured.any():
        full = np.where(unmeasured[:, None] | unmeasured[None], 0.0, full)
        full[range(len(full)), range(len(full))] += unmeasured
    # Components are scaled to unit variance first: metres and radians differ by orders.
    deviation = np.sqrt(np.einsum("aan->an", full))
    lower = _inverse_cholesky(full / deviation[:, None] / deviation[None]) / deviation[None]
    if unmeasured.any():
        lower = np.where(unmeasured[:, None] | unmeasured[None], 0.0, lower)
    return Whitening(scale, lower)


def _inverse_cholesky(full: Floats) -> Floats:
    """Return the inverses (m, m, n) of the Cholesky factors of (m, m, n) covariances, state axis last."""
    m = len(full)
    factor, inverse = np.zeros_like(full), np.zeros_like(full)
    for a in range(m):
        for b in range(a):
            known = np.einsum("cn,cn->n", factor[a, :b], factor[b, :b])
            factor[a, b] = (full[a, b] - known) * inverse[b, b]
        pivot = full[a, a] - np.einsum("cn,cn->n", factor[a, :a], factor[a, :a])
        if not np.all(pivot > 0.0):
            raise np.linalg.LinAlgError("a covariance of the observations is not positive definite")
        inverse[a, a] = 1.0 / np.sqrt(pivot)
        for b in range(a):
            inverse[a, b] = -np.einsum("cn,cn->n", factor[a, b:a], inverse[b:a, b]) * inverse[a, a]
    return inverse


def rms_length(noise: Noise, data: Observations, sensitivity: Floats | None) -> dict[str, float | None]:
    """Return the noise as rms means it: root mean square length of the noise vector, m and rad."""
    variance = own_variance(noise, data)
    if sensitivity is not None:
        variance = variance + np.einsum("akn,akn,kn->an", sensitivity, sensitivity, noise.of_wrenches(data) ** 2)
    return rms_by_measure(variance, data)


def rms_by_measure(squares: Floats, data: Observations) -> dict[str, float | None]:
    """Return √(mean over readings of the summed squares) of translation and rotation, and of rods where there are some.

    None where not measured. A target's three components are one reading, a gauge's one; every rod is a reading of its
    own: "length" is what one rod is off by, as a rule.

    Parameters
    ----------
    squares : (m, n) what is summed where it was measured.
    """
    rms_of: dict[str, float | None] = {}
    for measure, kinds in MEASURES.items():
        rows = np.isin(data.kind, kinds)
        if rows.any() or measure not in OPTIONAL:
            n_vectors = sum(
                int(np.count_nonzero(data.measured_mask[vector].any(axis=0))) for vector in reading_rows(data, rows)
            )
            total = float(np.sum(np.where(data.measured_mask[rows], squares[rows], 0.0)))
            rms_of[measure] = float(np.sqrt(total / n_vectors)) if n_vectors else None
    return rms_of


def reading_rows(data: Observations, rows: NDArray[np.bool_]) -> list[NDArray[np.bool_]]:
    """Return the rows that belong to one reading, reading by reading."""
    # gauges and rods are readings of their own
    component = np.where((data.kind <= ROTATION) | (data.kind == MOTOR), -1, data.component)
    key = np.stack([data.kind, data.body, component])
    return [rows & (key == key_values[:, None]).all(axis=0) for key_values in np.unique(key[:, rows], axis=1).T]


def noise_from_repeats(
    data: Observations, predicted: Floats, sensitivity: Floats, groups: Sequence[Integers]
) -> Noise | None:
    """Estimate the noise levels from repeats by maximum likelihood; None where repeats are too few.

    Parameters
    ----------
    data : the observations.
    predicted : (m, n) the present model's displacements.
    sensitivity : (m, 6, n) of the present model.
    groups : positions of states that repeat each other.
    """
    motors = data.kind == MOTOR
    if motors.all() and motors.any() and data.clamped is not None:
        return noise_of_clamped(data.clamped)
    if motors.any() and not motors.all():
        return _of_two_experiments(data, predicted, sensitivity, groups, motors)
    # of a robot that nothing loads but its own weight no wrench is uncertain
    sensitivity = np.where(data.absolute & ~data.wrench.any(axis=0), 0.0, sensitivity)
    plain = without_wild(contrasts(data, predicted, sensitivity, some_groups(groups)), data.kind)
    differences, levers = plain.differences, plain.compliance
    n_lengths = int(np.count_nonzero(~data.rotational))
    if len(differences) * n_lengths < LEAST_DOF:
        return None
    kinds = np.unique(data.kind)
    raw = np.zeros(N_KINDS)
    raw[kinds] = [np.sqrt(np.mean(differences[:, data.kind == kind] ** 2)) for kind in kinds]
    scales = raw[data.kind]
    if np.any(scales < LEAST_SCATTER):
        return None
    basis = plain.basis(data.kind, scales)
    variance = variance_components(differences / scales, levers / scales[:, None], data.kind, basis)
    # The components are in units of the raw scatter; wrench components were scaled to their share of it.
    raw[kinds] *= np.sqrt(variance[: len(kinds)])
    wrench = float(np.sqrt(variance[-2])), float(np.sqrt(variance[-1]))
    return Noise.of_kinds(raw, wrench, "repeats", float(differences.size))


def _of_two_experiments(
    data: Observations, predicted: Floats, sensitivity: Floats, groups: Sequence[Integers], motors: NDArray[np.bool_]
) -> Noise | None:
    """Estimate the noise of load states and of clamped ones each from their own repeats: no state reads both."""
    noises = []
    for rows in (~motors, motors):
        load_noise = replace(
            data,
            measured=data.measured[rows],
            measured_mask=data.measured_mask[rows],
            layout=layout_of(data.kind[rows].tolist(), data.body[rows].tolist(), data.component[rows].tolist()),
            spread=None if data.spread is None else data.spread.rows(rows),
        )
        noises.append(noise_from_repeats(load_noise, predicted[rows], sensitivity[rows], groups))
    load, clamped = noises
    if load is None or clamped is None:
        return None
    dof = min(load.dof, clamped.dof)
    wrench = clamped.clamped_wrench or (clamped.force, clamped.moment)
    return replace(load, motor_angle=clamped.motor_angle, clamped_wrench=wrench, dof=dof)


def noise_of_clamped(sigma: ClampedSigma) -> Noise:
    """Return the noise of clamped runs: each state's own, here its typical size."""
    known = np.isfinite(sigma.motor)
    force, moment = (float(np.sqrt(np.mean(sigma.wrench[rows][:, known] ** 2))) for rows in (slice(0, 3), slice(3, 6)))
    motor = float(np.sqrt(np.mean(sigma.motor[known] ** 2)))
    return Noise(0.0, 0.0, 0.0, 0.0, "neighbours", sigma.dof, motor_angle=motor, clamped_wrench=(force, moment))


def stated_noise(sigma: Sigma, data: Observations) -> Noise | None:
    """Return the manifest's noise, or None where it does not give what these observations need."""
    # in the order of the kinds of rows
    stated = (sigma.translation, sigma.rotation, sigma.gauge, sigma.length, sigma.motor_angle)
    if any(stated[kind] is None for kind in np.unique(data.kind)):
        return None
    sizes = np.array([size or 0.0 for size in stated])
    noise = Noise.of_kinds(sizes, (sigma.force or 0.0, sigma.moment or 0.0), "manifest", np.inf)
    if not data.absolute.any() or sigma.absolute_translation is sigma.absolute_rotation is None:
        return noise
    absolute = sigma.absolute_translation or noise.translation, sigma.absolute_rotation or noise.rotation
    return replace(noise, absolute=absolute)


def with_stated_places(noise: Noise, stated: Noise | None, data: Observations) -> Noise:
    """Return noise from repeated loads with that of absolute places as it is stated: no place is repeated.

    Parameters
    ----------
    noise : from repeats of load states.
    stated : the manifest's; None where it does not give it, and places then count like load states.
    """
    if stated is None or not data.absolute.any():
        return noise
    return replace(noise, absolute=stated.absolute or (stated.translation, stated.rotation))
