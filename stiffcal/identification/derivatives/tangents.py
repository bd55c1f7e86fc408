"""The tangents at both rests of every state: under its load, and where its displacement is counted from."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.identification.derivatives.observation_shift import shift_slopes
from stiffcal.identification.derivatives.products import crossed
from stiffcal.identification.derivatives.rest_tangent import RestTangent
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import ROTATION
from stiffcal.mechanics.kinematics import turn_between
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import WeightOnlyRest, displacements
from stiffcal.model.balance.rest import Rest
from stiffcal.model.effect import NodeLoads, Term

K = TypeVar("K", bound=Hashable)


def loads_at_rest(loaded: Rest, data: Observations) -> NodeLoads:
    """Return what the nodes carry under the load, for the laws."""
    return NodeLoads(loaded.wrench, loaded.inputs.angles, data.order, loaded.weight)


def loads_under_weight(loaded: Rest, unloaded: WeightOnlyRest, data: Observations) -> NodeLoads:
    """Return what the nodes carry under weight alone, state by state, for the laws."""
    return NodeLoads(unloaded.wrench, loaded.inputs.angles, reference_kelvin=data.order.reference_kelvin)


@dataclass(frozen=True)
class Tangents:
    """Derivatives of the rows of n states by displacements of nodes, at the rests under load and under weight alone.

    Displacements are counted from the second, absolute places from the robot file's robot, which nothing moves.
    """

    model: CompliantRobot
    data: Observations
    loaded: Rest
    unloaded: WeightOnlyRest
    _law_rows: dict[tuple[int, int, bool], Floats | None] = field(default_factory=dict)

    def law_rows(self, node: int, component: int, under_weight: bool) -> Floats | None:
        """Return (m, n) by one component of a node's displacement under the load, or under weight alone; kept.

        None under weight where every state is an absolute place.
        """
        key = node, component, under_weight
        if key not in self._law_rows:
            if not under_weight:
                self._law_rows[key] = self._rows(self._at_load.motions(node, component))
            elif self._at_weight is None:
                self._law_rows[key] = None
            else:
                counted = self._of_poses(self._at_weight.motions(node, component))
                if self._clamped is not None:
                    counted = np.where(self._clamped, self._at_load.lever(node, component), counted)
                self._law_rows[key] = self._rows(np.zeros_like(counted), counted)
        return self._law_rows[key]

    def term_rows(self, under_load: Sequence[Term], under_weight: Sequence[Term]) -> Floats:
        """Return (m, n) by an amplitude, or a shape, of laws: displacements of nodes per unit of it.

        Parameters
        ----------
        under_load : of n states. under_weight : of the poses, as `loads_of_poses`; none where every state is a place.
        """
        moved = _moved(self._at_load, under_load)
        if self._at_weight is None or not under_weight:
            return self._rows(moved)
        counted = self._of_poses(_moved(self._at_weight, under_weight))
        if self._clamped is not None:
            kept = np.zeros_like(counted)
            for term in under_weight:
                kept += self._at_load.lever(term.node, term.component) * term.value[self.unloaded.pose]
            counted = np.where(self._clamped, kept, counted)
        return self._rows(moved, counted)

    def law_columns(
        self, under_load: Iterable[tuple[K, Term]], under_weight: Iterable[tuple[K, Term]]
    ) -> dict[K, Floats]:
        """Return (m, n) by each of several parameters of laws.

        Parameters
        ----------
        under_load, under_weight : as of `term_rows`, each term with its parameter.
        """
        of_parameter: dict[K, tuple[list[Term], list[Term]]] = {}
        for number, terms in enumerate((under_load, under_weight)):
            for parameter, term in terms:
                of_parameter.setdefault(parameter, ([], []))[number].append(term)
        return {parameter: self.term_rows(*terms) for parameter, terms in of_parameter.items()}

    def geometry_rows(self, node: int, component: int) -> Floats:
        """Return (m, n) by one component of a motion of the undeformed chain at a joint's node."""
        under_weight = None if self._at_weight is None else self._at_weight.motions(node, component, geometry=True)
        return self._sum(self._at_load.motions(node, component, geometry=True), under_weight)

    def wrench_rows(self, under_load: Floats, under_weight: Floats | None) -> Floats:
        """Return (m, n) by changes of what the nodes carry, their own axes.

        Parameters
        ----------
        under_load : (2J + 2, 6, n). under_weight : (2J + 2, 6, poses), None where `poses` is.
        """
        counted = None if self._at_weight is None or under_weight is None else self._at_weight.by_wrenches(under_weight)
        return self._sum(self._at_load.by_wrenches(under_load), counted)

    def reading_rows(self) -> Floats:
        """Return (m, 6, n) by the wrench as read, m and rad per N and N·m."""
        by_reading = self._at_load.by_reading()
        return np.stack([self._rows(by_reading[:, axis]) for axis in range(6)], axis=1)

    @property
    def poses(self) -> Rest | None:
        """The rests under weight alone, pose by pose; None where every state is an absolute place."""
        return self.unloaded.poses

    @cached_property
    def _components(self) -> int:
        layout = self.data.layout  # gauges and rods read no turn
        return 6 if layout.motors is not None or bool(np.any(layout.kind == ROTATION)) else 3

    @cached_property
    def _at_load(self) -> RestTangent:
        loads = loads_at_rest(self.loaded, self.data)
        return RestTangent(self.model, self.loaded, loads, self._components, self.data.layout.rods, self._clamped)

    @cached_property
    def _clamped(self) -> Booleans | None:
        """(n,) True where a clamped robot's motors were read; None: nowhere.

        What they had to turn is read through the Jacobian of the sagged chain, to second order in the drives' turns
        (`held_at_rest`): its derivative is of first order, as that of the others would be without the chain's motion.
        """
        held = self.data.layout.held
        return None if held is None else np.asarray(held.inverse.any(axis=(0, 1)))

    @cached_property
    def loads_of_poses(self) -> NodeLoads | None:
        """What the nodes carry under weight alone, pose by pose, for the laws; None where `poses` is."""
        poses, pose = self.unloaded.poses, self.unloaded.pose
        if poses is None or pose is None:
            return None
        first = np.unique(pose, return_index=True)[1]
        return NodeLoads(poses.wrench, poses.inputs.angles, reference_kelvin=self.data.order.reference_kelvin[first])

    @cached_property
    def _at_weight(self) -> RestTangent | None:
        poses, loads = self.unloaded.poses, self.loads_of_poses
        if poses is None or loads is None:
            return None
        return RestTangent(self.model, poses, loads, self._components, self.data.layout.rods)

    @cached_property
    def _turn(self) -> Floats | None:
        """(B, 3, n) rotation vectors of the targets' displacements, base axes, rad; None where no row reads turns."""
        if self._components == 3:
            return None
        pairs = zip(self.loaded.targets, self.unloaded.targets, strict=True)
        turns = np.stack([turn_between(after.rotation, before.rotation) for after, before in pairs])
        return turns if self._clamped is None else np.where(self._clamped, 0.0, turns)

    @cached_property
    def _observed(self) -> Floats | None:
        """How what effects of the measurement add follows the displacements, as `shift_slopes`."""
        return shift_slopes(self.model, self.data, np.stack(displacements(self.model, self.loaded, self.unloaded)))

    def _sum(self, under_load: Floats, under_weight: Floats | None) -> Floats:
        """Return (m, n) of motions (k, n) under the load and (k, poses) of where displacements are counted from."""
        return self._rows(under_load, None if under_weight is None else self._of_poses(under_weight))

    def _of_poses(self, motions: Floats) -> Floats:
        """Return (k, n) what each state's displacement is counted from of motions (k, poses); nothing of places."""
        moved = motions[:, self.unloaded.pose]
        if self.data.absolute.any():
            moved[:, self.data.absolute] = 0.0
        return moved

    def _rows(self, motions: Floats, counted: Floats | None = None) -> Floats:
        """Return (m, n) what the rows read of motions (k, n) at the end of displacements, and at their begin."""
        n_targets, n = len(self.data.setup.targets), motions.shape[1]
        count = self._components * n_targets
        change = motions if counted is None else motions - counted
        moved = change[:count].reshape(n_targets, self._components, n)
        if self._turn is None:
            full = np.concatenate([moved, np.zeros_like(moved)], axis=1)
        else:
            # of exp(ω) R Rᵀref and R (exp(ω) Rref)ᵀ the rotation vector φ moves by ω ∓ ½ φ × ω
            both = (motions if counted is None else motions + counted)[:count].reshape(moved.shape)
            full = moved.copy() if counted is None else moved
            for b, turn in enumerate(self._turn):
                full[b, 3:] -= 0.5 * crossed(turn, both[b, 3:])
        if self._observed is not None:
            full += np.einsum("bcdn,bdn->bcn", self._observed, full)
        rows = self.data.layout.of_targets(full)
        first = count
        for rods in self.data.layout.rods:
            rows[rods.row] += change[first : first + len(rods.row)]
            first += len(rods.row)
        return rows


def _moved(tangent: RestTangent, terms: Sequence[Term]) -> Floats:
    """Return (k, n) the targets' motions by displacements of nodes."""
    moved = np.zeros((tangent.n_motions, tangent.n_states))
    for term in terms:
        moved += tangent.motions(term.node, term.component) * term.value
    return moved
