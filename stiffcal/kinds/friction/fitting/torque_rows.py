"""Friction runs as equations: torque of a drive = what its motion makes (friction, ripple) + weight and inertia.

Passes at constant velocity are cut into bins of position, direction, speed and time, and each bin's mean is an
equation, as good as neighbouring samples scatter. Where gravity acts about the axis, the weight is A cos q + B sin q
for each place of the other joints, and one constant for each speed, so that only the difference of the two directions
is friction. Other motion: weight and inertia are linear in ten numbers of each link and the inertia of each drive; a
constant is the torque sensor's zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from enum import Enum, auto
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.kinds.friction.fitting.pass_noise import pass_noise
from stiffcal.kinds.friction.logs.readings import FreeMotion
from stiffcal.kinds.friction.logs.samples import PassSamples
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rigid_body import drive_matrix, inertial_regressor, rigid_torque
from stiffcal.model.balance.stated_spring import spring_torque
from stiffcal.model.drive_motion import DriveMotion

# Motion is judged in held-out pieces of this length: strokes of robots in quick motion take half a second to a second.
PIECE_S = 1.0
# Means over more bins than this make nothing more identifiable from a joint's passes, and cost time.
MOST_BINS = 500
# What is less than this share of the largest is rounding instead of zero.
ROUNDING = 1e-12


class UnknownKind(Enum):
    """What an unknown next to friction stands for."""

    STRETCH = auto()
    """A constant of the passes at one speed, N·m."""
    WEIGHT_COS = auto()
    """Weight that follows the cosine of the joint's angle, N·m."""
    WEIGHT_SIN = auto()
    """Weight that follows its sine, N·m."""
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
    """Of the stretch, the place of the other joints, the inertial number (from 1), or the joint (from 1)."""


@dataclass(frozen=True)
class FrictionRows:
    """k equations: ``torque = what the joint's motion makes + nuisance @ unknowns``.

    Each is the mean over some of N samples.
    """

    joint: Integers
    """(k,) joint of the row, from 1."""
    velocity: Floats
    """(k,) rad/s, of the drive at the joint's side."""
    torque: Floats
    """(k,) N·m, measured."""
    sigma: Floats
    """(k,) N·m, the noise of ``torque``; NaN where neighbouring samples do not show it."""
    noise_dof: Floats
    """(k,) degrees of freedom behind ``sigma``."""
    nuisance: Floats
    """(k, m) what weight, inertia and zeros add per unit of their m unknowns."""
    steady: Booleans
    """(k,) True for a mean within passes at constant velocity, False for a sample of other motion."""
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
    motion: DriveMotion
    """N samples of all rows."""
    row: Integers
    """(N,) row of each sample."""
    logged_travel: Mapping[int, tuple[float, float]]
    """Joint to its smallest and largest logged angle, rad."""
    first_temperature: Mapping[int, float]
    """Joint to the temperature, K, above which those of ``motion`` are counted; NaN where none is logged."""

    def __len__(self) -> int:
        return int(self.joint.size)

    def select(self, keep: Booleans | Integers) -> FrictionRows:
        """Return some of the rows, in their order; unknowns that none of them feels are left out."""
        chosen = np.zeros(len(self), dtype=np.bool_)
        chosen[keep] = True
        apart = ("unknown", "motion", "row", "logged_travel", "first_temperature")
        names = [name for name in self.__dataclass_fields__ if name not in apart]
        samples = chosen[self.row]
        number = np.cumsum(chosen) - 1
        picked = replace(
            self,
            **{name: getattr(self, name)[chosen] for name in names},
            motion=self.motion.block(samples),
            row=number[self.row[samples]],
        )
        return _felt(picked)

    def motion_of(self, joint: int, with_travel: bool = False) -> DriveMotion:
        """Return a joint's samples; ``with_travel`` with two more at the ends of its whole logged travel."""
        samples = np.flatnonzero(self.joint[self.row] == joint)
        motion = self.motion.block(samples)
        if not with_travel or not samples.size or joint not in self.logged_travel:
            return motion
        ends = self.motion.block(samples[[-1, -1]])
        return stacked_drive_motion([motion, replace(ends, angle=np.array(self.logged_travel[joint]))])

    def means(self, values: Floats) -> Floats:
        """Return (k,) means over each row's samples of values (N,), of which NaN stays NaN."""
        count = np.bincount(self.row, minlength=len(self))
        return np.asarray(np.bincount(self.row, weights=values, minlength=len(self)) / np.maximum(count, 1))

    def without(self, kind: UnknownKind, joint: int) -> FrictionRows:
        """Return the rows without the unknowns of one kind that act on a joint's rows."""
        of_joint = self.joint == joint
        keep = [
            k
            for k, unknown in enumerate(self.unknown)
            if unknown.kind is not kind or not self.nuisance[of_joint, k].any()
        ]
        return replace(self, nuisance=self.nuisance[:, keep], unknown=tuple(self.unknown[k] for k in keep))


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


