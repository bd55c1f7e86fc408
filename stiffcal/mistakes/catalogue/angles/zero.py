"""Zeros of joints that are not the robot file's.

In absolute places a zero is looked for by quarters of a turn: a smaller one is a matter of calibration, and what it
leaves open is the frames'. The unloaded poses of load runs have frames, and any zero of one joint or of all is fitted.
Displacements contradict a zero though nothing measures a place: it turns the joint's axis and all that stands beyond
it. What springs leave is a smooth function of each zero: Gauss–Newton steps go from the best of four quarter turns to
its least value.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.fault_changes import InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import left_by_joints
from stiffcal.mistakes.inputs.mistake import Adjustment, AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way
from stiffcal.mistakes.words import reading_of, sliding
from stiffcal.quantity import LENGTH

# What is added to the logged angle of absolute places.
TURNS = (np.pi / 2, -np.pi / 2, np.pi)
# Where the search for a joint's zero begins, rad: the whole circle lies within half a quarter of one of them.
QUARTERS = (0.0, np.pi / 2, np.pi, -np.pi / 2)
# Of the numerical derivative: the root of what numbers are rounded to, times a thousand; the longest step, which stays
# in the bend of one quarter, and the last one, below what a robot's zero is known to; rad.
STEP, LONGEST, LAST = 1e-5, 0.5, 1e-4
# Steps halve what is left at least; a search that takes longer has no end.
MOST_ROUNDS = 20


class Zero(InputMistake):
    """Another zero of one joint, or of all."""

    name = "zero"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS, TriedOn.REFERENCES, TriedOn.DISPLACEMENTS})
    rank = 25

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield quarters of a turn for absolute places, and for displacements the zero that leaves the least."""
        if read.tried_on is TriedOn.REFERENCES:
            return
        for joint, name in enumerate(read.names):
            if read.chain.prismatic[joint]:
                continue
            of_displacements = read.tried_on is TriedOn.DISPLACEMENTS
            for turn in (_wrapped(_best_turn(read, joint)),) if of_displacements else TURNS:
                yield Way(read.with_joint(joint, read.joints[:, joint] + turn), (name,), (turn,))

    def adjustments(self, read: AsRead) -> Iterator[Adjustment]:
        """Yield the zero of each joint, from each quarter of a turn, and those of all joints together."""
        names = read.names
        for joint, name in enumerate(names):
            for start in (0.0,) if read.chain.prismatic[joint] else QUARTERS:
                sizes = partial(_sizes, read.chain, (joint,))
                yield Adjustment((name,), np.array([start]), partial(_moved, (joint,)), sizes)
        every = tuple(range(len(names)))
        yield Adjustment(names, np.zeros(len(names)), partial(_moved, every), partial(_sizes, read.chain, every))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        slides = sliding(chain)
        parts = [
            f"{LENGTH.usual.factor * size:+.2f} {LENGTH.usual.name} at joint {name}"
            if name in slides
            else f"{np.degrees(size):+.2f}° at joint {name}"
            for name, size in zip(change.names, change.sizes, strict=True)
        ]
        keys = sorted({"d_m" if name in slides else "theta_deg" for name in change.names}, reverse=True)
        one = len(change.names) == 1
        mend = f"correct {' and '.join(keys)} in the robot file by this, or the zero of the controller"
        wrong = f"{reading_of(change.names[0], chain)} lacks {parts[0].partition(' at ')[0]}" if one else ""
        place = f"joint {change.names[0]}" if one else "joints"
        return ChangeTexts(place, f"other zeros: {', '.join(parts)}", mend, wrong)


def _best_turn(read: AsRead, joint: int) -> float:
    """Return by how much the joint's zero moves, rad; of a search that finds no end the best turn on its way."""

    def left(turn: float) -> Floats:
        return left_by_joints(read.with_joint(joint, read.joints[:, joint] + turn), read.chain)[0]

    turn = min(QUARTERS, key=lambda quarter: float(np.sum(left(quarter) ** 2)))
    here = left(turn)
    for _ in range(MOST_ROUNDS):
        slope = (left(turn + STEP) - here) / STEP
        steepness = float(slope @ slope)
        step = float(np.clip(-(slope @ here) / steepness, -LONGEST, LONGEST)) if steepness > 0.0 else 0.0
        there = left(turn + step)
        if abs(step) < LAST or there @ there >= here @ here:
            break
        turn, here = turn + step, there
    return float(turn)


def _moved(joints: tuple[int, ...], states: LoadStates, zeros: Floats) -> LoadStates:
    """Return states with the zeros (p,) of some joints moved, from 0."""
    moved = states.joints.copy()
    moved[:, list(joints)] += zeros
    return replace(states, joints=moved)


def _sizes(chain: Chain, joints: tuple[int, ...], zeros: Floats) -> tuple[float, ...]:
    return tuple(float(zero) if chain.prismatic[k] else _wrapped(zero) for k, zero in zip(joints, zeros, strict=True))


def _wrapped(angle: float) -> float:
    """Return an angle between −π and π, rad."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
