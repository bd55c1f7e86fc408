"""The geometry of a fit as zeros, lengths and twists in a convention, each with its uncertainty.

The fit's own numbers, shifts and tilts of the axes, are complete and free of what no place can show, but no drawing
holds them. A convention's numbers follow from them by `stiffcal.mechanics.joint_rows`; their uncertainties by first
derivatives, taken as central differences (delta method; GUM 2008, 5.1.2 and 5.2.2).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.answers.geometry_results import (
    GeometryFound,
    NoOffsets,
    OffsetsAlone,
    StatedBeta,
    StatedLink,
    StatedNumber,
    StatedZero,
)
from stiffcal.identification.fitting.fit import Fit
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.joint_rows import JointRows, RowsOfChain, nearly_parallel, rows_of_chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import FramePosition

# Steps of the differences, m and rad: rows bend on the scale of the lengths, a tenth of a metre.
STEP = 1e-6
# A number that moves less than this, per m and rad, does not depend on a parameter.
DEPENDS = 1e-6
_COLUMNS = ("theta", "d", "a", "alpha", "beta")
_SYMBOLS = {"theta": "θ", "d": "d", "a": "a", "alpha": "α", "beta": "β"}
# Steps to the best offsets; from the third on each gains the factor of the geometry's error, a thousandth.
MOST_STEPS = 50
# Smallest step to them, rad and m: less than any controller takes.
SETTLED = 1e-10
_OF_FRAMES = 1e-3
"""Part of a zero's motion that frames do not make, below which the zero is theirs: axes are parallel to a mrad."""


@dataclass(frozen=True)
class HeldEnds:
    """Which zeros are a choice, because frames are found by the same places."""

    first: tuple[str, ...]
    """Names of what the first joint's zero cannot be separated from; empty where it can."""
    last: tuple[str, ...]
    """Of the last joint's."""


def held_ends(robot: CompliantRobot, target_names: tuple[str, ...]) -> HeldEnds:
    """Return which zeros frames that are found make a choice.

    Parameters
    ----------
    robot : with the frames as parts of its model. target_names : of the measured targets.
    """
    found = [placed.place.frame for placed in robot.placed if isinstance(placed.effect, FramePosition)]
    targets = [name for name in found if name in target_names]
    last = tuple(f"frame.{name}" for name in targets) if set(target_names) <= set(targets) else ()
    return HeldEnds(tuple(f"frame.{name}" for name in found if name not in target_names), last)


def calibrated_rows(
    robot: CompliantRobot, planned: RowsOfChain, held: HeldEnds, *, strict: bool = False
) -> RowsOfChain:
    """Return a fitted robot's rigid geometry as rows.

    Parameters
    ----------
    robot : with values. planned : rows of the robot file. held : zeros that keep their values.
    strict : without β.
    """
    return rows_of_chain(
        robot.adjusted_chain, planned, first_held=bool(held.first), last_held=bool(held.last), strict=strict
    )


def geometry_found(fit: Fit, planned: RowsOfChain) -> GeometryFound | None:
    """Return the geometry of a fit of absolute places; None where the model has none.

    Parameters
    ----------
    fit : the fit. planned : rows of the robot file, as `stiffcal.campaign.robot.geometry.planned_rows` returns them.
    """
    names = _geometry_parameters(fit)
    if not names or not fit.data.absolute.any():
        return None
    robot, held = fit.robot, held_ends(fit.robot, fit.data.setup.target_names)
    rows = calibrated_rows(robot, planned, held).rows
    present = robot.values()

    def numbers(values: Mapping[str, float]) -> Floats:
        of_values = calibrated_rows(robot.with_values(values), planned, held).rows
        return np.array([getattr(of_values, column) for column in _COLUMNS])

    slopes = {}
    for name in names:
        ahead, behind = (numbers({name: present.get(name, 0.0) + sign * STEP}) for sign in (1.0, -1.0))
        slopes[name] = (ahead - behind) / (2.0 * STEP)
    known = [name for name in names if name in fit.free_names]
    where = [fit.free_names.index(name) for name in known]
    covariance = fit.covariance[np.ix_(where, where)]
    slope = np.array([slopes[name] for name in known]).reshape(len(known), len(_COLUMNS), robot.chain.n_joints)
    std = np.sqrt(np.einsum("pij,pq,qij->ij", slope, covariance, slope))
    open_names = {name: slopes[name] for name in names if name not in known}
    return _stated(rows, planned.rows, std, open_names, held, fit)


