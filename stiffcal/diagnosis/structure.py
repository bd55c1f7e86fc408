"""What a remainder follows when nothing in the catalogue accounts for it: pose, load, branch, time, temperature.

For each of these a family of smooth curves is fitted to the residual, and what it takes away beyond what so many free
numbers take from mere noise is its share. Families that take no more than chance allows are passed over.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.diagnosis.judge import f_tail
from stiffcal.diagnosis.scan import Scan
from stiffcal.diagnosis.thresholds import LACK_OF_FIT_P
from stiffcal.identification.least_squares import run_edges, triangular
from stiffcal.identification.observation import Observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.varying import varies
from stiffcal.reduction.load_cycles import LOADING, UNLOADING, find_load_cycles

Floats = NDArray[np.float64]

# Below this share nothing is said to be followed.
LEAST_SHARE = 0.1


@dataclass(frozen=True)
class Followed:
    """Something that the residual follows.

    Attributes
    ----------
    what : "joint angle", "load", "branch", "time" or "temperature".
    share : of the residual's avoidable squares.
    words : what was seen.
    """

    what: str
    share: float
    words: str


def what_it_follows(scan: Scan, states: LoadStates) -> list[Followed]:
    """Return what the residual of the scan's base model follows, most first."""
    data = scan.fit.data
    residual = scan.space.centred(scan.residual[None])[0]
    rows = scan.space.rows(residual[None])[0]
    total = float(rows @ rows)
    avoidable = max(total - scan.dof, 1e-12) if scan.fit.noise is not None else total
    found = []
    families = _families(data, states)
    for what, features, words in families:
        stack = np.concatenate([scan.space.rows(features), rows[None]])
        scale = np.sqrt(np.sum(stack**2, axis=1))
        kept = scale > 1e-9 * scale.max()
        kept[-1] = True
        factor = triangular((stack[kept] / scale[kept][:, None]).T)
        taken = total - float(factor[-1, -1] ** 2 * scale[-1] ** 2)
        # So many free numbers take as many units of noise, and more where more than noise is left.
        count = int(np.count_nonzero(kept[:-1]))
        by_chance = count * max(1.0, (total - taken) / max(scan.dof, 1))
        rest = scan.dof - scan.n_columns - count
        if count == 0 or rest <= 0:
            continue
        statistic = (taken / count) / max((total - taken) / rest, 1e-300)
        if f_tail(statistic, count, rest) * len(families) > LACK_OF_FIT_P:
            continue
        share = float(np.clip((taken - by_chance) / avoidable, 0.0, 1.0))
        if share > LEAST_SHARE:
            found.append(Followed(what, share, words))
    return sorted(found, key=lambda one: -one.share)


def _families(data: Observations, states: LoadStates) -> list[tuple[str, Floats, str]]:
    """Return (what, (k, m, n) features, words) of each family."""
    cycles = find_load_cycles(states)
    branch, axis = cycles.branch[data.index], cycles.axis[data.index]
    size = cycles.magnitude[data.index]
    sign = np.where(branch == LOADING, 1.0, np.where(branch == UNLOADING, -1.0, 0.0))
    load = data.wrench[:3] / max(float(np.abs(data.wrench[:3]).max(initial=0.0)), 1e-12)
    families = [
        (
            "joint angle",
            _per_run(data, load),
            "in each pose the residual is proportional to the load, but from pose to pose with another factor",
        ),
        (
            "load",
            _per_component(data, np.concatenate([load**2, load * np.abs(load), load[[0, 0, 1]] * load[[1, 2, 2]]])),
            "the residual is not proportional to the load, in the same way in all poses",
        ),
        (
            "branch",
            _per_run(data, np.stack([sign * (axis == k) for k in range(int(axis.max(initial=-1)) + 1)] or [sign])),
            "loading and unloading run on different curves",
        ),
    ]
    time = data.order.since_reference
    if np.isfinite(time).all() and varies(time):
        words = "the residual drifts with the time since the run's reference"
        families.append(("time", _per_component(data, (time / np.ptp(time))[None]), words))
    warm = data.order.temperature
    if np.isfinite(warm).all() and varies(warm):
        words = "the residual follows the logged temperature"
        families.append(("temperature", _per_component(data, (warm / np.ptp(warm))[None]), words))
    return [family for family in families if size.any() or family[0] in ("time", "temperature")]


def _per_component(data: Observations, features: Floats) -> Floats:
    """Return (k · m, m, n): each scalar feature (k, n) on each observed component by itself."""
    m = len(data.measured)
    result = np.zeros((len(features) * m, m, data.n_states))
    for a in range(m):
        result[a::m, a] = features
    return result


def _per_run(data: Observations, features: Floats) -> Floats:
    """Return each feature on each component, by itself in every run."""
    whole = _per_component(data, features)
    edges = np.append(run_edges(data.run), data.n_states)
    pieces = []
    for start, end in itertools.pairwise(edges):
        piece = np.zeros_like(whole)
        piece[:, :, start:end] = whole[:, :, start:end]
        pieces.append(piece)
    return np.concatenate(pieces)
