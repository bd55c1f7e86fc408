"""Joint angles and places that meet: frames of the tracker and the targets with which most rows agree.

Rows far from the others do not count (iteratively reweighted least squares with the weights of Geman and McClure 1985).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import permutations

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.reduction.registration.registering import WORST_M

# An uncalibrated robot misses by millimetres: below this a table as a whole is not doubted.
UNCALIBRATED_M = 5e-3
# Fewer rows than this do not determine the frames well enough to doubt one.
LEAST_ROWS = 10
# A row that misses by so many times the usual distance, and by no less than this, is none of the others' kind …
FAR, FAR_M = 12.0, UNCALIBRATED_M
# … and one that meets with a change comes within so many times the usual distance, or this.
MEETS, MEETS_M = 4.0, 2e-3
# Of rows with one mistake so many have to meet the others with it taken back; the rest may have one more.
EXPLAINED = 0.9
# Turn, shift and offsets by turns are at rest after twenty rounds as a rule; where they hardly differ in what they do,
# all at once are.
BY_TURNS = 40
MOST_ROUNDS = 1000
SETTLED = 1e-4  # of a weight
# Below what any tracker reads: places that were computed may meet exactly.
LEAST_SCALE_M = 1e-6
# Of five targets 119 other orders are tried, of six it would be 719.
MOST_EXCHANGED = 5


@dataclass(frozen=True)
class MeasuredPlaces:
    """Rows in which at least one target was measured."""

    measured: Floats
    """(n, B, 3) m; NaN where a target was not measured."""
    position: Floats
    """(n, B, 3) m, of the bodies that carry the targets, base axes."""
    rotation: Floats
    """(n, B, 3, 3) base_from_body."""
    offset: Floats
    """(B, 3) m, of the targets on their bodies, as the manifest has them."""

    def at(self, rows: Integers | Booleans) -> MeasuredPlaces:
        """Return some rows."""
        return replace(self, measured=self.measured[rows], position=self.position[rows], rotation=self.rotation[rows])


@dataclass(frozen=True)
class Met:
    """Frames with which most rows meet."""

    turn: Floats
    """(3, 3) base from the axes of the places."""
    shift: Floats
    """(3,) m."""
    offset: Floats
    """(B, 3) m, of the targets on their bodies."""
    settled: bool = field(default=True, kw_only=True)
    """False where they come from an iteration that did not end: rows that do not meet with these may with others."""

    def distance(self, places: MeasuredPlaces) -> Floats:
        """Return (n, B) m from where kinematics puts the targets; NaN where one was not measured."""
        expected = places.position + np.einsum("nbij,bj->nbi", places.rotation, self.offset)
        return np.asarray(np.linalg.norm(places.measured @ self.turn.T + self.shift - expected, axis=2))

    def worst(self, places: MeasuredPlaces) -> Floats:
        """Return (n,) m, the distance of each row's worst target."""
        return np.asarray(np.nan_to_num(self.distance(places)).max(axis=1))

    def usual(self, places: MeasuredPlaces) -> float:
        """Return the median distance, m."""
        return float(np.nanmedian(self.distance(places)))


def places_of(states: LoadStates, chain: Chain) -> MeasuredPlaces:
    """Return what was measured in the states, and where kinematics puts the bodies that carry the targets."""
    angles, targets = chain.model_angles(states.joints), states.setup.targets
    bodies = [attached_poses(chain, angles, replace(target, transform=np.eye(4))) for target in targets]
    return MeasuredPlaces(
        states.position,
        np.stack([position for position, _ in bodies], axis=1),
        np.stack([rotation for _, rotation in bodies], axis=1),
        np.stack([target.transform[:3, 3] for target in targets]),
    )