def _geometry_parameters(fit: Fit) -> list[str]:
    """Return the full names of what the fit could have changed of the rigid robot."""
    chain, angles = fit.robot.chain, np.zeros((fit.robot.chain.n_joints, 1))
    names = []
    for placed in fit.robot.placed:
        if not placed.geometry_terms(chain, angles):
            continue
        moved = placed.adjusted_chain(chain, {spec.symbol: 1e-3 for spec in placed.effect.parameters})
        if not np.array_equal(moved.fixed, chain.fixed):
            names += [placed.parameter_name(spec.symbol) for spec in placed.effect.parameters]
    return [name for name in names if name not in fit.fixed]


def _stated(
    rows: JointRows, planned: JointRows, std: Floats, open_names: Mapping[str, Floats], held: HeldEnds, fit: Fit
) -> GeometryFound:
    chain = fit.robot.chain
    last = chain.n_joints - 1
    parallel = nearly_parallel(planned)
    with_beta = np.zeros(last + 1, dtype=np.bool_)
    between = np.arange(last + 1)[planned.between]
    with_beta[between] = parallel[:-1]

    shared = _shared_numbers(open_names, fit, held)

    def number(column: str, k: int, choice: tuple[str, ...] = ()) -> StatedNumber:
        value, before = (float(getattr(of, column)[k]) for of in (rows, planned))
        place = _COLUMNS.index(column)
        sharing = list(choice) or shared.get((column, k), [])
        return StatedNumber(
            value=value,
            change=value - before,
            std=None if sharing else float(std[place, k]),
            cannot_be_separated_from=sharing or None,
        )

    def choice_of_d(k: int) -> tuple[str, ...]:
        by_frame = _of_end(k, last, held)
        return by_frame or ((f"d of joint {k + 2}",) if parallel[k] else ())

    changes = np.where(chain.prismatic, rows.d - planned.d, rows.theta - planned.theta)
    logged = np.linalg.lstsq(chain.coupling, changes, rcond=None)[0]
    offsets = best_offsets(fit, held)
    return GeometryFound(
        convention=rows.convention,
        zeros=[
            StatedZero(
                joint=k + 1,
                theta=number("theta", k, _of_end(k, last, held)),
                logged=float(logged[k]),
                prismatic=True if chain.prismatic[k] else None,
            )
            for k in range(last + 1)
        ],
        links=[
            StatedLink(
                joint=k + 1,
                d=number("d", k, choice_of_d(k)),
                a=number("a", k) if k in between else None,
                alpha=number("alpha", k) if k in between else None,
            )
            for k in range(last + 1)
        ],
        beta=[StatedBeta(joint=k + 1, beta=number("beta", k)) for k in np.flatnonzero(with_beta).tolist()],
        offsets_alone=offsets if isinstance(offsets, OffsetsAlone) else None,
        no_offsets=offsets if isinstance(offsets, NoOffsets) else None,
    )


def _shared_numbers(open_names: Mapping[str, Floats], fit: Fit, held: HeldEnds) -> dict[tuple[str, int], list[str]]:
    """Return (column, joint from 0) of each number that is not determined to what makes the same motion.

    Numbers that hang on parameters of one set, of which a combination alone is known, make each other's motion.
    """
    depends = {
        (column, int(k)): {name for name, slope in open_names.items() if abs(slope[place, k]) > DEPENDS}
        for place, column in enumerate(_COLUMNS)
        for k in range(fit.robot.chain.n_joints)
    }
    # a shift of the base before a prismatic joint is one of the joints after it
    of_base = {name for name in open_names if fit.robot.chain.prismatic[0] and name.endswith((".x", ".y"))}
    result: dict[tuple[str, int], list[str]] = {}
    for own, names in depends.items():
        together = {member for group in fit.ambiguities if names & set(group.names) for member in group.names}
        others = [other for other, theirs in depends.items() if other != own and theirs & together]
        if names and names <= of_base and held.first:
            result[own] = list(held.first)
        elif names:
            words = [f"{_SYMBOLS[column]} of joint {k + 1}" for column, k in others]
            result[own] = words + sorted(name for name in together if name not in open_names) or sorted(names)
    return result


def _of_end(k: int, last: int, held: HeldEnds) -> tuple[str, ...]:
    return (held.first if k == 0 else ()) + (held.last if k == last else ())


