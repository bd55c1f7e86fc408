"""Bumped readings, set aside once, before any model and the same for all models.

Why not by a model's residual: backlash crossings look like outliers to a model without backlash. A reading is set
aside only when nothing explains it: not the smooth course of its own direction and branch, not a repeat at like load,
not the readings just before and after it (a slip shifts all that follow), and where its neighbours jump themselves,
not a place between them. The worst goes first, then the rest is looked at again without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.set_aside import SetAsideCode, any_code
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.reduction.loads.courses import Group, alike_courses
from stiffcal.reduction.loads.cycles import UNLOADED, UNLOADING, LoadCycles, find_load_cycles, load_vector
from stiffcal.reduction.set_aside.bumped_readings import ComparedReadings
from stiffcal.uncertainty import MEDIAN_OF_NORMAL, chi_square_bound
from stiffcal.wording import length

# Natural log of the false alarms: e^-16 is 1e-7 per state for one explanation alone, and several have to fail.
ALARM_EXPONENT = 16.0
LEAST_LOADED = 0.1  # of the most loaded direction of a run: below, how it gives that way is not known
# States of a run that are compared with each other; a longer run is looked at in pieces, as its neighbours in time show
# a bumped reading, and what comparing takes grows with the square of a piece.
MOST_COMPARED = 3000
RUNS_AT_ONCE = 256  # more do not fit into the cache


def reject_outliers(states: LoadStates) -> LoadStates:
    """Return the states with bumped readings set aside, each with its reason.

    Examples
    --------
    See ``tests/reduction/test_outliers.py``.
    """
    reasons = outlier_readings(states)
    if not reasons:
        return states
    return states.with_set_aside(np.array(list(reasons)), SetAsideCode.BUMPED, list(reasons.values()))


def load_is_good(states: LoadStates) -> Booleans:
    """Return (n,) True where the load was what the state holds, whether or not its reading is used.

    A bumped reading was taken under a good load, which laws with memory (play, creep) must pass through, and so was one
    that was held too briefly; what the manifest excludes is in doubt as a whole.
    """
    good = (SetAsideCode.NONE, SetAsideCode.BUMPED, SetAsideCode.HELD_BRIEFLY)
    return any_code(states.set_aside_code, *good)


def outlier_readings(states: LoadStates) -> dict[int, str]:
    """Return the indices of readings that contradict their neighbours and repeats, and why in words."""
    readings, n_lengths = _readings(states)
    if readings.shape[1] == 0:
        return {}
    cycles = find_load_cycles(states)
    piece = _pieces(states.run)
    groups = _groups(piece, cycles)
    readings = readings - _misalignment_effect(readings, states, cycles)
    residuals = _smooth_residuals(readings, groups)
    noise = _noise([residual for residual in residuals if residual is not None])
    if noise is None:
        return {}
    white = readings / noise
    wider = _noisier_runs(residuals, noise, groups, piece)
    if wider:
        white /= np.array([wider.get(number, 1.0) for number in piece.tolist()])[:, None]
    n_components = white.shape[1]
    bound = np.sqrt(chi_square_bound(n_components, ALARM_EXPONENT))
    reason_of: dict[int, str] = {}
    in_use = states.used & np.isfinite(white).all(axis=1)
    doubtful = {int(piece[k]) for k in _far_readings(white, groups, in_use, bound)}
    for number, run_groups in _by_run(groups, piece).items():
        if number not in doubtful:
            continue
        for k, distance in ComparedReadings(white, run_groups, in_use, cycles.last_direction, bound).bumped():
            size = distance * wider.get(number, 1.0) * float(np.sqrt(np.mean(noise[:n_lengths] ** 2)))
            reason_of[k] = (
                f"outlier: differs by {distance:.0f} times the noise ({length(size)}) from its neighbours and repeats"
            )
    return reason_of


def _readings(states: LoadStates) -> tuple[Floats, int]:
    """Return (n, k): translation and, where measured throughout, rotation of every target, base axes, in m and rad.

    And how many of the first components are lengths of the first target. Where only gauges were read, the one that a
    run reads is its component.
    """
    n = len(states)
    if states.deflection_given:
        flat = states.deflection.reshape(n, -1)
        return np.asarray(flat[:, np.isfinite(flat).any(axis=0)]), 3
    if not states.has_poses:
        measured = np.isfinite(states.displacement)
        alone = np.where(measured.any(axis=1), np.sum(np.where(measured, states.displacement, 0.0), axis=1), np.nan)
        return alone[:, None] if measured.any() else np.zeros((n, 0)), 1
    columns = [states.position.reshape(n, -1)]
    for b in range(states.rotation.shape[1]):
        if np.isfinite(states.rotation[:, b]).all():
            _, first, run = np.unique(states.run, return_index=True, return_inverse=True)
            reference = states.rotation[first[run], b]
            columns.append(vector_from_rotation(states.rotation[:, b] @ reference.swapaxes(1, 2)))
    return np.concatenate(columns, axis=1), 3


def _misalignment_effect(readings: Floats, states: LoadStates, cycles: LoadCycles) -> Floats:
    """Return (n, k): what the readings owe to forces that were not quite along their direction.

    A heavy load misaligned by half a degree moves a soft robot sideways by several times the tracker's noise. How the
    run's readings follow the force is given well enough by a straight line for this share of a hundredth.
    """
    result = np.zeros_like(readings)
    force = load_vector(states.wrench)
    good = states.used & np.isfinite(readings).all(axis=1)
    off = _off_direction(force, states.run, np.where(good, cycles.direction, -1))
    of_size: dict[int, list[Integers]] = {}
    for everyone in members_of(states.run):
        members = everyone[good[everyone]]
        of_size.setdefault(members.size, []).append(members)
    for size, runs in of_size.items():
        for start in range(0, len(runs) if size else 0, RUNS_AT_ONCE):
            members = np.stack(runs[start : start + RUNS_AT_ONCE])
            loads, moved = (
                values[members] - values[members].mean(axis=1, keepdims=True) for values in (force, readings)
            )
            # Directions in which the run was hardly loaded carry no information on how it gives there.
            result[members] = off[members] @ (np.linalg.pinv(loads, rcond=LEAST_LOADED) @ moved)
    return result


def _off_direction(force: Floats, run: Integers, direction: Integers) -> Floats:
    """Return (n, 3) N what of each force lies across its direction, the mean of those of the run in this direction.

    Parameters
    ----------
    force : (n, 3) N. run : (n,) run number. direction : (n,) number of the direction; −1 where it has none.
    """
    pairs, own = np.unique(run * (direction.max(initial=0) + 2) + direction + 1, return_inverse=True)
    sums = np.stack([np.bincount(own, weights=column, minlength=len(pairs)) for column in force.T], axis=1)
    size = np.linalg.norm(sums, axis=1)
    along = (sums / np.where(size > 0.0, size, 1.0)[:, None])[own]
    off = force - np.sum(force * along, axis=1, keepdims=True) * along
    off[(direction < 0) | (size[own] == 0.0)] = 0.0
    return np.asarray(off)


def _pieces(run: Integers) -> Integers:
    """Return (n,) the number of each state's piece: its run, or a part of its run of at most `MOST_COMPARED` states."""
    order = np.argsort(run, kind="stable")
    _, first, size = np.unique(run[order], return_index=True, return_counts=True)
    parts = -(-size // MOST_COMPARED)
    within = (np.arange(run.size) - np.repeat(first, size)) * np.repeat(parts, size) // np.repeat(size, size)
    piece = np.empty_like(run)
    piece[order] = np.repeat(np.cumsum(parts) - parts, size) + within
    return piece


def _groups(piece: Integers, cycles: LoadCycles) -> list[Group]:
    """Gather the readings of one run or piece of it, direction and branch; peaks belong to loading."""
    branch = np.where(cycles.branch == UNLOADED, 0, np.where(cycles.branch == UNLOADING, 2, 1))
    key = np.where(branch == 0, -1, cycles.direction)
    order = np.lexsort((np.arange(len(piece)), branch, key, piece))
    _, length = np.unique(piece, return_counts=True)
    order = order[np.repeat(length, length) > 1]  # a reading that is alone has nothing to contradict
    if not order.size:
        return []
    _, first, length = np.unique(piece[order], return_index=True, return_counts=True)
    largest = np.maximum(np.maximum.reduceat(cycles.magnitude[order], first), np.finfo(float).tiny)
    share = cycles.magnitude[order] / np.repeat(largest, length)
    cuts = np.flatnonzero(np.diff(np.stack([piece, key, branch])[:, order]).any(axis=0)) + 1
    return [
        Group(members, own, bool(branch[members[0]] != 0), int(key[members[0]]))
        for members, own in zip(np.split(order, cuts), np.split(share, cuts), strict=True)
    ]


def _smooth_residuals(readings: Floats, groups: Sequence[Group]) -> list[Floats | None]:
    """Return, of each group, (m, k) what a smooth course over load leaves; None where too few readings are complete."""
    residuals: list[Floats | None] = [None] * len(groups)
    complete: Booleans = np.asarray(np.isfinite(readings).all(axis=1))
    for alike in alike_courses(groups, complete):
        left, hat = alike.left(readings)
        scaled = left / np.sqrt(np.maximum(1.0 - hat, 0.1))[:, :, None]
        for number, residual in zip(alike.groups, scaled, strict=True):
            residuals[number] = residual
    return residuals


def _far_readings(white: Floats, groups: Sequence[Group], kept: Booleans, bound: float) -> list[int]:
    """Return the readings whose studentized residual about their group's smooth course exceeds the bound."""
    far: list[int] = []
    for alike in alike_courses(groups, kept):
        left, hat = alike.left(white)
        lengths = np.linalg.norm(left, axis=2) / np.sqrt(np.maximum(1.0 - hat, 0.05))
        far += alike.members[lengths > bound].tolist()
    return far


def _noise(residuals: Sequence[Floats]) -> Floats | None:
    """Return (k,) the scatter between like readings: robust, from what smooth courses leave; None where too few."""
    if not residuals:
        return None
    stacked = np.abs(np.concatenate(residuals))
    noise = np.median(stacked, axis=0) / MEDIAN_OF_NORMAL
    floor = 1e-3 * float(np.median(noise[noise > 0.0])) if (noise > 0.0).any() else 0.0
    if len(stacked) < 12 or floor == 0.0:
        return None
    return np.asarray(np.maximum(noise, floor))


def _noisier_runs(
    residuals: Sequence[Floats | None], noise: Floats, groups: Sequence[Group], run: Integers
) -> dict[int, float]:
    """Return runs that scatter wider than the noise as a whole, with by how much.

    A target far from the tracker or a shaky stand makes all readings of a run noisier, and none of them bumped. The
    median of n deviations is known to 1.17/√n of itself; three times that is no chance.
    """
    factor_of: dict[int, float] = {}
    of_run: dict[int, list[tuple[Group, Floats | None]]] = {}
    for group, residual in zip(groups, residuals, strict=True):
        of_run.setdefault(int(run[group.members[0]]), []).append((group, residual))
    for number, own in sorted(of_run.items()):
        scatter = _noise([residual / noise for _, residual in own if residual is not None])
        factor = 1.0 if scatter is None else float(np.sqrt(np.mean(scatter**2)))
        if factor > 1.0 + 3.0 * 1.17 / np.sqrt(sum(group.members.size for group, _ in own) * noise.size):
            factor_of[number] = factor
    return factor_of


def _by_run(groups: list[Group], run: Integers) -> dict[int, list[Group]]:
    """Return the groups of each run by its number; they come run by run, and none is empty."""
    return {number: list(own) for number, own in groupby(groups, key=lambda group: int(run[group.members[0]]))}


__all__ = ["load_is_good", "outlier_readings", "reject_outliers"]
