"""What makes kinematics meet the tracker where no single mistake of columns, signs or units does.

Four things misplace every pose by a fixed rule: the tracker's frame, the target's place on the flange, the zeros of
the joints, and the order of the poses. Each is fitted alone to the places in the reference states, by Gauss–Newton
steps with numerical derivatives; the two frames together, and all zeros together, come after them. A correction counts
where many more readings than parameters are left, and what is left is raised by the parameters' share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.reduction.angle_conventions import QUARTERS
from stiffcal.reduction.change_texts import texts_of

STEP = 1e-6  # of numerical derivatives, m and rad
SETTLED, MOST_ROUNDS = 1e-9, 40
LEAST_FREEDOM = 6
# Of so many poses the best order is looked for: the matrix of all distances takes 3 MB.
MOST_POSES = 600
# Of two corrections that leave nearly the same the one with fewer parameters is named, the other one after it.
AS_GOOD = 1.5
# A change that explains the distance leaves less than this share of it.
MUCH_BETTER = 0.3


@dataclass(frozen=True)
class KinematicsCorrection:
    """A change of the campaign's geometry that makes kinematics meet the tracker better."""

    left_m: float
    """Median distance that is left, raised by the share of the readings that the parameters take."""
    n_parameters: int
    """How many numbers were fitted."""
    changes: tuple[InputChange, ...]
    """What was changed, with its size."""

    @property
    def parts(self) -> frozenset[tuple[ChangeKind, str]]:
        """What was fitted: a correction that holds all parts of another one is no alternative to it."""
        return frozenset(
            (change.kind, name)
            for change in self.changes
            for name in (change.names if change.kind is ChangeKind.ZERO else [""])
        )


def corrections(states: LoadStates, chain: Chain, estimated: bool) -> list[KinematicsCorrection]:
    """Return the corrections that these poses determine, the one to name first.

    Parameters
    ----------
    states : one reference state per pose, with measured places. chain : the robot.
    estimated : True where the tracker's frame was found from these poses, so that it is fitted with each of the others.
    """
    candidates = [*_fit_corrections(states, chain, estimated), *_order_corrections(states, chain)]
    candidates.sort(key=lambda correction: correction.left_m)
    if not candidates:
        return []
    as_good = [correction for correction in candidates if correction.left_m <= AS_GOOD * candidates[0].left_m]
    return sorted(as_good, key=lambda correction: correction.n_parameters) + candidates[len(as_good) :]


def meeting_corrections(states: LoadStates, chain: Chain, estimated: bool, most_m: float) -> list[KinematicsCorrection]:
    """Return the corrections that make kinematics meet, the one to name first, then those that do as well.

    Parameters
    ----------
    states, chain, estimated : as of `corrections`. most_m : a correction that leaves more, m, is none.
    """
    meeting = [correction for correction in corrections(states, chain, estimated) if correction.left_m <= most_m]
    named = meeting[:1]
    for other in meeting[1:]:
        if other.left_m <= AS_GOOD * named[0].left_m and not any(other.parts >= one.parts for one in named):
            named.append(other)
    return named


def correcting_words(meeting: Sequence[KinematicsCorrection], chain: Chain) -> str:
    """Return which corrections make kinematics meet, in words; "" where none does."""
    texts: list[str] = []
    for one in meeting:
        words = " and ".join(texts_of(change, chain).words for change in one.changes)
        within = f"within {1e3 * one.left_m:.1f} mm"
        texts.append(f"; or with {words}, {within}" if texts else f"; with {words} they agree {within}")
    return "".join(texts)


def _fit_corrections(states: LoadStates, chain: Chain, estimated: bool) -> Iterator[KinematicsCorrection]:
    """Yield the corrections that are numbers to be fitted."""
    problem = _Problem(states, chain)
    n_joints = states.joints.shape[1]
    frame, target, zeros = list(range(6)), [6, 7, 8], list(range(9, 9 + n_joints))
    always = frame if estimated else []
    if not estimated:
        yield from problem.corrections(frame, lambda x: (_frame(x),))
    yield from problem.corrections(always + target, lambda x: (_target(x),))
    for joint in range(n_joints):
        # a zero of the first joint turns all poses about the base: not identifiable where the frame is fitted too
        for start in (0.0,) if chain.prismatic[joint] else QUARTERS:
            yield from problem.corrections([*always, 9 + joint], partial(_zeros, chain, [joint]), start)
    if not estimated:
        yield from problem.corrections(frame + target, lambda x: (_frame(x), _target(x)))
    yield from problem.corrections(always + zeros, partial(_zeros, chain, list(range(n_joints))))


