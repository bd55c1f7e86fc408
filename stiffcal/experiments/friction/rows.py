"""Friction runs as equations: torque of a drive = its friction at its velocity + what weight and inertia add.

Passes at constant velocity: the mean weight over a stretch is one unknown for all passes of that stretch, so that only
the difference of the two directions is friction. Other motion: weight and inertia are linear in ten numbers of each
link and the inertia of each drive; a constant stands for the torque sensor's zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.experiments.friction.readings import FreeMotion, SteadyReadings
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rigid_body import drive_matrix, inertial_regressor

# Motion is judged in held-out pieces of this length: strokes of robots in quick motion take half a second to a second.
PIECE_S = 1.0
# What is less than this share of the largest is rounding instead of zero.
ROUNDING = 1e-12


class UnknownKind(Enum):
    """What an unknown next to friction stands for."""

    STRETCH = auto()
    """The mean weight over a stretch of angle, N·m."""
    INERTIA = auto()
    """One of the ten numbers of a link's mass, first moments and inertia."""
    ROTOR = auto()
    """Inertia of a drive, kg·m²."""
    TORQUE_ZERO = auto()
    """What a drive's torque reads without load, N·m."""
    BEARING_COULOMB = auto()
    """Friction of a joint's own bearing that does not depend on speed, N·m."""
    BEARING_VISCOUS = auto()
    """The part of it that grows with the velocity, N·m·s/rad."""


class Unknown(NamedTuple):
    """An unknown of the equations next to friction."""

    kind: UnknownKind
    number: int
    """Of the stretch, the inertial number (from 1), or the joint (from 1)."""


@dataclass(frozen=True)
class FrictionRows:
    """k equations: ``torque = friction of its joint at its velocity + nuisance @ unknowns``."""

    joint: Integers
    """(k,) joint of the row, from 1."""
    velocity: Floats
    """(k,) rad/s, of the drive at the joint's side."""
    torque: Floats
    """(k,) N·m, measured."""
    nuisance: Floats
    """(k, m) what weight, inertia and zeros add per unit of their m unknowns."""
    steady: Booleans
    """(k,) True for a pass at constant velocity, False for a sample of other motion."""
    repeat: Integers
    """(k,) rows with one number here are repeats of each other: one stretch in one direction, or a single sample."""
    piece: Integers
    """(k,) number of what is left out together in cross-validation: a stretch, that is all passes at one speed, or a
    second (`PIECE_S`) of other motion.
    """
    source: Integers
    """(k,) index into the readings or samples that the rows come from."""
    run: NDArray[np.str_]
    """(k,) name of the run."""
    unknown: tuple[Unknown, ...]
    """(m,) the unknowns of ``nuisance``."""

    def __len__(self) -> int:
        return int(self.joint.size)

    def select(self, keep: Booleans | Integers) -> FrictionRows:
        """Return some of the rows; unknowns that none of them feels are left out."""
        names = [name for name in self.__dataclass_fields__ if name != "unknown"]
        picked = replace(self, **{name: getattr(self, name)[keep] for name in names})
        return _felt(picked)


def felt_columns(nuisance: Floats) -> Booleans:
    """Return (p,) True for the unknowns that rows (n, p) feel by more than rounding.

    Weight about a vertical axis is 1e-16 of what it is about others. Scaled to the others' size, such a column would
    take whatever is left of the torque.
    """
    size = np.abs(nuisance).max(axis=0, initial=0.0)
    return np.asarray(size > ROUNDING * size.max(initial=0.0), dtype=np.bool_)


def _felt(rows: FrictionRows) -> FrictionRows:
    """Return rows without the unknowns that none of them feels."""
    felt = np.flatnonzero(felt_columns(rows.nuisance))
    return replace(rows, nuisance=rows.nuisance[:, felt], unknown=tuple(rows.unknown[k] for k in felt))


def steady_rows(readings: SteadyReadings) -> FrictionRows:
    """Return an equation for every pass that is used.

    A pass is one motion of one joint at constant velocity, a stretch the range of angle that passes share
    (`SteadyReadings.stretch`). Repeats are passes of one stretch in one direction.
    """
    index = np.flatnonzero(readings.used)
    picked = readings.select(index)
    stretches, stretch_index = np.unique(picked.stretch, return_inverse=True)
    forward = (picked.velocity > 0.0).astype(np.int64)
    names = np.array([readings.runs[k].name for k in picked.run], dtype=np.str_)
    return FrictionRows(
        joint=picked.joint,
        velocity=picked.velocity,
        torque=picked.torque,
        nuisance=np.eye(stretches.size)[stretch_index],
        steady=np.ones(index.size, dtype=np.bool_),
        repeat=2 * stretch_index + forward,  # one number for each stretch and direction
        piece=stretch_index,
        source=index,
        run=names,
        unknown=tuple(Unknown(UnknownKind.STRETCH, int(number)) for number in stretches),
    )


