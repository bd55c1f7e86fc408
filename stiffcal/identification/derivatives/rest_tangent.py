"""How the targets move with a small displacement of one node, the chain finding its balance anew.

At rest the nodes' displacements s answer the wrenches that the nodes carry on the shape that s makes: s = f(W(s)). A
further displacement of one node turns and shifts all that lies outboard of it, which changes what every node carries,
and the laws answer to that again: ds = δ + f'(W) W'(s) ds. The targets move by their levers L times ds. The sum is
taken from the targets inward (the adjoint): M = L + M f' W', which gains two digits a sweep as the balance itself does,
and costs the same whatever the number of parameters. For joint springs alone M is J (1 − K_θ⁻¹ K_C)⁻¹ (Alici and
Shirinzadeh 2005, eq. 13; physics, section 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.identification.derivatives.law_slopes import WRENCH_STEP, Component, Slope, law_slopes
from stiffcal.identification.derivatives.products import along, crossed
from stiffcal.identification.readings.row_layout import RodRows
from stiffcal.mechanics.kinematics import from_frame
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.deformed_chain import OutboardLoads, outboard_loads, unit_wrenches
from stiffcal.model.balance.equilibrium import last_node_inboard
from stiffcal.model.balance.no_balance import no_balance
from stiffcal.model.balance.rest import Rest, add_side_torques, law_terms, reported_turn
from stiffcal.model.effect import NodeLoads, joint_nodes

Singles = NDArray[np.float32]
Sums = tuple[Singles | None, Singles | None]
"""(3, k, n) to a force and to a moment in base axes; None where no law answers it."""
# rad or m; a balancing spring bends over tens of degrees.
TURN_STEP = 1e-5
# Relative, of what another sweep would still change. Columns that are wrong by a per cent move estimates by a tenth of
# a standard uncertainty where a model leaves ten times the noise: 1e-4 moves them by a thousandth.
TOLERANCE = 1e-4
MAX_SWEEPS = 60


@dataclass(frozen=True)
class Answers:
    """What the targets' motions answer to the nodes' wrenches, and sums of it; k motions, n states.

    Sums are kept in single precision: they make a hundredth of a motion, and are wanted to a hundredth.
    """

    own: dict[Component, Floats]
    """(k, n) by component of a node's wrench, its own axes; those that no law answers are left out."""
    before: dict[int, Sums]
    """Of the nodes inboard of a node, to a force and its moment about the base."""
    through: dict[int, Sums]
    """The same with the node itself."""
    weight: dict[int, Singles]
    """(3, k, n) by node, of those outboard of it: to a turn of gravity's direction, times it."""
    reading: dict[int, Sums]
    """By node, of those outboard of it: to the reading's force and moment, where their axes stand still."""


@dataclass(frozen=True)
class _Loads:
    """`OutboardLoads` in single precision."""

    force: Singles
    moment: Singles
    point: Singles
    last_moving: int
    last_turning: int
    gravity: Singles
    mass: Singles
    first_moment: list[Singles]


