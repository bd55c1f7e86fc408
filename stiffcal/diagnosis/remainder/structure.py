"""What a remainder follows when nothing in the catalogue accounts for it: pose, load, branch, time, temperature.

For each of these a family of smooth curves is fitted to the residual, and what it takes away beyond what so many free
numbers take from mere noise is its share. Families that take no more than chance allows are passed over.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.results import ResidualDependence
from stiffcal.diagnosis.scans.lack_of_fit import f_tail
from stiffcal.diagnosis.scans.load_scan import LoadScan
from stiffcal.diagnosis.thresholds import LACK_OF_FIT_P
from stiffcal.estimation.constants import stretches
from stiffcal.estimation.triangular import triangular_of_rows
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.varying import varies
from stiffcal.reduction.loads.cycles import LOADING, UNLOADING, find_load_cycles

# Below this share nothing is reported as followed.
LEAST_SHARE = 0.1


def what_it_follows(scan: LoadScan, states: LoadStates) -> list[ResidualDependence]:
    """Return the families that the residual of the scan's base model follows, largest share first."""
    data = scan.fit.data
    residual = scan.space.centred(scan.residual[None])[0]
    rows = scan.space.rows(residual[None])[0]
    total = float(rows @ rows)
    avoidable = max(total - scan.dof, 1e-12) if scan.fit.noise is not None else total
    dependences = []
    families = _families(data, states)
    for family in families:
        remaining, count = _remaining_squares(family, scan, rows)
        explained = total - remaining
        # So many free numbers take as many units of noise, and more where more than noise is left.
        by_chance = count * max(1.0, (total - explained) / max(scan.dof, 1))
        residual_dof = scan.residual_dof - count
        if count == 0 or residual_dof <= 0:
            continue
        statistic = (explained / count) / max((total - explained) / residual_dof, 1e-300)
        if f_tail(statistic, count, residual_dof) * len(families) > LACK_OF_FIT_P:
            continue
        share = float(np.clip((explained - by_chance) / avoidable, 0.0, 1.0))
        if share > LEAST_SHARE:
            dependences.append(ResidualDependence(follows=family.what, share=share, seen=family.words))
    return sorted(dependences, key=lambda dependence: -(dependence.share or 0.0))


@dataclass(frozen=True)
class _Family:
    """Curves that are fitted to the residual together."""

    what: str
    """What the residual follows, as in `ResidualDependence`."""
    features: Floats
    """(k, m, n) the curves."""
    words: str
    """The dependence in words, as in `ResidualDependence`."""
    by_run: bool = False
    """Each curve is fitted in every run by itself, with a free number for each run."""


def _remaining_squares(family: _Family, scan: LoadScan, residual: Floats) -> tuple[float, int]:
    """Return the squares that a family leaves of the whitened residual (m · n), and its free numbers.

    What is fitted run by run has no rows in common: the squares left add up, and no matrix of all runs' curves and all
    states is ever made.
    """
    data, m = scan.fit.data, len(scan.fit.data.measured)
    stack = np.empty((len(family.features) + 1, m, data.n_states))
    stack[:-1], stack[-1] = scan.space.rows(family.features).reshape(-1, m, data.n_states), residual.reshape(m, -1)
    if not family.by_run:
        pieces = [stack.reshape(len(stack), -1)]
    else:
        edges = np.append(stretches(data.run), data.n_states)
        pieces = [stack[:, :, start:end].reshape(len(stack), -1) for start, end in itertools.pairwise(edges)]
    sizes = [np.sqrt(np.einsum("kn,kn->k", piece[:-1], piece[:-1])) for piece in pieces]
    total = max(float(np.sqrt(residual @ residual)), float(np.finfo(np.float64).tiny))
    least = 1e-9 * max(total, *(float(size.max(initial=0.0)) for size in sizes))
    left, count = 0.0, 0
    for piece, size in zip(pieces, sizes, strict=True):
        significant = size > least
        columns = piece[np.append(significant, True)]
        columns /= np.append(size[significant], total)[:, None]
        left += float(triangular_of_rows(columns)[-1, -1] ** 2) * total**2
        count += int(np.count_nonzero(significant))
    return left, count