def steady_rows(samples: PassSamples) -> FrictionRows:
    """Return an equation for every bin of passes at constant velocity."""
    order = np.lexsort((samples.time, samples.run, samples.joint))
    samples = samples.select(order)
    row = _bins(samples)
    k = int(row.max(initial=-1)) + 1
    first = np.unique(row, return_index=True)[1]
    count = np.bincount(row, minlength=k)
    sigma, dof = np.full(k, np.nan), np.zeros(k)
    time = _since_first(samples)
    for joint in np.unique(samples.joint):
        of_joint = np.flatnonzero(samples.joint == joint)
        noise = pass_noise(
            samples.torque[of_joint], samples.reading[of_joint], samples.stretch[of_joint],
            samples.n_readings[of_joint].astype(np.float64),
        )  # fmt: skip
        if noise is not None:
            rows = np.unique(row[of_joint])
            size = np.bincount(row[of_joint], weights=noise.sigma, minlength=k)[rows] / count[rows]
            sigma[rows], dof[rows] = size * noise.of_mean(count[rows]), noise.dof
    reference = np.array([samples.first_temperature[joint] for joint in samples.joint.tolist()])
    motion = DriveMotion(
        samples.velocity, samples.angle, samples.load, samples.temperature - reference, time, samples.travel
    )
    stretch_index = np.unique(samples.stretch[first], return_inverse=True)[1]
    nuisance, unknown = _weight_columns(samples, row, first)
    names = np.array([samples.runs[number].name for number in samples.run[first]], dtype=np.str_)
    rows_of = FrictionRows(
        joint=samples.joint[first], velocity=samples.velocity[first], torque=np.zeros(k), sigma=sigma, noise_dof=dof,
        nuisance=nuisance, steady=np.ones(k, dtype=np.bool_), piece=stretch_index, source=samples.reading[first],
        run=names, unknown=unknown, motion=motion, row=row, logged_travel=samples.logged_travel,
        first_temperature=samples.first_temperature,
    )  # fmt: skip
    return replace(rows_of, torque=rows_of.means(samples.torque), velocity=rows_of.means(samples.velocity))


