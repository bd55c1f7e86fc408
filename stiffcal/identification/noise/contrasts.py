"""Contrasts of repeats: what readings of like loads differ by, the load's own difference taken out by the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import ROTATION, TRANSLATION
from stiffcal.measurements.load_states import members_of

# Below this nothing is derived from repeats at all: the noise would be known to no better than a third.
LEAST_DOF = 6
# Contrasts beyond this multiple of their median length come from bumped readings.
WILD = 6.0
# So many contrasts determine a standard deviation to one per cent.
MOST_CONTRASTS = 2000


@dataclass(frozen=True)
class Contrasts:
    """Orthonormal contrasts of repeats, the load's difference taken out."""

    differences: Floats
    """(c, m), zero mean under noise alone."""
    compliance: Floats
    """(c, m, 6) the sensitivity that goes with each."""
    run: Integers
    """(c,) the run that each is from."""
    translation: Floats | None = None
    """(c, m), as in `PoseSpread`; None where poses are read."""
    rotation: Floats | None = None
    """(c, m, m), as in `PoseSpread`; None where poses are read."""

    def subset(self, keep: NDArray[np.bool_]) -> Contrasts:
        """Return some of them."""
        selected = Contrasts(self.differences[keep], self.compliance[keep], self.run[keep])
        if self.translation is None or self.rotation is None:
            return selected
        return replace(selected, translation=self.translation[keep], rotation=self.rotation[keep])

    def basis(self, kinds: Integers, scales: Floats) -> Floats | None:
        """Return (kinds, c, m, m) what a unit of each kind's variance makes of scaled contrasts; None: what is usual.

        Parameters
        ----------
        kinds : (m,) of rows.
        scales : (m,) one of each kind, by which its rows were divided.
        """
        if self.translation is None or self.rotation is None:
            return None
        m, products = len(kinds), []
        for kind in np.unique(kinds):
            unit = np.zeros((len(self.differences), m, m))
            if kind == TRANSLATION:
                unit[:, range(m), range(m)] = self.translation
            elif kind == ROTATION:
                unit = self.rotation
            else:
                unit[:, range(m), range(m)] = kinds == kind
            size = float(scales[kinds == kind][0])
            products.append(unit * size**2 / scales[:, None] / scales)
        return np.stack(products)


def contrasts(data: Observations, predicted: Floats, sensitivity: Floats, groups: Sequence[Integers]) -> Contrasts:
    """Return contrasts of repeats.

    Parameters
    ----------
    data : the observations.
    predicted : (m, n) the present model's displacements.
    sensitivity : (m, 6, n).
    groups : positions (in ``data``) of states that repeat each other.
    """
    read = np.asarray(data.measured_mask.all(axis=0))
    groups = [kept for group in groups if len(kept := group[read[group]]) > 1]
    m, c = len(data.measured), sum(len(group) - 1 for group in groups)
    result = Contrasts(np.zeros((c, m)), np.zeros((c, m, 6)), np.zeros(c, dtype=np.int64))
    if data.spread is not None and groups:
        result = replace(result, translation=np.zeros((c, m)), rotation=np.zeros((c, m, m)))
    size = np.array([len(group) for group in groups], dtype=np.int64)
    first = np.cumsum(size - 1) - (size - 1)
    residual = data.measured - predicted
    # groups of one size at once
    for g in np.unique(size):
        alike = np.flatnonzero(size == g)
        members = np.stack([groups[k] for k in alike], axis=1)
        to = first[alike] + np.arange(g - 1)[:, None]
        count = np.arange(1, g).reshape(-1, 1, 1)
        own = np.moveaxis(residual[:, members], 0, -1)
        # Helmert: the k-th member against the mean of those before.
        before = np.cumsum(own[:-1], axis=0) / count
        result.differences[to] = (own[1:] - before) * np.sqrt(count / (count + 1.0))
        lever = np.cumsum(np.moveaxis(sensitivity[:, :, members], (0, 1), (-2, -1)), axis=0)[1:]
        result.compliance[to] = lever / (count[..., None] + 1.0)
        result.run[to] = data.run[members[0]]
        if data.spread is not None and result.translation is not None and result.rotation is not None:
            spread = data.spread
            result.translation[to] = _of_contrasts(np.moveaxis(spread.translation[:, members], 0, -1))
            result.rotation[to] = _of_contrasts(np.moveaxis(spread.rotation[:, :, members], (0, 1), (-2, -1)))
    return result


def _of_contrasts(variance: Floats) -> Floats:
    """Return (g − 1, …) the variances of groups' contrasts from those (g, …) of their members."""
    count = np.arange(1, len(variance)).reshape(-1, *[1] * (variance.ndim - 1))
    before = np.cumsum(variance[:-1], axis=0) / count**2
    return np.asarray((variance[1:] + before) * count / (count + 1.0))


def some_groups(groups: Sequence[Integers]) -> Sequence[Integers]:
    """Return so many groups, drawn at random from a fixed seed, that they hold about `MOST_CONTRASTS` contrasts."""
    n_contrasts = sum(len(group) - 1 for group in groups)
    if n_contrasts <= MOST_CONTRASTS:
        return groups
    n_kept = max(1, len(groups) * MOST_CONTRASTS // n_contrasts)
    return [groups[k] for k in sorted(np.random.default_rng(0).permutation(len(groups))[:n_kept])]


def without_wild(all_contrasts: Contrasts, kinds: Integers) -> Contrasts:
    """Leave out contrasts of readings that were bumped: longer than six times the typical length of their kind.

    Of a hundred thousand contrasts of Gaussian noise less than one is that long. In a run that scatters wider than the
    others as a whole (a target far from the tracker, a shaky stand) its own typical length counts.

    Parameters
    ----------
    kinds : (m,) of rows.
    """
    keep = np.ones(len(all_contrasts.differences), dtype=np.bool_)
    for kind in np.unique(kinds):
        length = np.sqrt(np.sum(all_contrasts.differences[:, kinds == kind] ** 2, axis=1))
        typical = np.full(len(length), np.median(length) if length.any() else np.inf)
        for own in members_of(all_contrasts.run):
            if own.size >= LEAST_DOF:
                typical[own] = np.maximum(typical[own], np.median(length[own]))
        keep &= length <= WILD * typical
    return all_contrasts.subset(keep)
