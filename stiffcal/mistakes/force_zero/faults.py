"""Force sensors whose zero moved within a run, as faults: where, by how much, and what it does to the stiffnesses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import joint_springs
from stiffcal.mistakes.force_zero.accounts import moved_zeros, without_zeros
from stiffcal.mistakes.force_zero.moved_zero import LEAST_LEVEL, MovedZero, Part, ZeroChange, started_at
from stiffcal.mistakes.force_zero.tables import rounded_readings
from stiffcal.reduction.loads.motion import motion_of
from stiffcal.wording import significant

# A change of stiffness that no one would act on.
LEAST_CHANGE = 0.001
# Of the evidence: five standard errors, odds of e^12.5.
CLEAR = 25.0
# Places of a step that are tried at once.
MANY_STARTS = 100


def force_zero_faults(states: LoadStates, chain: Chain, file: str = "campaign.toml") -> list[Fault]:
    """Return a fault for every run in which the force sensor's zero moved.

    Parameters
    ----------
    states : load states that are used, of load runs. chain : the robot's.
    """
    runs = moved_zeros(states)
    if not runs:
        return []
    motion = motion_of(states, chain, all_targets=True).measured
    judged = [judgement for judgement in (_best(states, run, motion) for run in runs) if judgement is not None]
    # where small loads are set, most runs read one that is near to none: their motions decide together, which of a few
    # states show nothing each, and no run counts for more than a clear one
    together = sum(min(max(evidence, -CLEAR), CLEAR) for _, evidence in judged)
    needed = -CLEAR if together > -CLEAR else CLEAR
    moved = [(zero, evidence) for zero, evidence in judged if evidence > needed]
    if not moved:
        return []
    bias = _bias_words(stiffness_bias(states, [zero for zero, _ in moved], chain), chain)
    return [_fault(states, zero, evidence, bias, file) for zero, evidence in moved]


def _best(states: LoadStates, accounts: Sequence[MovedZero], motion: Floats) -> tuple[MovedZero, float] | None:
    """Return the account that the motion supports most, and how much; None of single readings without support."""
    best: tuple[MovedZero, float] | None = None
    for account in accounts:
        weighed = _likeliest(account, _Motion(states, account, motion))
        supported = weighed[1] > CLEAR or not account.single
        if supported and (best is None or weighed[1] > best[1]):
            best = weighed
    return best


def _likeliest(account: MovedZero, motion: _Motion) -> tuple[MovedZero, float]:
    """Return an account, its step where the motion supports it most, and how much.

    The further from the true place the step is put, the less is explained: among many places it is closed in on.
    """
    best = account, motion.evidence(account)
    if account.earliest is None:
        return best
    starts = range(account.earliest, int(np.flatnonzero(account.members == account.between[1])[0]))
    while starts:
        apart = -(-len(starts) // MANY_STARTS)
        tried = [(motion.evidence(started_at(account, start)), -start) for start in starts[::apart]]
        evidence, start = max(tried)[0], -max(tried)[1]
        if evidence > best[1]:
            best = started_at(account, start), evidence
        starts = range(max(starts.start, start - apart + 1), min(starts.stop, start + apart)) if apart > 1 else range(0)
    return best


class _Motion:
    """The motion of one run's states, and how well it follows loads.

    Parameters
    ----------
    account : one of the run. motion : (n, k) m, of all states.
    """

    def __init__(self, states: LoadStates, account: MovedZero, motion: Floats) -> None:
        part, members = account.part, account.members
        self._parts = [Part.FORCE] if part is Part.FORCE else list(Part)
        self._load = states.wrench[members]
        of_finite: dict[bytes, tuple[Booleans, list[Floats]]] = {}
        for target in motion[members].T:
            finite = np.isfinite(target)
            if finite.any():
                of_finite.setdefault(finite.tobytes(), (finite, []))[1].append(target[finite])
        self._measured = [(finite, np.stack(targets, axis=1)) for finite, targets in of_finite.values()]
        as_read = _directed(self._load, self._parts)
        self._components = as_read.shape[1]
        self._left = [_misfits(as_read[finite], targets) for finite, targets in self._measured]

    def evidence(self, trial: MovedZero) -> float:
        """Return twice the logarithm of how often likelier the motion is with a moved zero than with a load left on.

        In one pose the motion is a linear map of the load, whatever the robot's springs and geometry; what play and
        friction leave of that counts as noise. 0 where no motion was measured.

        Parameters
        ----------
        trial : what the sensor reads too much in each of the run's states.
        """
        without = _directed(self._load - trial.zero, self._parts)
        found = 0.0
        for (finite, targets), squares in zip(self._measured, self._left, strict=True):
            free = max(len(targets) - self._components, 0)
            found += free * float(np.sum(np.log(squares / _misfits(without[finite], targets))))
        return found


def _directed(load: Floats, parts: Sequence[Part]) -> Floats:
    """Return (m, 1 + d) a constant and those components of loads (m, 6) that change, in parts of the largest load.

    Along the others a change of zero would be all the load there is, and any motion would do for it.
    """
    readings = np.hstack([load[:, part.columns] / _largest(load[:, part.columns]) for part in parts])
    centred = readings - readings.mean(axis=0)
    components = readings @ np.linalg.eigh(centred.T @ centred)[1]
    loaded = np.ptp(components, axis=0) > LEAST_LEVEL * _largest(readings)
    return np.hstack([np.ones((len(load), 1)), components[:, loaded]])


def _largest(readings: Floats) -> float:
    return max(float(np.linalg.norm(readings, axis=1).max()), 1e-300)


def _misfits(design: Floats, targets: Floats) -> Floats:
    """Return (k,) the sums of squares that least squares on a design (m, p) leave of targets (m, k).

    The design's columns are as good as orthogonal: normal equations lose nothing, and take a small part of the time.
    """
    scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    scaled = design / scale
    left = targets - scaled @ np.linalg.lstsq(scaled.T @ scaled, scaled.T @ targets, rcond=1e-13)[0]
    return np.asarray(np.maximum((left**2).sum(axis=0), 1e-300))


def _fault(states: LoadStates, moved: MovedZero, evidence: float, bias: str, file: str) -> Fault:
    before, after = (int(states.row[k]) for k in moved.between)
    changed = moved.change[moved.part.columns]
    numbers = rounded_readings(changed, moved.part)
    how, instead = {
        ZeroChange.STEP: ("was reset", "a load remained"),
        ZeroChange.DRIFT: ("drifted", "a growing load remained"),
        ZeroChange.STEPS: ("changed several times", "loads remained"),
        ZeroChange.UNCLEAR: ("was reset or drifted", "a load remained"),
    }[moved.kind]
    cause = how if evidence > CLEAR else f"{how}, or {instead}"
    reason = (
        f"between states {before} and {after} the force sensor's zero {cause}: unloaded it reads ({numbers}) "
        f"{moved.part.value} more than before, in {moved.n_unloaded} unloaded states; readings are used as they are"
        f"{bias}"
    )
    if moved.kind is ZeroChange.STEP:
        code = FaultCode.WRENCH_REZEROED
        mend = "split the run there (two [[runs]], each with its own reference), or remove the step in a copy"
    else:
        code = FaultCode.WRENCH_DRIFTED
        mend = "subtract what the sensor reads unloaded, interpolated over time, in a copy, or measure the run again"
    return Fault(code, file, f"run {states.runs[moved.run].name}", reason, mend)


@dataclass(frozen=True)
class _Springs:
    """Joint springs alone, fitted to what was measured, to first order, with an offset for each run."""

    compliance: Floats
    """(J,) of the drives, rad/(N·m) or m/N."""
    std: Floats
    """(J,) their standard errors; infinite where no load acts, and of all where they cannot be separated."""
    left: float
    """Sum of squares that they leave, m²."""
    free: int
    """Degrees of freedom of that."""


@dataclass(frozen=True)
class StiffnessBias:
    """What moved zeros do to the stiffness that they change most clearly."""

    drive: int
    """Its drive, from 0."""
    share: float
    """By what share it comes out too large."""


def stiffness_bias(states: LoadStates, moved: Sequence[MovedZero], chain: Chain) -> StiffnessBias | None:
    """Return what moved zeros do to the stiffness whose change is most standard errors.

    None where no motion is measured that springs would explain.
    """
    as_read, corrected = _springs_of(states, chain), _springs_of(without_zeros(states, moved), chain)
    if as_read is None or corrected is None:
        return None
    known = (corrected.compliance > 0.0) & (as_read.compliance > 0.0) & np.isfinite(corrected.std)
    if not known.any():
        return None
    change = np.where(known, corrected.compliance - as_read.compliance, 0.0)
    drive = int(np.argmax(np.abs(change) / corrected.std))
    return StiffnessBias(drive, float(change[drive] / as_read.compliance[drive]))


def _springs_of(states: LoadStates, chain: Chain) -> _Springs | None:
    """Return the joint springs that explain the states best; None where they are not determined."""
    reading, per_reading, columns = joint_springs(states, chain)
    measured = motion_of(states, chain, all_targets=True).measured
    design = columns * (per_reading @ reading[:, :, None])[:, None, :, 0]
    offset = 0.0 if states.deflection_given else 1.0
    rows, targets = [], []
    for members in members_of(states.run):
        for component in range(measured.shape[1]):
            finite = members[np.isfinite(measured[members, component])]
            if finite.size:
                rows.append(design[finite, component] - offset * design[finite, component].mean(axis=0))
                targets.append(measured[finite, component] - offset * measured[finite, component].mean())
    if not rows:
        return None
    matrix, target = np.concatenate(rows), np.concatenate(targets)
    free = len(target) - matrix.shape[1] - len(rows)
    scale = np.linalg.norm(matrix, axis=0)
    acting = scale > 1e-9 * max(float(scale.max(initial=0.0)), 1e-300)
    if free < 1 or not acting.any():
        return None
    scaled = matrix[:, acting] / scale[acting]
    found, _, rank, _ = np.linalg.lstsq(scaled, target, rcond=1e-9)
    left = float(np.sum((target - scaled @ found) ** 2))
    compliance, std = np.zeros(len(scale)), np.full(len(scale), np.inf)
    compliance[acting] = found / scale[acting]
    if rank == acting.sum():
        std[acting] = np.sqrt(left / free * np.diag(np.linalg.inv(scaled.T @ scaled))) / scale[acting]
    return _Springs(compliance, std, left, free)


def _bias_words(bias: StiffnessBias | None, chain: Chain) -> str:
    """Return what the moved zeros do to the stiffness that changes most, as the end of a sentence."""
    if bias is None:
        return ""
    if abs(bias.share) < LEAST_CHANGE:
        return "; no joint's stiffness changes by more than 0.1 %"
    size = "large" if bias.share > 0.0 else "small"
    name = chain.joint_names[bias.drive]
    return (
        f"; with these zeros the stiffness of joint {name} comes out "
        f"{significant(100.0 * abs(bias.share), 2)} % too {size}"
    )