def meet(places: MeasuredPlaces, start: Met | None = None) -> Met:
    """Return the frames with which most rows meet: rows far from the others do not count.

    Parameters
    ----------
    places : the rows. start : frames that some of the rows meet; default: those with which all rows count alike.

    Returns
    -------
    Met
        Not ``settled`` where the weights of the rows still change after `MOST_ROUNDS`.
    """
    known: Booleans = np.asarray(np.isfinite(places.measured).all(axis=2))
    measured = np.where(known[:, :, None], places.measured, 0.0)
    weight: Floats = known.astype(np.float64)
    offset = places.offset.copy()
    met = Met(np.eye(3), np.zeros(3), offset, settled=False)
    if start is not None:
        offset = start.offset.copy()
        weight = np.where(known, 1.0 / (1.0 + (np.nan_to_num(start.distance(places)) / WORST_M) ** 2) ** 2, 0.0)
    for rounds in range(MOST_ROUNDS):
        expected = places.position + np.einsum("nbij,bj->nbi", places.rotation, offset)
        turn, shift = rigid_motion(measured, expected, weight)
        met = _with_offsets(Met(turn, shift, offset, settled=False), places, measured, weight)
        if rounds >= BY_TURNS:
            met = _all_at_once(met, places, measured, weight)
        offset, distance = met.offset, met.distance(places)
        counted = distance if start is None else distance[distance <= WORST_M]
        scale = max(2.0 * float(np.nanmedian(counted)), LEAST_SCALE_M) if counted.size else WORST_M
        updated = np.where(known, 1.0 / (1.0 + (np.nan_to_num(distance) / scale) ** 2) ** 2, 0.0)
        if np.abs(updated - weight).max() < SETTLED:
            return replace(met, settled=True)
        weight = np.asarray(updated)
    return met


def _with_offsets(met: Met, places: MeasuredPlaces, measured: Floats, weight: Floats) -> Met:
    """Return frames with the targets' places on their bodies as the weighted means of where the rows put them."""
    back = np.einsum("nbji,nbj->nbi", places.rotation, measured @ met.turn.T + met.shift - places.position)
    total = weight.sum(axis=0)
    means = np.einsum("nb,nbi->bi", weight, back) / np.maximum(total, 1e-300)[:, None]
    return replace(met, offset=np.where(total[:, None] > 0.0, means, met.offset))


def _all_at_once(met: Met, places: MeasuredPlaces, measured: Floats, weight: Floats) -> Met:
    """Return frames after one Gauss–Newton step of turn, shift and offsets together; the same where it misses more."""
    n, n_targets, _ = measured.shape
    turned = measured @ met.turn.T
    left = turned + met.shift - places.position - np.einsum("nbij,bj->nbi", places.rotation, met.offset)
    columns = np.zeros((n, n_targets, 3, 6 + 3 * n_targets))
    for axis in range(3):
        columns[..., axis] = np.cross(np.eye(3)[axis], turned)
    columns[..., 3:6] = np.eye(3)
    for b in range(n_targets):
        columns[:, b, :, 6 + 3 * b : 9 + 3 * b] = -places.rotation[:, b]
    root = np.sqrt(weight)[:, :, None]
    flat = (columns * root[..., None]).reshape(-1, columns.shape[3])
    scale = np.maximum(np.linalg.norm(flat, axis=0), 1e-300)
    step = np.linalg.lstsq(flat / scale, -(left * root).ravel(), rcond=1e-9)[0] / scale
    turn = rotation_from_vector(step[:3]) @ met.turn
    tried = replace(met, turn=turn, shift=met.shift + step[3:6], offset=met.offset + step[6:].reshape(n_targets, 3))

    def missed(by: Met) -> float:
        return float(np.sum(weight * np.nan_to_num(by.distance(places)) ** 2))

    return tried if missed(tried) < missed(met) else met


def rigid_motion(measured: Floats, expected: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """Return the turn and shift that bring measured places (n, B, 3) to the expected ones (Umeyama 1991)."""
    total = weight.sum()
    first, second = (np.einsum("nb,nbi->i", weight, places) / total for places in (measured, expected))
    left, _, right = np.linalg.svd(np.einsum("nb,nbi,nbj->ij", weight, expected - second, measured - first))
    turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return turn, second - turn @ first


def misses(met: Met, places: MeasuredPlaces, usual: float) -> Booleans:
    """Return (n,) True for rows that are far from where the others put them."""
    return np.asarray(met.worst(places) > far_from(usual))


def far_from(usual: float) -> float:
    """Return the distance in m from which on a row is far from the others, whose usual one is given."""
    return max(FAR * usual, FAR_M)


def orders(n_targets: int) -> Iterator[list[int]]:
    """Return the orders of targets in which some on one body are exchanged, two at a time first."""
    if n_targets > MOST_EXCHANGED:
        return
    found = [order for order in permutations(range(n_targets)) if order != tuple(range(n_targets))]
    for order in sorted(found, key=lambda order: sum(b != k for k, b in enumerate(order))):
        yield list(order)
