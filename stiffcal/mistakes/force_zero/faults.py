"""Force sensors whose zero moved within a run, as faults: where, by how much, and what it does to the stiffnesses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import joint_springs
from stiffcal.mistakes.force_zero.accounts import moved_zeros, without_zeros
from stiffcal.mistakes.force_zero.motion_evidence import likeliest
from stiffcal.mistakes.force_zero.moved_zero import MovedZero, ZeroChange
from stiffcal.mistakes.force_zero.tables import rounded_readings
from stiffcal.reduction.loads.motion import motion_of
from stiffcal.wording import share

# A change of stiffness that no one would act on.
LEAST_CHANGE = 0.001
# Of the evidence: five standard errors, odds of e^12.5.
CLEAR = 25.0


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
    judged = _best_of_runs(states, runs, motion)
    # where small loads are set, most runs read one that is near to none: their motions decide together, which of a few
    # states show nothing each, and no run counts for more than a clear one
    together = sum(min(max(evidence, -CLEAR), CLEAR) for _, evidence in judged)
    needed = -CLEAR if together > -CLEAR else CLEAR
    moved = [(zero, evidence) for zero, evidence in judged if evidence > needed]
    if not moved:
        return []
    bias = _bias_words(stiffness_bias(states, [zero for zero, _ in moved], chain), chain)
    return [_fault(states, zero, evidence, bias, file) for zero, evidence in moved]


def _best_of_runs(
    states: LoadStates, runs: Sequence[Sequence[MovedZero]], motion: Floats
) -> list[tuple[MovedZero, float]]:
    """Return of each run the account that the motion supports most, and how much.

    Runs of which single readings without that support are the only account are left out.
    """
    weighed = iter(likeliest(states, [account for accounts in runs for account in accounts], motion))
    found: list[tuple[MovedZero, float]] = []
    for accounts in runs:
        own = [next(weighed) for _ in accounts]
        supported = [one for account, one in zip(accounts, own, strict=True) if one[1] > CLEAR or not account.single]
        found += [max(supported, key=lambda one: one[1])] if supported else []
    return found


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
    return f"; with these zeros the stiffness of joint {name} comes out {share(abs(bias.share), 2)} too {size}"