def best_offsets(fit: Fit, held: HeldEnds) -> OffsetsAlone | NoOffsets:
    """Return the zeros that bring the robot file's robot nearest to the calibrated one, over the measured poses.

    A zero whose motion in these poses is one of the frames stays 0, such as that of an axis parallel to a track before
    it.

    Parameters
    ----------
    fit : the fit. held : frames that are found: a controller takes base and tool frames too, so that they follow.
    """
    robot = fit.robot
    angles = fit.data.angles[:, fit.data.absolute].T
    wanted = _places(robot.adjusted_chain, angles, fit)
    coupling = robot.chain.coupling
    # a motion of the base about or along joint 1, or of the tool about or along the last joint, is the same
    free = [
        k
        for k in range(coupling.shape[1])
        if not (held.first and k == 0) and not (held.last and k == len(coupling) - 1)
    ]
    frames = list(_frame_columns(robot.chain, angles, fit, held))
    nominal = _places(robot.chain, angles, fit)
    own = {k: (_places(robot.chain, angles + STEP * coupling[:, k], fit) - nominal) / STEP for k in free}
    without = {k: _beyond(frames, column) for k, column in own.items()}
    free = [k for k in free if np.linalg.norm(without[k]) > _OF_FRAMES * np.linalg.norm(own[k])]

    def left_by(zeros: Floats) -> Floats:
        return _beyond(frames, wanted - _places(robot.chain, angles + coupling @ zeros, fit))

    zeros = np.zeros(coupling.shape[1])
    left = left_by(zeros)
    without_any = float(np.linalg.norm(left))
    settled = not free
    for _ in range(MOST_STEPS):
        if settled:
            break
        at = angles + coupling @ zeros
        reached = _places(robot.chain, at, fit)
        columns = [(_places(robot.chain, at + STEP * coupling[:, k], fit) - reached) / STEP for k in free]
        matrix = np.array([*columns, *frames]).reshape(len(free) + len(frames), -1).T
        scale = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        step = np.zeros_like(zeros)
        step[free] = (np.linalg.lstsq(matrix / scale, (wanted - reached).ravel(), rcond=1e-9)[0] / scale)[: len(free)]
        # halved until it leads nearer, or is none
        while (tried := left_by(zeros + step)) @ tried > left @ left and np.abs(step).max() > SETTLED:
            step = 0.5 * step
        settled = bool(np.abs(step).max() <= SETTLED)
        if tried @ tried <= left @ left:
            zeros, left = zeros + step, tried
    if not settled:
        return NoOffsets.NOT_CONVERGED
    length = np.linalg.norm(left.reshape(wanted.shape), axis=-1).ravel()
    low, high = robot.chain.limits.T
    largest = np.where(robot.chain.prismatic, np.inf, np.pi)
    largest = np.minimum(largest, np.where(np.isfinite(high - low), high - low, np.inf))
    if np.linalg.norm(length) > without_any + STEP:  # both may be 0
        return NoOffsets.NO_SMALLER_ERROR
    if (abs(coupling @ zeros) > largest).any():
        return NoOffsets.BEYOND_RANGE
    return OffsetsAlone(
        zeros=zeros.tolist(),
        mean=float(length.mean()),
        median=float(np.median(length)),
        p95=float(np.quantile(length, 0.95)),
        max=float(length.max()),
        rms=float(np.sqrt(np.mean(length**2))),
    )


def _beyond(frames: list[Floats], motion: Floats) -> Floats:
    """Return what frames do not make of a motion, m, flat; the frames at their best."""
    if not frames:
        return motion.ravel()
    matrix = np.array(frames).reshape(len(frames), -1).T
    scaled = matrix / np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    rest: Floats = motion.ravel() - scaled @ np.linalg.lstsq(scaled, motion.ravel(), rcond=1e-9)[0]
    return rest


def _places(chain: Chain, angles: Floats, fit: Fit) -> Floats:
    """Return (B, n, 3) places of the targets, m, base axes, on the rigid chain."""
    return np.array([attached_poses(chain, angles, target)[0] for target in fit.data.setup.targets])


def _frame_columns(chain: Chain, angles: Floats, fit: Fit, held: HeldEnds) -> Iterator[Floats]:
    """Yield (B, n, 3) motions of the targets by the frames that are found: base and tool."""
    places = _places(chain, angles, fit)
    if held.first:
        for axis in np.eye(3):
            yield np.broadcast_to(axis, places.shape)
            yield np.cross(axis, places)
    if held.last:
        for b, target in enumerate(fit.data.setup.targets):
            _, rotation = attached_poses(chain, angles, target)
            for number in range(3):
                column = np.zeros_like(places)
                column[b] = rotation[:, :, number]
                yield column