def _bins(samples: PassSamples) -> Integers:
    """Return (n,) the row of each sample: so many positions of each pass, `MOST_BINS` at most for a joint.

    Of more passes than that, neighbours in time at one speed and in one direction share their rows.
    """
    row = np.zeros(len(samples), dtype=np.int64)
    done = 0
    for joint in np.unique(samples.joint):
        of_joint = np.flatnonzero(samples.joint == joint)
        passes = np.unique(samples.reading[of_joint])
        positions = max(MOST_BINS // len(passes), 1)
        together = -(-len(passes) // MOST_BINS)
        filled: dict[tuple[int, bool], int] = {}
        rows_of: dict[tuple[int, bool, int], int] = {}
        for reading in passes.tolist():
            members = of_joint[samples.reading[of_joint] == reading]
            level = (int(samples.stretch[members[0]]), bool(samples.velocity[members[0]] > 0.0))
            group = filled.get(level, 0) // together
            filled[level] = filled.get(level, 0) + 1
            if (*level, group) not in rows_of:
                rows_of[*level, group] = done
                done += min(positions, members.size)
            n_bins = min(positions, members.size) if together == 1 else 1
            row[members] = rows_of[*level, group] + np.arange(members.size) * n_bins // members.size
    return np.unique(row, return_inverse=True)[1].astype(np.int64)


def _since_first(samples: PassSamples) -> Floats:
    """Return (n,) s since each joint's first sample; logs whose clocks begin anew follow one another."""
    time = samples.time.copy()
    for joint in np.unique(samples.joint):
        last = -np.inf
        of_joint = samples.joint == joint
        for run in np.unique(samples.run[of_joint]):
            chosen = of_joint & (samples.run == run)
            shift = last - float(time[chosen].min()) if last > float(time[chosen].min()) else 0.0
            time[chosen] += shift
            last = float(time[chosen].max())
        time[of_joint] -= float(time[of_joint].min())
    return time


def _weight_columns(samples: PassSamples, row: Integers, first: Integers) -> tuple[Floats, tuple[Unknown, ...]]:
    """Return (k, m) what weight adds to each row, and its m unknowns; none where gravity does not act about an axis."""
    count = np.maximum(np.bincount(row, minlength=len(first)), 1)
    columns: list[Floats] = []
    unknown: list[Unknown] = []
    weighs = samples.carries_weight
    for pose in np.unique(samples.pose[weighs]):
        chosen = weighs & (samples.pose == pose)
        for kind, wave in ((UnknownKind.WEIGHT_COS, np.cos), (UnknownKind.WEIGHT_SIN, np.sin)):
            columns.append(np.bincount(row, weights=np.where(chosen, wave(samples.angle), 0.0)) / count)
            unknown.append(Unknown(kind, int(pose)))
    for stretch in np.unique(samples.stretch[weighs]):
        columns.append((weighs & (samples.stretch == stretch))[first].astype(np.float64))
        unknown.append(Unknown(UnknownKind.STRETCH, int(stretch)))
    return (np.stack(columns, axis=1) if columns else np.zeros((len(first), 0))), tuple(unknown)


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
    n_rows, drives = sample.size, _drive_motion(motion, chain, sample, joint)
    equations = FrictionRows(
        joint=joint + 1,
        velocity=motion.drive_velocity[sample, joint],
        torque=(motion.torque + spring_torque(chain, motion.angles) @ drive_matrix(chain))[sample, joint],
        sigma=np.full(n_rows, np.nan),
        noise_dof=np.zeros(n_rows),
        nuisance=rows,
        steady=np.zeros(n_rows, dtype=np.bool_),
        piece=pieces[sample],
        source=sample,
        run=names[sample],
        unknown=tuple(unknown),
        motion=drives,
        row=np.arange(n_rows),
        logged_travel={
            number + 1: (float(drives.angle[joint == number].min()), float(drives.angle[joint == number].max()))
            for number in np.unique(joint).tolist()
        },
        first_temperature={},
    )
    return _felt(equations)


def _drive_motion(motion: FreeMotion, chain: Chain, sample: Integers, joint: Integers) -> DriveMotion:
    """Return what the drives do in samples (k,) of joints (k,), from 0; temperature and reversals are not known."""
    unknown = np.full(sample.size, np.nan)
    load, spring = np.zeros_like(motion.torque), spring_torque(chain, motion.angles)
    if chain.masses_known:
        rest = np.zeros_like(motion.angles)
        load = (rigid_torque(chain, motion.angles, rest, rest) - spring) @ drive_matrix(chain)
    logged = (motion.angles - chain.offset) @ np.linalg.pinv(chain.coupling).T
    time = motion.time[sample] - float(motion.time.min(initial=np.inf))
    return DriveMotion(
        motion.drive_velocity[sample, joint], logged[sample, joint], load[sample, joint], unknown, time, unknown
    )


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
    piece, ahead_piece, row, ahead_row = [], 0, [], 0
    for table in tables:
        piece.append(table.piece + ahead_piece)
        ahead_piece += int(table.piece.max(initial=-1)) + 1
        row.append(table.row + ahead_row)
        ahead_row += len(table)

    def joined(name: str) -> NDArray[np.generic]:
        return np.concatenate([getattr(table, name) for table in tables])

    return FrictionRows(
        joint=np.asarray(joined("joint"), dtype=np.int64),
        velocity=np.asarray(joined("velocity"), dtype=np.float64),
        torque=np.asarray(joined("torque"), dtype=np.float64),
        sigma=np.asarray(joined("sigma"), dtype=np.float64),
        noise_dof=np.asarray(joined("noise_dof"), dtype=np.float64),
        nuisance=np.concatenate(nuisance),
        steady=np.asarray(joined("steady"), dtype=np.bool_),
        piece=np.concatenate(piece),
        source=np.asarray(joined("source"), dtype=np.int64),
        run=np.asarray(joined("run"), dtype=np.str_),
        unknown=tuple(unknown for table in tables for unknown in table.unknown),
        motion=stacked_drive_motion([table.motion for table in tables]),
        row=np.concatenate(row),
        logged_travel={joint: ends for table in tables for joint, ends in table.logged_travel.items()},
        first_temperature={joint: kelvin for table in tables for joint, kelvin in table.first_temperature.items()},
    )


def stacked_drive_motion(motions: Sequence[DriveMotion]) -> DriveMotion:
    """Return the samples of several motions, one after another."""
    names = [field.name for field in fields(DriveMotion)]
    return DriveMotion(*(np.concatenate([getattr(motion, name) for motion in motions]) for name in names))


def together(rows: FrictionRows) -> list[Booleans]:
    """Split rows into parts that share no unknown: the joints of one motion go together, others alone."""
    moving = set(rows.joint[~rows.steady].tolist())
    groups = [np.isin(rows.joint, list(moving))] if moving else []
    return groups + [rows.joint == joint for joint in np.unique(rows.joint) if joint not in moving]
