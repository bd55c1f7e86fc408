"""A model as numbers: the compliance matrix of all nodes, the laws that are in no matrix, and the chain between nodes.

Every law is evaluated at unit wrenches, and then at other angles, twice the load and the opposite load. What is not
proportional (play, hysteresis, a curve, a law that follows the joint's angle) is no constant matrix: a controller's
loop takes it as a law of one load (`stiffcal.model.scalar_laws`), and the batch form not at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import inverse_transform
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.rest import law_terms, node_displacements
from stiffcal.model.balance.stated_spring import parallel_spring, stated_spring
from stiffcal.model.effect import Inputs, Instrument, NodeLoads, joint_node, link_node, tool_node
from stiffcal.model.scalar_laws import BalancingSpring, ScalarLaw

# A law counts as linear where it keeps to its compliance within this share, over these loads.
_LINEAR = 1e-9
_TRIED_FORCE, _TRIED_MOMENT, _TRIALS = 1000.0, 1000.0, 8
STATED_SPRING = "gravity_compensator"
"""Name of the spring that robot.toml states and no effect of the model holds."""


@dataclass(frozen=True)
class LinearNodes:
    """The linear part of a model."""

    nodes: tuple[int, ...]
    """Numbers of the nodes that give, base to tool."""
    compliance: Floats
    """(6 N, 6 N) displacement of these nodes per wrench on them, node axes; m, rad, N, N·m."""
    setup: MeasurementSetup
    """The set-up as the model's own effects correct it."""
    deformed: bool
    """False for the papers' first-order form."""
    left_out: tuple[str, ...]
    """Names of the effects that are in no matrix and no law."""
    laws: tuple[ScalarLaw, ...] = ()
    """Laws that are not proportional to their load, where they were asked for."""
    springs: tuple[BalancingSpring, ...] = ()
    """Springs that put a torque on a drive, where they were asked for."""


@dataclass(frozen=True)
class NodeChain:
    """The chain as a row of nodes, each placed in the displaced frame of the one before."""

    nodes: tuple[int, ...]
    """N node numbers."""
    fixed: Floats
    """(N, 4, 4) from the displaced frame before to the node's own, its joint at zero."""
    joint: NDArray[np.int64]
    """(N,) number of the joint that moves before the node, from 0; −1 for none."""
    mass: Floats
    """(N,) kg that ride on the displaced node."""
    mass_moment: Floats
    """(N, 3) the sum of mass times place there, kg·m."""
    gravity: Floats
    """(3,) m/s²."""
    prismatic: Booleans
    """(J,) True where a joint moves along its axis."""
    bodies: tuple[tuple[int, Floats], ...]
    """(node index, (4, 4) node_from_body) for each body, base to flange; index −1: the ground."""

    def placed(self, attachment: Attachment) -> tuple[int, Floats]:
        """Return the node index that a frame rides on, and its (4, 4) place there."""
        index, node_from_body = self.bodies[attachment.body]
        return index, np.ascontiguousarray(node_from_body @ attachment.transform)