class RestTangent:
    """Derivatives of the targets' motions by displacements of the chain's nodes, at one rest of n states.

    The k motions are, target by target, the components of its displacement, base axes, and then what the rods read.

    Parameters
    ----------
    robot : chain and effects with values.
    rest : where the chain rests.
    loads : what its nodes carry there, for the laws.
    components : of each target's displacement that are wanted: 3, the translation, or 6.
    rods : of links with rods. held : (n,) True where the shape is kept: a robot that is clamped finds no other one.
    """

    def __init__(
        self,
        robot: CompliantRobot,
        rest: Rest,
        loads: NodeLoads,
        components: int,
        rods: Sequence[RodRows] = (),
        held: Booleans | None = None,
    ) -> None:
        self._robot, self._rest, self._loads, self._held = robot, rest, loads, held
        self._components, self._rods = components, rods
        self._n_joints = len(rest.shape.bodies) - 2
        self._levers: dict[Component, Floats] = {}
        self._motions: dict[Component, Floats] = {}
        self._twists: dict[tuple[Component, bool], tuple[Floats, Floats | None]] = {}

    def lever(self, node: int, component: int) -> Floats:
        """Return (k, n): how the targets move with one component of a node's displacement, the shape otherwise kept."""
        return self._lever((node, component))

    def motions(self, node: int, component: int, geometry: bool = False) -> Floats:
        """Return (k, n): how the targets move with one component of a node's displacement, m and rad per m and rad.

        With ``geometry`` it is the undeformed chain that moves there, the node's own axes included.
        """
        if not self._robot.deformed:
            return self._lever((node, component), geometry)
        if geometry:
            return self._lever((node, component), True) + self._further(self._answers, (node, component), True)
        answers, at = self._answers, (node, component)
        if at not in self._motions:
            self._motions[at] = self._lever(at) + self._further(answers, at)
        return self._motions[at]

    def by_wrenches(self, change: Floats) -> Floats:
        """Return (k, n): how the targets move with changes (2J + 2, 6, n) of what the nodes carry, their own axes."""
        result = np.zeros((self.n_motions, change.shape[-1]))
        for (node, component), answer in self._answers.own.items():
            result += answer * change[node, component]
        return result

    def by_reading(self) -> Floats:
        """Return (k, 6, n): how the targets move with the wrench as read, m and rad per N and N·m.

        Each axis is changed by the size of a sensor's noise at once, so that laws with a corner are averaged as the
        noise averages them.
        """
        inputs = self._rest.inputs
        result = np.zeros((self.n_motions, 6, inputs.angles.shape[1]))
        direct, levered = unit_wrenches(self._robot.adjusted_chain, self._rest.shape, inputs)
        base = law_terms(self._robot, self._loads)
        wrench, part = np.empty_like(self._loads.wrench), np.empty_like(result[:, 0])
        for axis, step in enumerate(WRENCH_STEP if inputs.setup.moments_measured else WRENCH_STEP[:3]):
            if axis < 3:
                np.multiply(step, direct[:, :, axis], out=wrench[:, :3])
                np.multiply(step, levered[:, :, axis], out=wrench[:, 3:])
            else:
                wrench[:, :3] = 0.0
                np.multiply(step, direct[:, :, axis - 3], out=wrench[:, 3:])
            wrench += self._loads.wrench
            changed = law_terms(self._robot, replace(self._loads, wrench=wrench))
            by_axis = np.zeros_like(part)
            for (placed, before), (_, after) in zip(base, changed, strict=True):
                amplitude = placed.amplitude(before.symbol)
                if amplitude != 0.0 and np.any(difference := after.value - before.value):
                    np.multiply(self.motions(before.node, before.component), difference * (amplitude / step), out=part)
                    by_axis += part
            result[:, axis] = by_axis
        return result

    @property
    def n_states(self) -> int:
        """Number of states."""
        return int(self._rest.inputs.angles.shape[1])

    @property
    def n_motions(self) -> int:
        """Number of motions."""
        n_targets = len(self._rest.inputs.setup.targets)
        return self._components * n_targets + sum(len(rods.row) for rods in self._rods)

    @cached_property
    def _outboard(self) -> OutboardLoads:
        return outboard_loads(self._robot.adjusted_chain, self._rest.shape, self._rest.inputs)

    @cached_property
    def _outboard_single(self) -> _Loads:
        load = self._outboard
        return _Loads(
            single(load.force),
            single(load.moment),
            single(load.point),
            load.last_moving,
            load.last_turning,
            single(load.gravity),
            single(load.mass),
            [single(first) for first in load.first_moment],
        )

    @cached_property
    def _side(self) -> dict[Component, Floats]:
        """How torques in parallel with drives change with what the joints turn, N·m/rad."""
        chain = self._robot.adjusted_chain
        nodes, components = joint_nodes(chain), chain.drive_components
        angles = self._rest.inputs.angles + self._rest.displacement[nodes, components]
        before, after = np.zeros_like(self._rest.wrench), np.zeros_like(self._rest.wrench)
        add_side_torques(self._robot, angles - TURN_STEP, before)
        add_side_torques(self._robot, angles + TURN_STEP, after)
        slope = (after - before) / (2.0 * TURN_STEP)
        return {
            (int(node), int(component)): slope[node, component]
            for node, component in zip(nodes, components, strict=True)
            if slope[node, component].any()
        }

    @cached_property
    def _answers(self) -> Answers:
        """What the targets' motions answer to the nodes' wrenches, with all that follows from it.

        Raises
        ------
        NoBalanceError : the sweeps do not settle; so they do where the balance itself is about to give way.
        """
        slopes = law_slopes(self._robot, self._loads)
        answering = list(dict.fromkeys(slope.answers for slope in slopes))
        motions = {at: self._lever(at) for at in answering}
        answers = self._summed(slopes, motions)
        largest = max((float(np.max(np.abs(lever), initial=0.0)) for lever in motions.values()), default=0.0)
        last = largest
        for _ in range(MAX_SWEEPS if self._robot.deformed and answering else 0):
            updated = {at: self._lever(at) + self._further(answers, at) for at in answering}
            change = max(
                (float(np.max(np.abs(updated[at] - motions[at]), initial=0.0)) for at in answering), default=0.0
            )
            before, motions = motions, updated
            # sweeps contract evenly; what is no number ends them too, and is reported with the columns
            if not change * min(last, change) > TOLERANCE * largest * last:
                break
            answers, last = self._summed(slopes, motions), change
        else:
            if self._robot.deformed and answering:
                moved = np.max([np.abs(motions[at] - before[at]).max(axis=0) for at in answering], axis=0)
                raise no_balance(self._robot, self._rest.inputs, self._rest.displacement, moved)
        self._motions |= motions
        return replace(answers, own=_by_carried(slopes, motions))

    def _lever(self, at: Component, geometry: bool = False) -> Floats:
        """Return (k, n): what the displacement moves at once, the shape otherwise kept."""
        if at in self._levers and not geometry:
            return self._levers[at]
        node, component = at
        move, turn = self._twist(at, geometry)
        bodies, inputs, origin = self._rest.shape.bodies, self._rest.inputs, self._origin(node, geometry)
        setup, error = inputs.setup, inputs.tracker_error
        result = np.zeros((self.n_motions, origin.shape[1]))
        for b, target in enumerate(setup.targets):
            if node > last_node_inboard(target.body, self._n_joints):
                continue
            place = bodies[target.body].point(target.transform[:3, 3])
            parts = [move if turn is None else crossed(turn, place - origin)]
            if self._components == 6 and turn is not None:
                parts.append(turn)
            for number, part in enumerate(parts):
                first = self._components * b + 3 * number
                reported = part if error is None else reported_turn(error[:, :3, :3], inputs.tracker, part)
                result[first : first + 3] = reported
        if geometry:
            return result
        first = self._components * len(setup.targets)
        for rods in self._rods:
            if rods.node == node:
                result[first : first + len(rods.row)] = rods.matrix[:, component, None]
            first += len(rods.row)
        self._levers[at] = result
        return result

    def _origin(self, node: int, geometry: bool) -> Floats:
        """Return (3, n) where the node turns about: the geometry does so before the node's own shift."""
        shape = self._rest.shape
        return shape.nodes[node].position if geometry else shape.origins[node]

    def _twist(self, at: Component, geometry: bool) -> tuple[Floats, Floats | None]:
        """Return a unit of the component in base axes: (3, n) a shift and None, or nothing and (3, n) a turn."""
        if (at, geometry) not in self._twists:
            self._twists[at, geometry] = self._new_twist(at, geometry)
        return self._twists[at, geometry]

    def _new_twist(self, at: Component, geometry: bool) -> tuple[Floats, Floats | None]:
        node, component = at
        axes = self._rest.shape.nodes[node].rotation
        if component < 3:
            return axes[:, component], None
        axis, small = axes[:, component - 3], self._rest.displacement[node, 3:]
        others = [c for c in range(3) if c != component - 3]
        if geometry or not self._robot.deformed or not small[others].any():
            return axis, axis
        # the node turns by a rotation vector: by its left Jacobian, whose next term is the cube of a milliradian
        unit = np.zeros_like(small)
        unit[component - 3] = 1.0
        half = crossed(small, unit)
        turn = from_frame(axes, unit + 0.5 * half + crossed(small, half) / 6.0)
        return turn, turn

    def _summed(self, slopes: Sequence[Slope], motions: dict[Component, Floats]) -> Answers:
        """Return what motions (k, n) of the answering displacements answer to the nodes' wrenches."""
        own = _by_carried(slopes, motions)
        if not self._robot.deformed:
            return Answers(own, {}, {}, {}, {})
        shape, load = self._rest.shape, self._outboard
        in_base: dict[int, Sums] = {}
        for (node, component), answer in own.items():
            axis = single(shape.nodes[node].rotation[:, component % 3, None]) * single(answer)
            force, moment = in_base.get(node, (None, None))
            in_base[node] = (_plus(force, axis), moment) if component < 3 else (force, _plus(moment, axis))
        nodes = range(2 * self._n_joints + 2)
        before: dict[int, Sums] = {}
        through: dict[int, Sums] = {}
        sums: Sums = None, None
        for node in nodes:
            before[node] = sums
            if node in in_base:
                force, moment = in_base[node]
                about = None if moment is None else crossed(single(shape.origins[node])[:, None], moment)
                sums = _plus(_plus(sums[0], force), about), _plus(sums[1], moment)
            through[node] = sums
        weight: dict[int, Singles] = {}
        reading: dict[int, Sums] = {}
        heavy: Singles | None = None
        still: Sums = None, None
        for node in reversed(nodes):
            if heavy is not None:
                weight[node] = heavy
            if still[0] is not None and node > load.last_turning:
                reading[node] = still
            if node not in in_base:
                continue
            force, moment = in_base[node]
            if load.mass[node]:
                heavy = _plus(heavy, None if force is None else np.float32(load.mass[node]) * force)
                first = single(load.first_moment[node])[:, None]
                heavy = _plus(heavy, None if moment is None else crossed(moment, first))
            if load.last_turning < node <= load.last_loaded:
                arm = single(load.point - shape.origins[node])[:, None]
                pull = None if moment is None else crossed(moment, arm)
                still = _plus(_plus(still[0], pull), force), _plus(still[1], moment)
        return Answers(own, before, through, weight, reading)

    def _further(self, answers: Answers, at: Component, geometry: bool = False) -> Floats:
        """Return (k, n): how the targets move by what the laws answer when a displacement changes the wrenches.

        What the nodes inboard carry changes as if a force and a moment about the base were added, those of weights and
        of the reading, which move with the chain outboard; where the axes of a node turn, what does not turn with them
        changes in them.
        """
        node, load = at[0], self._outboard_single
        motion, axis = self._twist(at, geometry)
        move, turn = single(motion), None if axis is None else single(axis)
        gravity = load.gravity[:, None]
        changes: list[tuple[Singles | None, Singles]] = []
        carried, turns = node <= load.last_moving, node <= load.last_turning
        if turn is None:
            weight = load.mass[node] * gravity
            changes.append((answers.before[node][1], crossed(move, weight + load.force if carried else weight)))
        else:
            origin, outside = single(self._origin(node, geometry)), node - 1 if geometry else node
            to_force, to_moment = (answers.before if geometry else answers.through)[node]
            arm = load.first_moment[node]
            if geometry:
                arm = arm + load.mass[node] * (single(self._rest.shape.origins[node]) - origin)
            moment = crossed(crossed(turn, arm), gravity)
            turned_force, turned_moment = crossed(turn, load.force), crossed(turn, load.moment)
            if carried:
                moment += crossed(crossed(turn, load.point - origin), load.force)
            if turns:
                moment += turned_moment + crossed(load.point, turned_force)
                changes.append((to_force, turned_force))
            elif outside in answers.reading:
                changes += zip(answers.reading[outside], (-turned_force, -turned_moment), strict=True)
            changes += [(to_moment, moment), (answers.weight.get(outside), -crossed(turn, gravity))]
        result = np.zeros((self.n_motions, move.shape[1]))
        for answer, change in changes:
            if answer is not None:
                result += along(answer, change[:, None])
        if at in self._side and at in answers.own:
            result += answers.own[at] * self._side[at]
        if self._held is not None:
            result[:, self._held] = 0.0
        return result


def _by_carried(slopes: Sequence[Slope], motions: dict[Component, Floats]) -> dict[Component, Floats]:
    """Return (k, n) by component of a node's wrench: what motions (k, n) of the displacements answer to it."""
    own: dict[Component, Floats] = {}
    for slope in slopes:
        part = motions[slope.answers] * slope.value
        own[slope.carries] = own[slope.carries] + part if slope.carries in own else part
    return own


def single(values: Floats) -> Singles:
    """Return the values in single precision."""
    return values.astype(np.float32)


def _plus(sum_so_far: Singles | None, part: Singles | None) -> Singles | None:
    if part is None:
        return sum_so_far
    return part if sum_so_far is None else sum_so_far + part
