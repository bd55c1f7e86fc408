"""Parameters of frames and geometry that no measured place can separate from the others, whatever the poses.

A turn of the tracker about joint 1's axis and the zero of joint 1 are the same motion; the shift along an axis can be
booked at either end of a link. One convention decides which of such a set are kept: the geometry of the joints from the
base outwards, then the targets, then the tracker across joint 1's axis; what is left over stays where the manifest and
the robot file have it. So a pose has 4 n + 6 numbers and m positions 4 n + 3 m (Everett, Driels and Mooring 1987), the
tracker included.

Found by arithmetic on the robot itself, not by a list: parallel axes, joints that follow others, given frames and
models of part of the joints change which sets there are.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TypeAlias

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.distinguish import SAME_REGRESSOR, distinguish
from stiffcal.identification.readings.observations import Observations
from stiffcal.mechanics.kinematics import StackedFrame, cross, stacked_bodies
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.assembled.measured_frames import FramePosition
from stiffcal.model.balance.equilibrium import displacement_between, last_node_inboard
from stiffcal.model.balance.rest import reported_targets
from stiffcal.model.effect import Inputs
from stiffcal.natural_order import NameKey, natural_key

# Poses at which the motions are compared: three times the numbers that a seven-axis arm can have.
_POSES = 40
_SEED = 16
Rank: TypeAlias = tuple[int, float, NameKey, int]
"""By which parameters are kept: of the convention, the effect's name and place, the parameter's number in it."""
# Of the central differences of frames, in typical sizes (1 mm, 1 mrad): rounding and the curvature leave 1e-10.
_STEP = 1e-2


def redundant_geometry(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> frozenset[str]:
    """Return the full names of geometry and frame parameters that others make up for in every pose.

    Parameters
    ----------
    robot : its geometry is taken as the robot file has it.
    data : which targets are measured, and whether their orientation is.
    fixed : full names that keep their values.
    """
    return frozenset(_null_directions(robot, data, fixed))


def held_frames(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> frozenset[str]:
    """Return the full names of frame parameters that other frames make up for in the poses that were measured.

    A target that has one orientation in all of them may be shifted with the instrument. A convention as that of
    registration: targets stay where the manifest has them. None where displacements count too, which depend on where a
    target is.

    Parameters
    ----------
    robot : its geometry is taken as the robot file has it.
    data : the measured poses, and what was measured of them.
    fixed : full names that keep their values.
    """
    if not data.n_states or not data.absolute.all():
        return frozenset()
    inputs = Inputs(data.angles, np.zeros((6, data.n_states)), data.setup, tracker=data.tracker)
    bodies = stacked_bodies(robot.chain, data.angles)
    names, columns, is_target = [], [], []
    for placed_effect in robot.placed:
        if not isinstance(placed_effect.effect, FramePosition):
            continue
        for symbol, motion in _motions_of(placed_effect, robot, bodies, inputs).items():
            name = placed_effect.parameter_name(symbol)
            if name not in fixed:
                names.append(name)
                columns.append(np.where(data.measured_mask, data.layout.of_targets(motion), 0.0).ravel())
                is_target.append(placed_effect.place.frame in data.setup.target_names)
    if all(is_target):
        return frozenset()  # targets do not move each other
    order = sorted(range(len(names)), key=lambda k: (not is_target[k], natural_key(names[k])))
    return frozenset(names[held] for held in distinguish(np.stack(columns, axis=1), order).held)


def included_in(
    robot: CompliantRobot, data: Observations, fixed: frozenset[str], redundant: Collection[str]
) -> dict[str, list[str]]:
    """Return name of a parameter to those of `redundant_geometry` whose motion is its own in every pose, but for size.

    What several others make up for together is in none of them alone.

    Parameters
    ----------
    robot, data, fixed : as of `redundant_geometry`. redundant : what it returns.
    """
    included: dict[str, list[str]] = {}
    for name, shares in _null_directions(robot, data, fixed).items():
        makers = [other for other, share in shares.items() if abs(share) > SAME_REGRESSOR]
        if name in redundant and len(makers) == 1:
            included.setdefault(makers[0], []).append(name)
    return included


def _null_directions(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> dict[str, dict[str, float]]:
    """Return each redundant parameter with the others' shares in its motion, of motions of unit length."""
    if not data.absolute.any():
        return {}
    motions = _motions(robot, data, fixed)
    if not motions:
        return {}
    names = [name for name, _, _ in motions]
    # the convention keeps the least rank
    order = sorted(range(len(motions)), key=lambda k: motions[k][1])[::-1]
    found = distinguish(np.stack([motion for _, _, motion in motions], axis=1), order)
    return {
        names[held]: {names[k]: float(share[k]) for k in np.flatnonzero(found.free)}
        for held, share in zip(found.held, found.null, strict=True)
    }