@dataclass(frozen=True)
class _Problem:
    """Places against kinematics with 9 + L parameters: tracker 3 + 3, target 3, zeros L; base axes, m and rad."""

    states: LoadStates
    chain: Chain

    def residual(self, x: Floats) -> Floats:
        """Return (n, 3) the measured place, as the tracker's frame has it with these changes, less the computed one."""
        target = self.states.setup.targets[0]
        joints = self.states.joints + x[9:]
        place, rotation = attached_poses(self.chain, self.chain.model_angles(joints), target)
        measured = self.states.position[:, 0]
        middle = measured.mean(axis=0)
        turned = (measured - middle) @ rotation_from_vector(x[:3]).T + middle + x[3:6]
        return np.asarray(turned - place - np.einsum("nij,j->ni", rotation, x[6:9]))

    def corrections(
        self, free: list[int], changes: Callable[[Floats], tuple[InputChange, ...]], start: float = 0.0
    ) -> Iterator[KinematicsCorrection]:
        """Yield the correction with these parameters free, the last of them from a start; none if they stay open."""
        n_readings = 3 * len(self.states)
        if n_readings - len(free) < LEAST_FREEDOM:
            return
        x = np.zeros(9 + self.states.joints.shape[1])
        x[free[-1]] = start
        for _ in range(MOST_ROUNDS):
            residual = self.residual(x)
            columns = np.empty((n_readings, len(free)))
            for number, parameter in enumerate(free):
                stepped = x.copy()
                stepped[parameter] += STEP
                columns[:, number] = ((self.residual(stepped) - residual) / STEP).ravel()
            step = np.linalg.lstsq(columns, -residual.ravel(), rcond=1e-9)[0]
            x[free] += np.clip(step, -1.0, 1.0)
            if np.abs(step).max() < SETTLED:
                break
        else:
            return
        away = np.linalg.norm(self.residual(x), axis=1)
        remaining_m = float(np.median(away)) * np.sqrt(n_readings / (n_readings - len(free)))
        yield KinematicsCorrection(remaining_m, len(free), changes(x))


def _order_corrections(states: LoadStates, chain: Chain) -> Iterator[KinematicsCorrection]:
    """Yield the order of the poses' places that meets kinematics best, where it is another one."""
    from scipy.optimize import linear_sum_assignment

    if not 3 <= len(states) <= MOST_POSES:
        return
    computed, _ = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
    away = np.linalg.norm(computed[:, None] - states.position[None, :, 0], axis=2)
    _, order = linear_sum_assignment(away)
    moved = np.flatnonzero(order != np.arange(len(order)))
    if not len(moved):
        return
    names = [states.runs[run].name for run in states.run]
    left = float(np.median(away[np.arange(len(order)), order]))
    change = InputChange(ChangeKind.POSE_ORDER, tuple(name for k in moved for name in (names[k], names[order[k]])))
    yield KinematicsCorrection(left, len(moved), (change,))


def _frame(x: Floats) -> InputChange:
    return InputChange(ChangeKind.TRACKER_FRAME, sizes=tuple(x[:6].tolist()))


def _target(x: Floats) -> InputChange:
    return InputChange(ChangeKind.TARGET, sizes=tuple(x[6:9].tolist()))


def _zeros(chain: Chain, joints: list[int], x: Floats) -> tuple[InputChange, ...]:
    names = _names(chain, x.size - 9)
    sizes = [float(x[9 + k]) if chain.prismatic[k] else _wrap_angle(x[9 + k]) for k in joints]
    return (InputChange(ChangeKind.ZERO, tuple(names[k] for k in joints), tuple(sizes)),)


def _names(chain: Chain, n_joints: int) -> tuple[str, ...]:
    return (*chain.joint_names, *(str(k + 1) for k in range(len(chain.joint_names), n_joints)))


def _wrap_angle(angle: float) -> float:
    """Return an angle between −π and π, rad."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
