"""What laws that are not proportional to their load add in a controller's loop, and what they remember."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.linear_nodes import LinearNodes
from stiffcal.model.scalar_laws import LawForm


class ScalarResponses:
    """Laws and balancing springs of a row of nodes, for the loaded shape (0) and the one under weight alone (1).

    Parameters
    ----------
    nodes : with the laws.
    n_nodes : of the row. n_joints : J.

    Attributes
    ----------
    present : whether there is anything to do.
    """

    def __init__(self, nodes: LinearNodes, n_nodes: int) -> None:
        self._laws, self._springs, self._deformed = nodes.laws, nodes.springs, nodes.deformed
        self.present = bool(self._laws or self._springs)
        index = {node: row for row, node in enumerate(nodes.nodes)}
        self._weights = np.zeros((len(self._laws), n_nodes, 6))
        for weight, law in zip(self._weights, self._laws, strict=True):
            for node, component, factor in law.weights:
                weight[index[node], component] = factor
        self._flat = self._weights.reshape(len(self._laws), 6 * n_nodes)
        self._spring_nodes = [index[2 * spring.joint - 1] for spring in self._springs]
        self._memory: list[Floats | None] = [None] * len(self._laws)
        self._next = list(self._memory)
        self._angles = np.zeros(0)

    def stand(self, angles: Floats) -> None:
        """Take the model angles (J,), rad, of this call."""
        self._angles = angles

    def load(self, carried: Floats, small: Floats) -> None:
        """Add the balancing springs' torques to what the nodes carry.

        Parameters
        ----------
        carried : (2, 6 N) node axes; changed. small : (2, N, 7) displacements of the sweep before.
        """
        for spring, node in zip(self._springs, self._spring_nodes, strict=True):
            turned = self._angles[spring.joint - 1] + (small[:, node, 5] if self._deformed else np.zeros(2))
            carried[:, 6 * node + 5] += spring.torque(turned)

    def respond(self, carried: Floats, small: Floats) -> None:
        """Add the laws' displacements; what they would remember is kept for `remember`.

        Parameters
        ----------
        carried : (2, 6 N) node axes. small : (2, N, 7) displacements; changed.
        """
        for number, (law, weight) in enumerate(zip(self._laws, self._flat, strict=True)):
            load = carried @ weight
            angle = self._angles[law.joint - 1 : law.joint] if law.joint else load
            moved = law.respond(load, angle)
            if law.form is LawForm.PLAY:
                # Before the first call weight alone has acted, in one monotonic move (physics, section 2).
                memory = self._memory[number]
                before = law.remembered(load[1:], None) if memory is None else memory
                self._next[number] = law.remembered(load[:1], before)
                moved[:1] = law.respond(load[:1], angle, before)
            small[:, :, :6] += moved[:, None, None] * self._weights[number]

    def remember(self) -> None:
        """Keep what the last sweep's loads left: once in each call."""
        self._memory[:] = self._next

    def forget(self) -> None:
        """Begin anew: weight alone has acted."""
        self._memory = [None] * len(self._laws)