def _motions(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> list[tuple[str, Rank, Floats]]:
    """Return (full name, rank of the convention, motion of all targets over the poses) for each free parameter."""
    rng = np.random.default_rng(_SEED)
    chain = robot.chain
    # of what is logged: joints that follow others turn with them alone
    angles = chain.model_angles(rng.uniform(-np.pi, np.pi, (_POSES, chain.coupling.shape[1]))).T
    trackers = len(data.setup.trackers)
    angles = np.tile(angles, trackers)  # each of them reads all poses
    inputs = Inputs(angles, np.zeros((6, angles.shape[1])), data.setup, tracker=np.repeat(np.arange(trackers), _POSES))
    bodies = stacked_bodies(chain, angles)
    measured = _measured_components(data)
    first_axis = np.abs(chain.fixed[0][:3, 2])
    motions = []
    for placed_effect in robot.placed:
        for number, (symbol, motion) in enumerate(_motions_of(placed_effect, robot, bodies, inputs).items()):
            name = placed_effect.parameter_name(symbol)
            if name not in fixed:
                is_target = placed_effect.place.frame in data.setup.target_names
                like = natural_key(placed_effect.parameter_name("")), number
                rank: Rank = (*_rank(placed_effect, symbol, first_axis, is_target), *like)
                if chain.prismatic[0] and placed_effect.place.frame and not is_target and symbol in ("x", "y", "z"):
                    rank = (-1, 0.0, *like)
                motions.append(
                    (name, rank, np.concatenate([(motion[b] * rows[:, None]).ravel() for b, rows in measured]))
                )
    return motions


def _measured_components(data: Observations) -> list[tuple[int, Floats]]:
    """Return each measured target with (6,) 1 for the components that are read of it, else 0."""
    result = []
    for b in range(len(data.setup.targets)):
        components = data.component[(data.kind <= 1) & (data.body == b)]
        if len(components):
            rows = np.zeros(6)
            rows[components] = 1.0
            result.append((b, rows))
    return result


def _motions_of(
    placed_effect: PlacedEffect, robot: CompliantRobot, bodies: list[StackedFrame], inputs: Inputs
) -> dict[str, Floats]:
    """Return symbol to (B, 6, n) motion of the targets per unit of it, base axes, on the undeformed robot."""
    chain, setup = robot.chain, inputs.setup
    targets = reported_targets(bodies, inputs)
    motions: dict[str, Floats] = {}
    if isinstance(placed_effect.effect, FramePosition):
        for spec in placed_effect.effect.parameters:
            step = _STEP * spec.typical
            ahead, behind = (
                reported_targets(bodies, placed_effect.adjusted(inputs, {spec.symbol: end})) for end in (step, -step)
            )
            changes = [displacement_between(after, before) for after, before in zip(ahead, behind, strict=True)]
            motions[spec.symbol] = np.stack(changes) / (2.0 * step)
        return motions
    for term in placed_effect.geometry_terms(chain, inputs.angles):
        joint = (term.node + 1) // 2
        frame = bodies[joint]
        axis = frame.rotation[:, term.component % 3]
        origin = frame.position + float(chain.bearing[joint - 1]) * frame.rotation[:, 2]
        motion = motions.setdefault(term.symbol, np.zeros((len(targets), 6, inputs.angles.shape[1])))
        for b, (target, place) in enumerate(zip(setup.targets, targets, strict=True)):
            if term.node > last_node_inboard(target.body, chain.n_joints):
                continue
            if term.component < 3:
                motion[b, :3] += term.value * axis
            else:
                motion[b, :3] += term.value * cross(axis, place.position - origin)
                motion[b, 3:] += term.value * axis
    return motions


def _rank(placed_effect: PlacedEffect, symbol: str, first_axis: Floats, is_target: bool) -> tuple[int, float]:
    """Return the order in which parameters are kept: the least come first, of like ones by their names.

    Geometry of joints 2 to n, targets, the tracker across joint 1's axis, zeros of joints, the tracker along and about
    that axis, joint 1's geometry. Where joint 1 is prismatic any shift of the base is one of the joints after it: there
    the tracker's place comes first, so that their geometry stays near the robot file's.
    """
    effect, place = placed_effect.effect, placed_effect.place
    if place.kind == "joints":
        # what holds others as a special case describes the whole joint
        if effect.includes:
            return (0 if place.joints[0] > 1 else 5), 0.0
        return 3, 0.0
    if is_target:
        return 1, 0.0
    along = float(first_axis["xyz".index(symbol[-1])])
    return (4 if along > 0.5 and along == first_axis.max() else 2), along