def _families(data: Observations, states: LoadStates) -> list[_Family]:
    """Return the families to try."""
    cycles = find_load_cycles(states)
    branch, axis = cycles.branch[data.index], cycles.axis[data.index]
    size = cycles.magnitude[data.index]
    sign = np.where(branch == LOADING, 1.0, np.where(branch == UNLOADING, -1.0, 0.0))
    signed = [sign * (axis == number) for number in range(int(axis.max(initial=-1)) + 1)] or [sign]
    load = data.wrench[:3] / max(float(np.abs(data.wrench[:3]).max(initial=0.0)), 1e-12)
    families = [
        _Family(
            "joint angle",
            _per_component(data, load),
            "in each pose the residual is proportional to the load, with a factor that differs from pose to pose",
            by_run=True,
        ),
        _Family(
            "load",
            _per_component(data, np.concatenate([load**2, load * np.abs(load), load[[0, 0, 1]] * load[[1, 2, 2]]])),
            "the residual is not proportional to the load, in the same way in all poses",
        ),
        _Family(
            "branch",
            _per_component(data, np.stack(signed)),
            "loading and unloading follow different curves",
            by_run=True,
        ),
    ]
    if data.absolute.any():
        # One row per pose: curves by run would fit anything, and nothing is loaded and unloaded.
        text = "the position error depends on the joint angles"
        families = [_Family("joint angle", _per_component(data, _angle_curves(data)), text)]
        if data.order.approach.any():
            text = "the position error depends on the direction in which the joints moved last"
            families.append(_Family("approach", _per_component(data, _approach_curves(data)), text))
    time = data.order.since_reference
    if np.isfinite(time).all() and varies(time):
        text = "the residual drifts with time since the reference of the run"
        families.append(_Family("time", _per_component(data, (time / np.ptp(time))[None]), text))
    warm = data.order.temperature
    if np.isfinite(warm).all() and varies(warm):
        text = "the residual depends on the logged temperature"
        families.append(_Family("temperature", _per_component(data, (warm / np.ptp(warm))[None]), text))
    loaded = size.any() or data.absolute.any()
    return [family for family in families if loaded or family.what in ("time", "temperature")]


def _angle_curves(data: Observations) -> Floats:
    """Return (k, n) sines and cosines of the joints that carry the weights, in axes that turn with the first one.

    What springs and links do is carried around by the first joint that turns; the loads of weight change with the next
    two above all, whose sum counts where their axes are parallel.
    """
    angles, along = data.angles[~data.prismatic], data.phases[data.prismatic]
    arms = [angles[1], angles[2], angles[1] + angles[2]] if len(angles) > 2 else list(angles[1:])
    arms += list(along)
    curves = [
        np.ones(data.n_states),
        *(turn(order * arm) for arm in arms for order in (1, 2) for turn in (np.cos, np.sin)),
    ]
    around = (np.ones(data.n_states), *(turn(first) for first in angles[:1] for turn in (np.cos, np.sin)))
    return np.stack([first * curve for first in around for curve in curves])


def _approach_curves(data: Observations) -> Floats:
    """Return (k, n) the directions of the drives' last motions, in axes that turn with the first joint."""
    directions = [direction for direction in data.order.approach if varies(direction)]
    first_joint = data.angles[~data.prismatic][:1]
    around = (np.ones(data.n_states), *(turn(angle) for angle in first_joint for turn in (np.cos, np.sin)))
    return np.stack([first * direction for direction in directions for first in around] or [np.zeros(data.n_states)])


def _per_component(data: Observations, features: Floats) -> Floats:
    """Return (k · m, m, n): each scalar feature (k, n) on each observed component by itself."""
    m = len(data.measured)
    result = np.zeros((len(features) * m, m, data.n_states))
    for a in range(m):
        result[a::m, a] = features
    return result
