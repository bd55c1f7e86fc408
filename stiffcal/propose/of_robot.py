"""`init --robot` and `init --urdf` without a table: the commented folder, with the robot in place of the example."""

from __future__ import annotations

from pathlib import Path

from stiffcal.campaign.robot.robot_checks import outline_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.toml_reading import parse_toml
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.lines import ProposedLine, as_text
from stiffcal.propose.templates import chosen_robot, template_manifest, write_folder
from stiffcal.propose.urdf_arm import arm_of_table

SIX = '"A1..A6"'
"""The columns of the joints in the template, whose robot has six."""


def write_for_robot(folder: Path, *, urdf: Path | None, robot: str | None, overwrite: bool = False) -> list[Path]:
    """Write a commented campaign folder for a robot that is known; return its files.

    Parameters
    ----------
    folder : made where it does not exist. urdf : the robot as a URDF; not where `robot` is given too.
    robot : the name of a bundled robot, or the path of a robot file. overwrite : also over files that are there.

    Raises
    ------
    InputError
        There is no such robot, its URDF is faulty, or the folder holds a campaign already.
    """
    copies: dict[str, Path] = {}
    if robot is not None or urdf is None:
        text, path = chosen_robot(str(robot)), folder / "robot.toml"
    else:
        if not urdf.is_file():
            raise InputError.at(FaultCode.FILE_MISSING, str(urdf), "", "no such file", "correct the path after --urdf")
        lines = [ProposedLine('schema = "stiffcal/robot/1"'), ProposedLine(toml_text.pair("urdf", urdf.name))]
        text, path = as_text([*lines, *arm_of_table(urdf, ()).lines]), urdf
        copies = {urdf.name: urdf}
    count = len(outline_of(RobotFile.model_validate(parse_toml(text, "robot.toml")), path).joint_names)
    manifest = template_manifest("load").replace(SIX, f'"A1..A{count}"')
    return write_folder(folder, {MANIFEST_FILE: manifest, "robot.toml": text}, copies, overwrite=overwrite)
