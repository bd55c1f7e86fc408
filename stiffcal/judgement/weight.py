"""Weight that the robot file does not state: it changes with the angles, and so does what the joints carry of it.

Of displacements under load weight is second order: as the robot gives, its own weight turns and shifts, and the loads
act on a robot that sags. Ten thousand readings show it all the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.geometry_nuisance import LEAST_SHOWN
from stiffcal.identification.derivatives.observation import Observations, predicted, rests
from stiffcal.identification.noise.projection import Projection
from stiffcal.judgement.numbers import LEAST_MASS, STEP_MASS, STEP_MOMENT
from stiffcal.judgement.priors import RobotScale
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.no_balance import NoBalanceError


@dataclass(frozen=True)
class WeightOfLinks:
    """How the readings change with what the links weigh."""

    chain: Chain
    """The robot's."""
    of_links: Sequence[tuple[str, Floats]]
    """Each link's name, and (4, m, n) derivatives by its mass, kg, at the origin of its frame, and by its first
    moment, kg·m, along the axes of that."""

    @classmethod
    def of(cls, robot: CompliantRobot, data: Observations) -> WeightOfLinks:
        """Return it for a robot with values."""
        plain = _read(robot, robot.chain, data)
        steps = [(STEP_MASS, np.zeros(3)), *((0.0, STEP_MOMENT * axis) for axis in np.eye(3))]
        found = []
        for link, name in enumerate(robot.chain.link_names):
            lacking = LEAST_MASS - robot.chain.link_mass[link]
            try:
                start, before = robot.chain, plain
                if lacking > 0.0:
                    start = _heavier(start, link, lacking, np.zeros(3))
                    before = _read(robot, start, data)
                changes = np.array([_read(robot, _heavier(start, link, *step), data) - before for step in steps])
            except NoBalanceError:
                # of a joint whose compliance nothing shows yet: what hangs on it shows nothing either
                continue
            found.append((name, changes / np.array([STEP_MASS, *[STEP_MOMENT] * 3])[:, None, None]))
        return cls(robot.chain, found)

    def unknown(self, scale: RobotScale) -> Floats:
        """Return (4J, m, n) what one standard deviation of each mass and moment makes where none is stated."""
        mass, moment = scale.usual_weight(self.chain)
        size = np.array([mass, moment, moment, moment])[:, None, None]
        return np.asarray(np.concatenate([size * columns for _, columns in self.of_links]))


def _read(robot: CompliantRobot, chain: Chain, data: Observations) -> Floats:
    """Return (m, n) what the rows read of a robot whose links weigh as in a chain."""
    heavier = replace(robot, chain=chain)
    return predicted(heavier, data, *rests(heavier, data))


def _heavier(chain: Chain, link: int, mass: float, moment: Floats) -> Chain:
    """Return the chain with a link of more mass and another first moment."""
    masses, centres = chain.link_mass.copy(), chain.link_com.copy()
    whole = chain.link_mass[link] * chain.link_com[link] + moment
    masses[link] = chain.link_mass[link] + mass
    centres[link] = whole / masses[link]
    return replace(chain, link_mass=masses, link_com=centres)


def shown(columns: Floats, space: Projection) -> Floats:
    """Return (q, m, n) columns of unit variance: the directions of given ones, each of unit variance, that show."""
    rows = space.rows(columns)
    values, axes = np.linalg.eigh(rows @ rows.T)
    return np.asarray(np.einsum("gq,gmn->qmn", axes[:, values > LEAST_SHOWN**2], columns))
