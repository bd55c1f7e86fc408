"""What each reading counts: the noise that is known, carried through the model, as weights for a fit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.derivatives.observation import Evaluation, Observations, evaluate
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import (
    ENOUGH_DOF,
    Noise,
    Whitening,
    noise_from_repeats,
    whiten,
    with_stated_places,
)
from stiffcal.identification.noise.wrench_correction import along_sweep
from stiffcal.identification.readings.row_layout import MOTOR, N_KINDS
from stiffcal.model.assembled.composite import CompliantRobot

# Huber's k: beyond this multiple of the typical length a reading counts less.
HUBER_LIMIT = 2.5


@dataclass(frozen=True)
class Weights:
    """Weights of the observations and where they come from."""

    noise: Noise | None
    """What is known of the noise, or None."""
    assumed: Noise
    """What the weights were made from: the noise, or the size of residuals where nothing is known."""
    carried: bool
    """True where the wrench's noise was carried through the model into the weights."""
    whitening: Whitening
    """The weights."""
    sensitivity: Floats | None
    """(m, 6, n) by which it was carried, or None."""


def needs_wrench_sensitivity(stated: Noise | None) -> bool:
    """Return whether the weights, or the noise to be estimated, depend on how the wrench moves the model."""
    return stated is None or stated.of_wrench


def estimate_weights(
    data: Observations,
    blocks: Sequence[Evaluation],
    groups: Sequence[Integers],
    stated: Noise | None,
    stated_noise: Noise | None,
    equal: bool,
) -> Weights:
    """Find the noise with the present model, and the weights that follow from it.

    Parameters
    ----------
    data : the observations.
    blocks : the present model's prediction of them, with its sensitivity where `needs_wrench_sensitivity`.
    groups : positions of states that repeat each other.
    stated : the manifest's noise, or None.
    stated_noise : noise to take instead of all that the data give, or None.
    equal : leave the wrench's share out of the weights.
    """
    if stated_noise is not None and not needs_wrench_sensitivity(stated_noise):
        return Weights(stated_noise, stated_noise, False, whiten(stated_noise, data, None), None)
    predicted = np.concatenate([block.predicted for block in blocks], axis=1)
    sensitivity = np.concatenate([block.sensitivity for block in blocks if block.sensitivity is not None], axis=2)
    sensitivity = along_the_sweep(sensitivity, data)
    noise = stated_noise
    if noise is None:
        repeats = noise_from_repeats(data, predicted, sensitivity, groups)
        enough = repeats is not None and (repeats.dof >= ENOUGH_DOF or stated is None)
        noise = with_stated_places(repeats, stated, data) if enough and repeats is not None else stated
    if noise is not None and not equal:
        return Weights(noise, noise, True, whiten(noise, data, sensitivity), sensitivity)
    assumed = raw_noise(data, noise) if equal else residual_noise(data, predicted)
    return Weights(noise, assumed, False, whiten(assumed, data, None), None)


def weighed_alike(
    weights: Weights, data: Observations, blocks: Iterable[Evaluation]
) -> tuple[Weights, Iterator[Evaluation]]:
    """Return weights from the noise behind others, made while the model's blocks go by.

    The weights are complete up to the block that was last taken from the iterator.

    Parameters
    ----------
    weights : whose noise is taken over.
    data : the observations to weigh.
    blocks : the model's prediction of them, with its sensitivity where the wrench's noise is carried.
    """
    if not weights.carried:
        return Weights(weights.noise, weights.assumed, False, whiten(weights.assumed, data, None), None), iter(blocks)
    m, n = data.measured.shape
    noise, sensitivity = weights.assumed, np.empty((m, 6, n))
    correlated = noise.of_wrench or data.spread is not None
    whitening = Whitening(np.empty((m, n)), np.empty((m, m, n)) if correlated else None)

    def one_by_one() -> Iterator[Evaluation]:
        for block in blocks:
            own = data.subset(block.states)
            carried = None if block.sensitivity is None else along_the_sweep(block.sensitivity, own)
            local = whiten(noise, own, carried)
            whitening.scale[:, block.states] = local.scale
            if whitening.lower is not None and local.lower is not None:
                whitening.lower[:, :, block.states] = local.lower
            sensitivity[:, :, block.states] = carried
            yield block

    return Weights(weights.noise, noise, True, whitening, sensitivity), one_by_one()


