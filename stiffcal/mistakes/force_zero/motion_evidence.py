"""Whether the motion of the robot follows loads better with a moved zero taken off: of many runs at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.force_zero.moved_zero import LEAST_LEVEL, MovedZero, Part, started_at

# Places of a step that are tried at once.
MANY_STARTS = 100
# States of all trials together that are computed at once: more do not fit into the cache.
AT_ONCE = 5000


def likeliest(states: LoadStates, accounts: Sequence[MovedZero], motion: Floats) -> list[tuple[MovedZero, float]]:
    """Return each account, its step where the motion supports it most, and how much.

    What supports it is twice the logarithm of how often likelier the motion is with a moved zero than with a load left
    on. In one pose the motion is a linear map of the load, whatever the robot's springs and geometry; what play and
    friction leave of that counts as noise. 0 where no motion was measured.

    The further from the true place the step is put, the less is explained: among many places it is closed in on.

    Parameters
    ----------
    states : load states. accounts : of their runs. motion : (n, k) m, of all states.
    """
    weighed = _Motions(states, accounts, motion)
    best = list(zip(accounts, weighed.evidence([(k, None) for k in range(len(accounts))]), strict=True))
    starts = {
        k: range(account.earliest, int(np.flatnonzero(account.members == account.between[1])[0]))
        for k, account in enumerate(accounts)
        if account.earliest is not None
    }
    while starts := {k: own for k, own in starts.items() if own}:
        apart = {k: -(-len(own) // MANY_STARTS) for k, own in starts.items()}
        trials = [(k, start) for k, own in starts.items() for start in own[:: apart[k]]]
        found: dict[int, tuple[float, int]] = {}
        for (k, start), evidence in zip(trials, weighed.evidence(trials), strict=True):
            found[k] = max(found.get(k, (-np.inf, 0)), (evidence, -start))
        for k, (evidence, negative) in found.items():
            start, own = -negative, starts[k]
            if evidence > best[k][1]:
                best[k] = started_at(accounts[k], start), evidence
            near = range(max(own.start, start - apart[k] + 1), min(own.stop, start + apart[k]))
            starts[k] = near if apart[k] > 1 else range(0)
    return best


@dataclass(frozen=True)
class _Alike:
    """Accounts of runs with as many states each, of which the same are measured."""

    parts: tuple[Part, ...]
    """What the motion may follow."""
    load: Floats
    """(a, m, 6) N and N·m, as read."""
    measured: list[tuple[Booleans, Floats]]
    """(m,) states that are measured, and (a, f, t) m of components that are measured in the same states."""
    free: list[Integers]
    """Of each of these (a,) the degrees of freedom that are left."""
    left: list[Floats]
    """Of each of these (a, t) the squares that loads as read leave."""


class _Motions:
    """The motion of the runs of accounts, and how well it follows loads."""

    def __init__(self, states: LoadStates, accounts: Sequence[MovedZero], motion: Floats) -> None:
        self._accounts = accounts
        numbers: dict[tuple[Part, int, bytes], list[int]] = {}
        for k, account in enumerate(accounts):
            finite = np.isfinite(motion[account.members])
            numbers.setdefault((account.part, account.members.size, finite.tobytes()), []).append(k)
        self._alike: list[_Alike] = []
        self._place: dict[int, tuple[int, int]] = {}
        for (part, n_states, _), own in numbers.items():
            for at_once in _cut(own, n_states):
                self._place |= {k: (len(self._alike), place) for place, k in enumerate(at_once)}
                members = np.stack([accounts[k].members for k in at_once])
                self._alike.append(_alike(part, states.wrench[members], motion[members]))

    def evidence(self, trials: Sequence[tuple[int, int | None]]) -> list[float]:
        """Return the evidence for trials: an account, and the first of its states after the step; None: as it is."""
        found = [0.0] * len(trials)
        groups: dict[int, list[int]] = {}
        for number, (k, _) in enumerate(trials):
            groups.setdefault(self._place[k][0], []).append(number)
        for group, numbers in groups.items():
            alike = self._alike[group]
            for at_once in _cut(numbers, alike.load.shape[1]):
                own = np.array([self._place[trials[number][0]][1] for number in at_once])
                zero = np.stack([self._zero(*trials[number]) for number in at_once])
                without, _ = _directed(alike.load[own] - zero, alike.parts)
                total = np.zeros(len(own))
                for (finite, targets), free, left in zip(alike.measured, alike.free, alike.left, strict=True):
                    misfits = _misfits(without[:, finite], targets[own])
                    total += free[own] * np.sum(np.log(left[own] / misfits), axis=1)
                for number, value in zip(at_once, total.tolist(), strict=True):
                    found[number] = value
        return found

    def _zero(self, number: int, start: int | None) -> Floats:
        """Return (m, 6) what the sensor reads too much in a trial."""
        account = self._accounts[number]
        if start is None:
            return account.zero
        return np.asarray(np.where(np.arange(account.members.size)[:, None] >= start, account.change, 0.0))


def _cut(numbers: Sequence[int], n_states: int) -> list[Sequence[int]]:
    """Cut numbers of trials with so many states each into those that are computed at once."""
    most = max(AT_ONCE // n_states, 1)
    return [numbers[start : start + most] for start in range(0, len(numbers), most)]


def _alike(part: Part, load: Floats, motion: Floats) -> _Alike:
    """Return loads (a, m, 6) and motions (a, m, k) that are measured in the same states, with what loads leave."""
    parts = (Part.FORCE,) if part is Part.FORCE else tuple(Part)
    as_read, n_columns = _directed(load, parts)
    columns: dict[bytes, list[int]] = {}
    for column, finite in enumerate(np.isfinite(motion[0]).T):
        if finite.any():
            columns.setdefault(finite.tobytes(), []).append(column)
    measured, free, left = [], [], []
    for own in columns.values():
        finite = np.isfinite(motion[0, :, own[0]])
        targets = motion[:, finite][:, :, own]
        measured.append((finite, targets))
        free.append(np.maximum(int(finite.sum()) - n_columns, 0))
        left.append(_misfits(as_read[:, finite], targets))
    return _Alike(parts, load, measured, free, left)


def _directed(load: Floats, parts: Sequence[Part]) -> tuple[Floats, Integers]:
    """Return a constant and those components of loads that change, in parts of the largest load; and how many.

    Along the others a change of zero would be all the load there is, and any motion would do for it.

    Parameters
    ----------
    load : (a, m, 6). parts : of it.

    Returns
    -------
    (a, m, 1 + d), zero along the others, and (a,) how many are not.
    """
    readings = np.concatenate([load[..., part.columns] / _largest(load[..., part.columns]) for part in parts], axis=2)
    centred = readings - readings.mean(axis=1, keepdims=True)
    components = readings @ np.linalg.eigh(centred.swapaxes(1, 2) @ centred)[1]
    loaded = np.ptp(components, axis=1) > LEAST_LEVEL * _largest(readings)[:, :, 0]
    directed = np.concatenate([np.ones((*load.shape[:2], 1)), np.where(loaded[:, None], components, 0.0)], axis=2)
    return directed, np.asarray(1 + loaded.sum(axis=1))


def _largest(readings: Floats) -> Floats:
    """Return (a, 1, 1) the largest of readings (a, m, c)."""
    return np.asarray(np.maximum(np.linalg.norm(readings, axis=2).max(axis=1), 1e-300)[:, None, None])


def _misfits(design: Floats, targets: Floats) -> Floats:
    """Return (a, t) the sums of squares that least squares on designs (a, f, p) leave of targets (a, f, t).

    The design's columns are as good as orthogonal: normal equations lose nothing, and take a small part of the time.
    """
    scale = np.maximum(np.linalg.norm(design, axis=1, keepdims=True), 1e-300)
    scaled = design / scale
    turned = scaled.swapaxes(1, 2)
    left = targets - scaled @ (np.linalg.pinv(turned @ scaled, rcond=1e-13, hermitian=True) @ (turned @ targets))
    return np.asarray(np.maximum((left**2).sum(axis=1), 1e-300))
