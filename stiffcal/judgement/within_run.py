"""Mistakes inside a run: a target that was knocked and put back, a force sensor that was zeroed anew.

A step to the end of a run is `seat-shift`, an effect; a zero of the sensor that moves there does the same in one pose.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.slips import best_slip
from stiffcal.judgement.decomposition import thin_svd
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.numbers import INTERVALS_KEPT, LEAST_INTERVAL, LEAST_OF_MISTAKE, MOST_EDGES


class MistakeInRun(Enum):
    """What went wrong."""

    MOVED = "target moved for a while"
    ZERO = "force sensor zeroed anew"


@dataclass(frozen=True)
class InRun:
    """A mistake inside a run."""

    kind: MistakeInRun
    """What went wrong."""
    run: int
    """Number of the run."""
    rows: Floats
    """(d, r) whitened columns, together of rms one over the run's rows."""
    log_share: float
    """Logarithm of the share that these states have of all where it may begin and end."""

    @property
    def name(self) -> str:
        """In words."""
        return f"{self.kind.value} in run {self.run}"


def mistakes_in_runs(ground: GroundOfStates) -> Iterator[InRun]:
    """Give those that explain most of what a model leaves, in runs of displacements that have no zero of their own."""
    if not ground.space.data.free_offset:
        return
    yield from _zeroed(ground)
    yield from _moved_for_a_while(ground)


def _zeroed(ground: GroundOfStates) -> Iterator[InRun]:
    """Give the zero that moves where a step explains most: loads are off by a constant from there to the run's end."""
    data = ground.space.data
    first = best_slip(ground.space, ground.residual)
    if first is None:
        return
    run = int(data.run[first])
    own = np.flatnonzero(data.run == run)
    after = own[own >= first]
    moved = np.zeros((6, *data.measured.shape))
    slopes = ground.state.tangents.reading_rows()
    moved[:, :, after] = np.moveaxis(slopes[:, :, after], 1, 0)
    rows = _independent(ground.space.rows(moved), len(own) * len(data.measured))
    if len(rows):
        yield InRun(MistakeInRun.ZERO, run, rows, -float(np.log(len(own))))


def _moved_for_a_while(ground: GroundOfStates) -> Iterator[InRun]:
    """Give the intervals inside a run in which the target is elsewhere that explain most."""
    data, scale = ground.space.data, ground.space.whitening.scale
    found = []
    for run in np.unique(data.run[~data.absolute]):
        own = np.flatnonzero(data.run == run)
        edges = np.unique(np.linspace(1, len(own) - 1, min(len(own), MOST_EDGES)).astype(np.int64))
        if len(edges) < 2:
            continue
        weight = scale[:, own] ** 2
        mean = np.sum(weight * ground.residual[:, own], axis=1) / np.maximum(np.sum(weight, axis=1), 1e-300)
        summed = np.cumsum(weight * (ground.residual[:, own] - mean[:, None]), axis=1)[:, edges - 1]
        whole, part = np.sum(weight, axis=1), np.cumsum(weight, axis=1)[:, edges - 1]
        inside = part[:, None, :] - part[:, :, None]
        square = inside * (1.0 - inside / np.maximum(whole, 1e-300)[:, None, None])
        shows = square > LEAST_INTERVAL * whole[:, None, None]
        moved = summed[:, None, :] - summed[:, :, None]
        gain = np.triu(np.sum(np.where(shows, moved**2 / np.where(shows, square, 1.0), 0.0), axis=0), 1)
        a, b = (int(k) for k in np.unravel_index(int(np.argmax(gain)), gain.shape))
        if gain[a, b] > 0.0:
            found.append((float(gain[a, b]), int(run), own[edges[a] : edges[b]], len(own)))
    for _, run, states, length in sorted(found, key=lambda one: -one[0])[:INTERVALS_KEPT]:
        moved = np.zeros((len(data.measured), *data.measured.shape))
        for component in range(len(data.measured)):
            median = np.median(scale[component, states])
            moved[component, component, states] = 1.0 / median if median > 0.0 else 0.0
        rows = _independent(ground.space.rows(moved), length * len(data.measured))
        if len(rows):
            yield InRun(MistakeInRun.MOVED, run, rows, -float(np.log(0.5 * length * (length - 1.0))))


def _independent(rows: Floats, count: int) -> Floats:
    """Return directions (d, r) of rows that are not made of each other, together of rms one over so many readings."""
    _, size, axes = thin_svd(rows)
    kept = (axes * size[:, None])[size > LEAST_OF_MISTAKE * max(float(size.max(initial=0.0)), 1e-300)]
    return np.asarray(kept * np.sqrt(count / max(float(np.sum(kept**2)), 1e-300)))