def along_the_sweep(sensitivity: Floats, data: Observations) -> Floats:
    """Return a clamped robot's sensitivity to the wrench, averaged over states at like motor angles.

    Where wrenches were corrected (`wrench_correction`) it stays: there they are where they lie most probably.

    In a play it falls from steep to nothing within a few N·m. Taken at the wrench as read, a reading that noise drove
    out of the play would count more than one that noise drove in, and the crossing would come out too broad. The
    motor's angle, not the force, is what is well known there.

    Parameters
    ----------
    sensitivity : (m, 6, n).
    data : the observations, whole runs.
    """
    motors = data.rows_of(MOTOR)
    clamped = np.asarray(data.measured_mask[motors].any(axis=0), dtype=np.bool_)
    if not clamped.any() or data.correction is not None:
        return sensitivity
    smooth = sensitivity.copy()
    for row in motors:
        for axis in range(6):
            smooth[row, axis] = along_sweep(sensitivity[row, axis], data, clamped)
    return smooth


def raw_noise(data: Observations, noise: Noise | None) -> Noise:
    """Return noise for a first look: the known one, or each kind of component by its own size."""
    if noise is not None:
        return noise
    return Noise.of_kinds(_size_of_kinds(data.measured, data), (0.0, 0.0), "none", 0.0)


def _size_of_kinds(values: Floats, data: Observations) -> Floats:
    """Return the rms of each kind of row, 1 where there is none."""
    size = np.ones(N_KINDS)
    for kind in np.unique(data.kind):
        rows = data.kind == kind
        readings = values[rows][data.measured_mask[rows]]
        if readings.size and readings.any():
            size[kind] = np.sqrt(np.mean(readings**2))
    return size


def raw_whitening(data: Observations, noise: Noise | None) -> Whitening:
    """Return weights for a first look: the stated noise, or each kind of component by its own size."""
    return whiten(raw_noise(data, noise), data, None)


def residual_noise(data: Observations, predicted: Floats) -> Noise:
    """Return the size of the residuals of each kind of row, where nothing better is known of the noise."""
    residual = without_offsets(data, predicted, raw_whitening(data, None))
    return Noise.of_kinds(_size_of_kinds(residual, data), (0.0, 0.0), "none", 0.0)


def predict_observations(robot: CompliantRobot, data: Observations) -> Floats:
    """Return (m, n) the model's displacements."""
    return np.concatenate([block.predicted for block in evaluate(robot, data)], axis=1)


def offset_free_residual(robot: CompliantRobot, data: Observations, whitening: Whitening) -> Floats:
    """Return (m, n) measured minus predicted, each run's weighted mean taken out where runs carry offsets."""
    return without_offsets(data, predict_observations(robot, data), whitening)


def without_offsets(data: Observations, predicted: Floats | None, whitening: Whitening) -> Floats:
    """Return (m, n) measured minus predicted (nothing: measured alone), runs' offsets taken out, 0 where none."""
    residual = np.where(data.measured_mask, data.measured - (0.0 if predicted is None else predicted), 0.0)
    return np.asarray(Projection.of(data, whitening).centred(residual[None])[0])


def huber_whitening(full: Whitening, last: Whitening, data: Observations, predicted: Floats) -> Whitening:
    """Return weights lowered for readings whose whitened length is beyond 2.5 times the typical one.

    Translation and rotation of a reading, gauges and rods are judged apart. The median sets the scale: it bears wild
    readings, also where they have swollen the noise determined from repeats.

    Parameters
    ----------
    full : weights of readings as they should be.
    last : the lowered weights of the last step, which the runs' offsets are taken with.
    data, predicted : the observations and the model's prediction of them.
    """
    white = full.apply(without_offsets(data, predicted, last))
    factor = np.ones_like(data.measured)
    for kind in np.unique(data.kind):
        rows = data.kind == kind
        length = np.sqrt(np.sum(white[rows] ** 2, axis=0))
        if length.any():
            scale = HUBER_LIMIT * float(np.median(length))
            factor[rows] = np.sqrt(np.minimum(1.0, scale / np.maximum(length, 1e-300)))
    return Whitening(full.scale * factor, None if full.lower is None else full.lower * factor[:, None])
