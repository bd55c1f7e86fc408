"""What makes kinematics meet the tracker where no single mistake of columns, signs or units does.

Four things misplace every pose by a fixed rule: the tracker's frame, the target's place on the flange, the zeros of
the joints, and the order of the poses. Each is fitted alone to the places in the reference states, by Gauss–Newton
steps with numerical derivatives, and the frames together. A correction counts where many more readings than parameters
are left, and what is left is raised by the parameters' share.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.fault_changes import InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.catalogue.frames.tracker_frame import MisplacedTracker
from stiffcal.mistakes.deciding import AS_GOOD
from stiffcal.mistakes.inputs.mistake import Adjustment, AsRead, InputMistake, InputPart, TakenBack
from stiffcal.mistakes.inputs.taken_back import mistakes_on
from stiffcal.mistakes.references.match import missed_by
from stiffcal.wording import length

# Of numerical derivatives, m and rad: the root of what numbers are rounded to, times a hundred.
STEP = 1e-6
# A step below what a float of metres holds is none; steps that do not get there in so many rounds have no end.
SETTLED, MOST_ROUNDS = 1e-9, 40
# Readings beyond the parameters: two poses more than determine them.
LEAST_FREEDOM = 6
# No step is longer, rad and m: a robot is a few metres long, and a radian is a sixth of the circle.
LONGEST = 1.0


@dataclass(frozen=True)
class KinematicsCorrection:
    """A change of the campaign's geometry that makes kinematics meet the tracker better."""

    left_m: float
    """Median distance that is left, raised by the share of the readings that the parameters take."""
    n_parameters: int
    """How many numbers were fitted."""
    changes: tuple[InputChange, ...]
    """What was changed, with its size."""
    mistakes: tuple[InputMistake, ...]
    """Which mistakes these take back."""

    @property
    def parts(self) -> frozenset[tuple[str, str]]:
        """What was fitted: a correction that holds all parts of another one is no alternative to it."""
        return frozenset(
            (change.kind, name)
            for mistake, change in zip(self.mistakes, self.changes, strict=True)
            for name in (change.names if change.names and mistake.part is not InputPart.ROWS else [""])
        )


@dataclass(frozen=True)
class _Fitted:
    """A mistake, and how it is taken back by numbers that are fitted."""

    mistake: InputMistake
    by: Adjustment


def meeting_corrections(
    read: AsRead, estimated: bool, most_m: float, ways: Sequence[TakenBack]
) -> list[KinematicsCorrection]:
    """Return the corrections that make kinematics meet, the one to name first, then those that do as well.

    Parameters
    ----------
    read : one reference state per pose, with measured places, and the robot.
    estimated : True where the tracker's frame was found from these poses, so that it is fitted with each of the others.
    most_m : a correction that leaves more, m, is none.
    ways : in which mistakes may be taken back; those of which the readings themselves chose some numbers count here.
    """
    meeting = [correction for correction in _corrections(read, estimated, ways) if correction.left_m <= most_m]
    named = meeting[:1]
    for other in meeting[1:]:
        if other.left_m <= AS_GOOD * named[0].left_m and not any(other.parts >= one.parts for one in named):
            named.append(other)
    return named


def correcting_words(meeting: Sequence[KinematicsCorrection], chain: Chain) -> str:
    """Return which corrections make kinematics meet, in words; "" where none does."""
    texts: list[str] = []
    for one in meeting:
        pairs = zip(one.mistakes, one.changes, strict=True)
        words = " and ".join(mistake.texts(change, chain).words for mistake, change in pairs)
        within = f"within {length(one.left_m)}"
        texts.append(f"; or with {words}, {within}" if texts else f"; with {words} they agree {within}")
    return "".join(texts)


def _corrections(read: AsRead, estimated: bool, ways: Sequence[TakenBack]) -> list[KinematicsCorrection]:
    """Return the corrections that these poses determine, the one to name first."""
    candidates = [*_fit_corrections(read, estimated), *(_chosen_by_readings(one) for one in ways if one.numbers)]
    candidates.sort(key=lambda correction: correction.left_m)
    if not candidates:
        return []
    # of those that leave nearly the same the one with fewer parameters is named, the others after it
    as_good = [correction for correction in candidates if correction.left_m <= AS_GOOD * candidates[0].left_m]
    return sorted(as_good, key=lambda correction: correction.n_parameters) + candidates[len(as_good) :]


def _chosen_by_readings(taken: TakenBack) -> KinematicsCorrection:
    """Return the correction that the readings themselves chose."""
    left = float(np.median(np.linalg.norm(missed_by(taken.states, taken.chain), axis=1)))
    return KinematicsCorrection(left, taken.numbers, (taken.change,), (taken.mistake,))


def _fit_corrections(read: AsRead, estimated: bool) -> Iterator[KinematicsCorrection]:
    """Yield the corrections that are numbers to be fitted: each alone, then those of the frames together."""
    fitted = [_Fitted(one, by) for one in mistakes_on(read.tried_on) for by in one.adjustments(read)]
    # found from these very poses, the tracker's frame takes up a part of every other mistake
    always = [one for one in fitted if estimated and isinstance(one.mistake, MisplacedTracker)]
    for one in fitted:
        if one not in always:
            yield from _fit(read, [*always, one], len(always))
    frames = [one for one in fitted if one.mistake.part is InputPart.FRAMES]
    if not always:
        yield from _fit(read, frames)


def _fit(read: AsRead, parts: Sequence[_Fitted], n_hidden: int = 0) -> Iterator[KinematicsCorrection]:
    """Yield the correction with the numbers of some mistakes free; none if they stay open.

    Parameters
    ----------
    n_hidden : the first of them are no part of the correction.
    """
    ends = np.cumsum([0, *(len(one.by.start) for one in parts)])
    x = np.concatenate([one.by.start for one in parts])
    n_readings = 3 * len(read.chosen)
    if n_readings - len(x) < LEAST_FREEDOM:
        return

    def residual(numbers: Floats) -> Floats:
        states: LoadStates = read.chosen
        for one, first, last in zip(parts, ends[:-1], ends[1:], strict=True):
            states = one.by.applied(states, numbers[first:last])
        return missed_by(states, read.chain)

    for _ in range(MOST_ROUNDS):
        here = residual(x)
        columns = np.stack([((residual(x + STEP * one) - here) / STEP).ravel() for one in np.eye(len(x))], axis=1)
        step = np.linalg.lstsq(columns, -here.ravel(), rcond=1e-9)[0]
        x = x + np.clip(step, -LONGEST, LONGEST)
        if np.abs(step).max() < SETTLED:
            break
    else:
        return
    away = np.linalg.norm(residual(x), axis=1)
    remaining_m = float(np.median(away)) * np.sqrt(n_readings / (n_readings - len(x)))
    changes = [
        InputChange(one.mistake.name, one.by.names, one.by.sizes(x[first:last]))
        for one, first, last in zip(parts, ends[:-1], ends[1:], strict=True)
    ]
    mistakes = tuple(one.mistake for one in parts[n_hidden:])
    yield KinematicsCorrection(remaining_m, len(x), tuple(changes[n_hidden:]), mistakes)