def linear_nodes(
    robot: CompliantRobot, setup: MeasurementSetup, leave_out: Sequence[str] = (), with_laws: bool = False
) -> LinearNodes:
    """Return the linear part of a robot with values.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    setup : where the instruments sit.
    leave_out : names of effects that are left out where they are not linear, `STATED_SPRING` among them.
    with_laws : also return laws and springs that effects describe as data (`Effect.scalar_laws`).

    Raises
    ------
    ValueError : an effect is not linear, is described by no law, and ``leave_out`` does not name it.
    """
    size = 6 * (tool_node(robot.chain) + 1)
    total, left_out = np.zeros((size, size)), []
    laws: list[ScalarLaw] = []
    springs: list[BalancingSpring] = []
    stated = stated_spring(robot)
    if stated is not None and with_laws:
        springs.append(stated)
    elif stated is not None:
        left_out.append(STATED_SPRING)
        if STATED_SPRING not in leave_out:
            raise ValueError(
                f"{STATED_SPRING} of robot.toml is not proportional to its load, so a controller cannot compute it in "
                "real time; omit it by name (--leave-out), or use compensate"
            )
    for placed_effect in robot.placed:
        if isinstance(placed_effect.effect, Instrument):
            continue  # a change of the readings alone: the robot does not bend by it
        matrix = matrix_of(robot, placed_effect)
        acts_next_to = acts_next_to_drive(robot, placed_effect)
        if with_laws and placed_effect.effect.name not in leave_out:
            spring = parallel_spring(robot.chain, placed_effect)
            if spring is not None:
                springs.append(spring)
                acts_next_to = False
            if matrix is None:
                of_effect = _laws_of(robot, placed_effect)
                laws += of_effect
                matrix = np.zeros((size, size)) if of_effect else None
        if matrix is None or acts_next_to:
            left_out.append(f"{placed_effect.effect.name}.{placed_effect.place.label}")
            if placed_effect.effect.name not in leave_out:
                raise ValueError(
                    f"{placed_effect.effect.name} at {placed_effect.place.label} is not proportional to its load, so "
                    "a controller cannot compute it in real time; omit it by name (--leave-out), or use compensate"
                )
            continue
        total += matrix
    gives = np.flatnonzero(np.abs(total).reshape(size // 6, 6, size).max(axis=(1, 2)) > 0.0)
    of_laws = {node for law in laws for node, _, _ in law.weights}
    nodes = sorted({*gives.tolist(), *of_laws, *(joint_node(k) for k in range(1, robot.chain.n_joints + 1))})
    picked = np.concatenate([6 * node + np.arange(6) for node in nodes])
    return LinearNodes(
        nodes=tuple(int(node) for node in nodes),
        compliance=np.ascontiguousarray(total[np.ix_(picked, picked)]),
        setup=_corrected_setup(robot, setup),
        deformed=robot.deformed,
        left_out=tuple(left_out),
        laws=tuple(laws),
        springs=tuple(springs),
    )


def node_chain(chain: Chain, nodes: LinearNodes) -> NodeChain:
    """Return the chain between the nodes that give."""
    fixed, joint, bodies = [], [], []
    carried = np.eye(4)  # from the last displaced node to the frame that is being carried outward
    last = -1
    if 0 in nodes.nodes:
        fixed.append(np.eye(4))
        joint.append(-1)
        last = 0
    bodies.append((last, np.eye(4)))
    ends = {beam.joint: beam.end for beam in chain.beams.values()}
    for k in range(1, chain.n_joints + 1):
        lift = np.eye(4)
        lift[2, 3] = chain.bearing[k - 1]
        fixed.append(carried @ chain.fixed[k - 1] @ lift)
        joint.append(k - 1)
        last += 1
        carried = inverse_transform(lift)
        bodies.append((last, carried))
        if link_node(k) in nodes.nodes:
            fixed.append(carried @ ends[k])
            joint.append(-1)
            last += 1
            carried = inverse_transform(ends[k])
    carried = carried @ chain.flange
    if tool_node(chain) in nodes.nodes:
        fixed.append(carried)
        joint.append(-1)
        last += 1
        carried = np.eye(4)
    bodies.append((last, carried))
    # as in the balance, a link's own weight acts inboard of the end at which it bends
    mass, moment = _masses(chain, nodes.setup, bodies[1:], len(fixed))
    return NodeChain(
        nodes=nodes.nodes,
        fixed=np.stack(fixed),
        joint=np.array(joint, dtype=np.int64),
        mass=mass,
        mass_moment=moment,
        gravity=chain.gravity,
        prismatic=chain.prismatic,
        bodies=tuple(bodies),
    )


def _masses(
    chain: Chain, setup: MeasurementSetup, carriers: Sequence[tuple[int, Floats]], count: int
) -> tuple[Floats, Floats]:
    mass, moment = np.zeros(count), np.zeros((count, 3))
    loads = [(float(chain.link_mass[k]), chain.link_com[k]) for k in range(chain.n_joints)]
    loads.append((setup.tool_mass, setup.tool_com))
    for (kilograms, centre), (index, node_from_body) in zip(loads, carriers, strict=True):
        mass[index] += kilograms
        moment[index] += kilograms * (node_from_body @ np.append(centre, 1.0))[:3]
    return mass, moment


def matrix_of(robot: CompliantRobot, placed_effect: PlacedEffect) -> Floats | None:
    """Return (6 N, 6 N) of all nodes for one effect, or None where it is not linear."""
    alone = CompliantRobot(robot.chain, (placed_effect,), robot.deformed)
    count = tool_node(robot.chain) + 1
    rng = np.random.default_rng(0)
    unit = np.eye(6 * count).reshape(count, 6, 6 * count)
    matrix = _answers(alone, unit, np.zeros((robot.chain.n_joints, 6 * count))).reshape(6 * count, 6 * count)
    size = np.where(np.arange(6) < 3, _TRIED_FORCE, _TRIED_MOMENT)[:, None]
    tried = rng.standard_normal((count, 6, _TRIALS)) * size
    tried[:, :, _TRIALS // 2 :] = -2.0 * tried[:, :, : _TRIALS // 2]
    angles = rng.uniform(-np.pi, np.pi, (robot.chain.n_joints, _TRIALS))
    answered = _answers(alone, tried, angles).reshape(6 * count, _TRIALS)
    expected = matrix @ tried.reshape(6 * count, _TRIALS)
    if np.abs(answered - expected).max() > _LINEAR * np.abs(expected).max(initial=1e-30):
        return None
    return matrix


def _answers(robot: CompliantRobot, wrench: Floats, angles: Floats) -> Floats:
    return node_displacements(robot, law_terms(robot, NodeLoads(wrench, angles)), wrench.shape[2])


def _laws_of(robot: CompliantRobot, placed_effect: PlacedEffect) -> Sequence[ScalarLaw]:
    """Return an effect's laws as data; none where it gives none, or where they answer otherwise than its terms."""
    laws = placed_effect.scalar_laws(robot.chain)
    alone = CompliantRobot(robot.chain, (placed_effect,), robot.deformed)
    rng = np.random.default_rng(0)
    size = np.where(np.arange(6) < 3, _TRIED_FORCE, _TRIED_MOMENT)[:, None]
    tried = rng.standard_normal((tool_node(robot.chain) + 1, 6, _TRIALS)) * size
    angles = rng.uniform(-np.pi, np.pi, (robot.chain.n_joints, _TRIALS))
    by_terms, by_laws = _answers(alone, tried, angles), np.zeros_like(tried)
    for law in laws:
        load = sum((factor * tried[node, component] for node, component, factor in law.weights), np.zeros(_TRIALS))
        moved = law.respond(load, angles[law.joint - 1] if law.joint else load)
        for node, component, factor in law.weights:
            by_laws[node, component] += factor * moved
    agree = np.abs(by_terms - by_laws).max() <= _LINEAR * np.abs(by_terms).max(initial=1e-30)
    return laws if agree else ()


def acts_next_to_drive(robot: CompliantRobot, placed_effect: PlacedEffect) -> bool:
    """Return whether an effect puts a torque in parallel with its drive (a balancing spring)."""
    return parallel_spring(robot.chain, placed_effect) is not None


def _corrected_setup(robot: CompliantRobot, setup: MeasurementSetup) -> MeasurementSetup:
    """Return the set-up as effects that turn or shift frames leave it."""
    inputs = Inputs(np.zeros((robot.chain.n_joints, 1)), np.zeros((6, 1)), setup)
    for placed_effect in robot.placed:
        inputs = placed_effect.adjusted(inputs)
    return inputs.setup
