"""A robot without equilibrium is refused with the number that is likely wrong, and where it stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.fault_codes import FaultCode
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.no_balance import NoBalanceError
from stiffcal.model.balance.rest import find_rest
from stiffcal.model.effect import Inputs, Place
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes


@pytest.mark.parametrize(
    ("mass", "force", "soft", "file", "place"),
    [
        (9e7, 0.0, 1.0, "robot.toml", "joints (A2).link.mass_kg"),
        (90.0, 5e7, 1.0, "campaign.toml", "wrench"),
        (90.0, 100.0, 1e-5, "model.toml", "parameters.joint-compliance.j2.c"),
    ],
)
def test_it_names_the_mass_the_load_or_the_spring(
    mass: float, force: float, soft: float, file: str, place: str
) -> None:
    chain = six_axes()
    masses = np.where(np.arange(6) == 1, mass, chain.link_mass)
    springs = tuple(
        PlacedEffect(JointCompliance(), Place("joints", (k + 1,)), {"c": 1.0 / (stiffness * (soft if k == 1 else 1.0))})
        for k, stiffness in enumerate(SIX_STIFFNESS.tolist())
    )
    robot = CompliantRobot(replace(chain, link_mass=masses), springs)
    wrench = np.zeros((6, 1))
    wrench[2] = -force
    inputs = Inputs(np.radians([[0.0], [-75.0], [15.0], [0.0], [30.0], [0.0]]), wrench, force_sensor_setup(chain))
    with pytest.raises(NoBalanceError) as raised:
        find_rest(robot, inputs)
    (fault,) = raised.value.faults
    assert (fault.code, fault.file, fault.place) == (FaultCode.NO_BALANCE, file, place)
    assert fault.mend
