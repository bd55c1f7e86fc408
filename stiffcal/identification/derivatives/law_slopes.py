"""How the nodes' displacements answer the wrenches that the nodes carry, by differences of the laws."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.rest import law_terms
from stiffcal.model.effect import NodeLoads, joint_node

Component = tuple[int, int]
"""A node, and one of the six components of its displacement or its wrench."""
# A wrench step of the size of a sensor's noise, so that laws with a corner are averaged as the noise averages them.
WRENCH_STEP = (1.0, 1.0, 1.0, 0.2, 0.2, 0.2)


@dataclass(frozen=True)
class Slope:
    """How one component of a node's displacement answers one component of a node's wrench at rest."""

    answers: Component
    """Of the displacement."""
    carries: Component
    """Of the wrench."""
    value: Floats
    """(n,) m or rad per N or N·m."""


def law_slopes(robot: CompliantRobot, loads: NodeLoads) -> list[Slope]:
    """Return how the nodes' displacements answer their wrenches under these loads, by differences of the laws.

    A law answers the wrench of its own node, one of a coupled drive the torques of the joints that the drive turns, and
    one between joints those of both; so one component is changed at all nodes at once, and at such joints one by one.
    """
    chain = robot.chain
    apart = chain.drive_axes != np.eye(chain.n_joints)
    coupled = np.flatnonzero(apart.any(axis=0) | apart.any(axis=1))
    drives = {joint_node(int(k) + 1): int(chain.drive_components[k]) for k in coupled}
    between = {
        joint_node(joint) for placed in robot.acting if len(placed.place.joints) > 1 for joint in placed.place.joints
    }
    everywhere = list(range(len(loads.wrench)))
    base = law_terms(robot, loads)
    found: dict[tuple[Component, Component], Floats] = {}
    wrench = loads.wrench.copy()
    for component, step in enumerate(WRENCH_STEP):
        alone = [node for node in everywhere if node in between or drives.get(node) == component]
        for nodes in ([node for node in everywhere if node not in alone], *([node] for node in alone)):
            wrench[nodes, component] += step
            changed = law_terms(robot, replace(loads, wrench=wrench))
            for (placed, before), (_, after) in zip(base, changed, strict=True):
                amplitude = placed.amplitude(before.symbol)
                if amplitude == 0.0 or not np.any(difference := after.value - before.value):
                    continue
                carries = (nodes[0] if len(nodes) == 1 else before.node, component)
                key = (before.node, before.component), carries
                slope = (amplitude / step) * difference
                found[key] = found[key] + slope if key in found else slope
            wrench[nodes, component] = loads.wrench[nodes, component]
    return [Slope(answers, carries, value) for (answers, carries), value in found.items()]
