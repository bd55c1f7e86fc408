"""Parameters of frames and geometry that no measured place can separate from the others, whatever the poses.

A turn of the tracker about joint 1's axis and the zero of joint 1 are the same motion; the shift along an axis can be
booked at either end of a link. One convention decides which of such a set are kept: the geometry of the joints from the
base outwards, then the targets, then the tracker across joint 1's axis; what is left over stays where the manifest and
the robot file have it. So a pose has 4 n + 6 numbers and m positions 4 n + 3 m (Everett, Driels and Mooring 1987), the
tracker included.

Found by arithmetic on the robot itself, not by a list: parallel axes, given frames and models of part of the joints
change which sets there are.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.readings import Observations
from stiffcal.mechanics.kinematics import StackedFrame, cross, stacked_bodies
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Inputs
from stiffcal.model.equilibrium import displacement_between, last_node_inboard, reported_targets

# Poses at which the motions are compared: three times the numbers that a seven-axis arm can have.
_POSES = 40
# Relative length of what is left of a motion that the others make up, with rounding; real ones leave a thousandth.
_SAME_MOTION = 1e-6
_SEED = 16


def redundant_geometry(robot: CompliantRobot, data: Observations, fixed: frozenset[str]) -> frozenset[str]:
    """Return the full names of geometry and frame parameters that others make up for in every pose.

    Parameters
    ----------
    robot : its geometry is taken as the robot file has it.
    data : which targets are measured, and whether their orientation is.
    fixed : full names that keep their values.
    """
    if not data.absolute.any():
        return frozenset()
    motions = _motions(robot, data, fixed)
    basis: list[Floats] = []
    redundant = set()
    for name, _, motion in sorted(motions, key=lambda entry: entry[1]):
        size = float(np.linalg.norm(motion))
        left = motion
        for _ in range(2):
            for vector in basis:
                left = left - vector * float(vector @ left)
        length = float(np.linalg.norm(left))
        if length <= _SAME_MOTION * size:
            redundant.add(name)
        else:
            basis.append(left / length)
    return frozenset(redundant)


def included_in(
    robot: CompliantRobot, data: Observations, fixed: frozenset[str], redundant: Collection[str]
) -> dict[str, list[str]]:
    """Return name of a parameter to those of `redundant_geometry` whose motion is its own in every pose, but for size.

    What several others make up for together is in none of them alone.

    Parameters
    ----------
    robot, data, fixed : as of `redundant_geometry`. redundant : what it returns.
    """
    motions = {
        name: motion / np.linalg.norm(motion) for name, _, motion in _motions(robot, data, fixed) if motion.any()
    }
    kept = {name: motion for name, motion in motions.items() if name not in redundant}
    included: dict[str, list[str]] = {}
    for name in (name for name in motions if name in redundant):
        for other, motion in kept.items():
            away = motions[name] - motion * float(motion @ motions[name])
            if np.linalg.norm(away) <= _SAME_MOTION:
                included.setdefault(other, []).append(name)
    return included


def _motions(
    robot: CompliantRobot, data: Observations, fixed: frozenset[str]
) -> list[tuple[str, tuple[int, float, int], Floats]]:
    """Return (full name, rank of the convention, motion of all targets over the poses) for each free parameter."""
    rng = np.random.default_rng(_SEED)
    chain = robot.chain
    angles = rng.uniform(-np.pi, np.pi, (chain.n_joints, _POSES))
    inputs = Inputs(angles, np.zeros((6, _POSES)), data.setup)
    bodies = stacked_bodies(chain, angles)
    measured = _measured_components(data)
    first_axis = np.abs(chain.fixed[0][:3, 2])
    motions = []
    for number, placed_effect in enumerate(robot.placed):
        for symbol, motion in _motions_of(placed_effect, robot, bodies, inputs).items():
            name = placed_effect.parameter_name(symbol)
            if name not in fixed:
                is_target = placed_effect.place.frame in data.setup.target_names
                rank = _rank(placed_effect, symbol, number, first_axis, is_target)
                if chain.prismatic[0] and placed_effect.place.frame and not is_target and symbol in ("x", "y", "z"):
                    rank = -1, 0.0, number
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
    targets = reported_targets(bodies, setup)
    motions: dict[str, Floats] = {}
    if placed_effect.effect.moves_frames:
        for spec in placed_effect.effect.parameters:
            step = 1e-3 * spec.typical
            moved = placed_effect.effect.adjusted(placed_effect.place, inputs, {spec.symbol: step}).setup
            frames = reported_targets(bodies, moved)
            changes = [
                displacement_between(after, before) / step for after, before in zip(frames, targets, strict=True)
            ]
            motions[spec.symbol] = np.stack(changes)
        return motions
    shape = placed_effect.shape()
    for term in placed_effect.effect.geometry_terms(placed_effect.place, chain, inputs.angles, shape):
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


def _rank(
    placed_effect: PlacedEffect, symbol: str, number: int, first_axis: Floats, is_target: bool
) -> tuple[int, float, int]:
    """Return the order in which parameters are kept: the least come first.

    Geometry of joints 2 to n, targets, the tracker across joint 1's axis, zeros of joints, the tracker along and about
    that axis, joint 1's geometry. Where joint 1 is prismatic any shift of the base is one of the joints after it: there
    the tracker's place comes first, so that their geometry stays near the robot file's.
    """
    effect, place = placed_effect.effect, placed_effect.place
    if place.kind == "joints":
        # what holds others as a special case describes the whole joint
        if effect.includes:
            return (0 if place.joints[0] > 1 else 5), 0.0, number
        return 3, 0.0, number
    if is_target:
        return 1, 0.0, number
    along = float(first_axis["xyz".index(symbol[-1])])
    return (4 if along > 0.5 and along == first_axis.max() else 2), along, number