def motion_rows(motion: FreeMotion, chain: Chain) -> FrictionRows:
    """Return an equation for every joint and sample in which its drive went one way all the time."""
    inertia = inertial_regressor(chain, motion.angles, motion.velocity, motion.acceleration)
    inertia = np.einsum("ji,njk->nik", drive_matrix(chain), inertia)
    n, count = motion.torque.shape
    rotor, zero = np.zeros((n, count, count)), np.zeros((n, count, count))
    for j in range(count):
        rotor[:, j, j], zero[:, j, j] = motion.drive_acceleration[:, j], 1.0
    bearing, unknowns_of_bearing, clear = _bearings(motion, chain)
    nuisance = np.concatenate([inertia, rotor, zero, bearing], axis=2)
    unknown = [Unknown(UnknownKind.INERTIA, k + 1) for k in range(inertia.shape[2])]
    unknown += [Unknown(UnknownKind.ROTOR, j + 1) for j in range(count)]
    unknown += [Unknown(UnknownKind.TORQUE_ZERO, j + 1) for j in range(count)] + unknowns_of_bearing
    sample, joint = np.nonzero(motion.one_way & clear)
    rows = nuisance[sample, joint]
    second = np.floor((motion.time - motion.time.min()) / PIECE_S).astype(np.int64)
    pieces = np.unique(np.stack([motion.run, second], axis=1), axis=0, return_inverse=True)[1].ravel()
    names = np.array([run.name for run in motion.runs], dtype=np.str_)[motion.run]
    equations = FrictionRows(
        joint=joint + 1,
        velocity=motion.drive_velocity[sample, joint],
        torque=motion.torque[sample, joint],
        nuisance=rows,
        steady=np.zeros(sample.size, dtype=np.bool_),
        repeat=np.arange(sample.size),
        piece=pieces[sample],
        source=sample,
        run=names[sample],
        unknown=tuple(unknown),
    )
    return _felt(equations)


def _bearings(motion: FreeMotion, chain: Chain) -> tuple[Floats, list[Unknown], Booleans]:
    """Return friction of the joints' own bearings where drives sit on combined axes, as in a wrist.

    There a drive's friction follows its shaft, which turns with several joints, and the bearing's follows the joint; on
    all other joints the two turn together and are one.

    Returns
    -------
    (n, J, b) torque on each drive per unit, the b unknowns, and (n, J) True where the sign of every bearing that a
    drive feels is one number.
    """
    n, count = motion.torque.shape
    matrix = drive_matrix(chain)
    columns: list[Floats] = []
    unknowns: list[Unknown] = []
    clear = np.ones((n, count), dtype=np.bool_)
    for joint in np.flatnonzero(chain.mechanical & (np.count_nonzero(matrix, axis=1) > 1)):
        velocity = motion.velocity[:, joint]
        sign = np.sign(velocity)
        same = (sign == np.roll(sign, 1)) & (sign == np.roll(sign, -1)) & (sign != 0.0)
        clear[:, matrix[joint] != 0.0] &= same[:, None]
        for kind, value in ((UnknownKind.BEARING_COULOMB, sign), (UnknownKind.BEARING_VISCOUS, velocity)):
            columns.append(value[:, None] * matrix[joint])
            unknowns.append(Unknown(kind, int(joint) + 1))
    return (np.stack(columns, axis=2) if columns else np.zeros((n, count, 0))), unknowns, clear


def stacked_rows(tables: Sequence[FrictionRows]) -> FrictionRows:
    """Return the equations of several kinds, each with unknowns of its own other than friction."""
    total = sum(table.nuisance.shape[1] for table in tables)
    nuisance, done = [], 0
    for table in tables:
        wide = np.zeros((len(table), total))
        wide[:, done : done + table.nuisance.shape[1]] = table.nuisance
        done += table.nuisance.shape[1]
        nuisance.append(wide)
    repeat, piece, ahead_repeat, ahead_piece = [], [], 0, 0
    for table in tables:
        repeat.append(table.repeat + ahead_repeat)
        piece.append(table.piece + ahead_piece)
        ahead_repeat += int(table.repeat.max(initial=-1)) + 1
        ahead_piece += int(table.piece.max(initial=-1)) + 1

    def joined(name: str) -> NDArray[np.generic]:
        return np.concatenate([getattr(table, name) for table in tables])

    return FrictionRows(
        joint=np.asarray(joined("joint"), dtype=np.int64),
        velocity=np.asarray(joined("velocity"), dtype=np.float64),
        torque=np.asarray(joined("torque"), dtype=np.float64),
        nuisance=np.concatenate(nuisance),
        steady=np.asarray(joined("steady"), dtype=np.bool_),
        repeat=np.concatenate(repeat),
        piece=np.concatenate(piece),
        source=np.asarray(joined("source"), dtype=np.int64),
        run=np.asarray(joined("run"), dtype=np.str_),
        unknown=tuple(unknown for table in tables for unknown in table.unknown),
    )


def together(rows: FrictionRows) -> list[Booleans]:
    """Split rows into parts that share no unknown: the joints of one motion go together, others alone."""
    moving = set(rows.joint[~rows.steady].tolist())
    groups = [np.isin(rows.joint, list(moving))] if moving else []
    return groups + [rows.joint == joint for joint in np.unique(rows.joint) if joint not in moving]
