"""Parameters of joints that were not driven while the flange was clamped."""

from __future__ import annotations

import numpy as np

from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.model.assembled.composite import CompliantRobot


def undriven_parameters(robot: CompliantRobot, data: Observations) -> frozenset[str]:
    """Return the full names of what acts at joints whose motors were not read, where nothing else was measured.

    With the flange held, what such a joint gives is taken up by its own motor, which stands still in the readings; the
    driven ones turn with it only by what bends the chain.

    Parameters
    ----------
    robot : chain and effects. Where drives turn several axes, nothing is returned.
    data : the observations.
    """
    chain = robot.chain
    if data.clamped is None or not bool(np.all(data.kind == MOTOR)):
        return frozenset()
    if not np.array_equal(chain.drive_axes, np.eye(chain.n_joints)):
        return frozenset()
    driven = {int(number) + 1 for number in data.component[np.any(data.measured_mask, axis=1)]}
    return frozenset(
        placed.parameter_name(spec.symbol)
        for placed in robot.placed
        if placed.place.joints and not driven & set(placed.place.joints)
        for spec in placed.effect.parameters
    )
