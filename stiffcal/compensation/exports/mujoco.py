"""The fitted robot with its springs as a model of MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal import __version__
from stiffcal.campaign.checks.prismatic_checks import refuse_prismatic
from stiffcal.campaign.loading import Campaign
from stiffcal.compensation.exports.controller import ModelVerdict
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.trust.output_kinds import EXPORT
from stiffcal.trust.outputs import write_output


@dataclass(frozen=True)
class WrittenRobot:
    """What was written."""

    holds: str
    """In words."""
    warnings: list[str]
    """What a user of the file must know."""


def check_mujoco(campaign: Campaign) -> None:
    """Raise InputError where a campaign's robot has no form in MuJoCo."""
    refuse_prismatic(campaign.chain.prismatic_names, "the MuJoCo model turns all joints", "export the URDF")


def write_mujoco(fitted: FittedRobot, verdict: ModelVerdict, output: Path, *, overwrite: bool = False) -> WrittenRobot:
    """Write a fitted robot for MuJoCo.

    Parameters
    ----------
    fitted : the robot with values. verdict : of the last diagnosis on its model. output : ``*.xml``.
    overwrite : also a file that holds something stiffcal did not write.

    Raises
    ------
    InputError : the file cannot be written.
    """
    from stiffcal.compensation.exports.mujoco_model import mujoco_model

    name = fitted.campaign.chain.name or fitted.campaign.name
    model = mujoco_model(fitted.robot, fitted.setup, list(_head(fitted, verdict)), name)
    write_output(output, model.text, EXPORT, overwrite)
    warnings = [*fitted.warnings, *fitted.known_from_below, *([] if verdict.complete else [verdict.text])]
    warnings += [f"without counterpart in MuJoCo, left out: {entry}" for entry in model.without_counterpart]
    return WrittenRobot(f"the robot of {fitted.source} for MuJoCo, with its springs", warnings)


def _head(fitted: FittedRobot, verdict: ModelVerdict) -> Iterator[str]:
    chain = fitted.campaign.chain
    yield f"{chain.name or 'a robot'} with its springs, campaign {fitted.campaign.name}, {fitted.source}"
    yield f"written by stiffcal {__version__}"
    yield verdict.text
    for warning in (*fitted.warnings, *fitted.known_from_below):
        yield f"caution: {warning}"
    yield "Units: m, rad, N, N m, kg. World: frame 0 of the robot file."
    yield "Controls: one a drive, rad; the gain of each servo is the stiffness of the drive."
    constants = np.linalg.solve(chain.coupling, chain.offset)
    for name, constant in zip(chain.joint_names, constants, strict=True):
        yield f"  {name}: the commanded logged angle {'-' if constant < 0.0 else '+'} {abs(constant):.15g}"
    yield "Load: force and moment on the robot at the site load_point. Targets: the sites target_NAME."
    yield "Rotor inertia, damping and rotational inertia are not measured values; they have no influence at rest."
    if not fitted.robot.deformed:
        yield "The model is of first order; MuJoCo balances the deformed robot, whose lever arms have changed."
    yield "Effects: " + ", ".join(f"{placed.effect.name} {placed.place.label}" for placed in fitted.robot.acting)
