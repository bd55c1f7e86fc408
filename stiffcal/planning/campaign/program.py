"""The robot program of a plan: joint moves from run to run, in the language that the file's ending states."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.trust.output_kinds import PROGRAM
from stiffcal.trust.outputs import write_output

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.planning.candidates import Cell
    from stiffcal.planning.results import PlanResult
    from stiffcal.planning.robot_programs.language import Language

# Characters of a name that heads may hold: more is no help to a reader.
LONGEST_NAME = 60


def _languages() -> dict[str, Language]:
    from stiffcal.planning.robot_programs import fanuc, krl, rapid, urscript

    return {module.LANGUAGE.ending: module.LANGUAGE for module in (krl, rapid, urscript, fanuc)}


def check_program(file: Path, campaign: Campaign, kind: str = "load") -> Language:
    """Return the language of a robot program.

    Raises
    ------
    InputError : the ending is of no language, the name is none in it, the robot has other than six joints, or it is
        clamped.
    """
    from stiffcal.planning.robot_programs.language import AXES

    if kind == "clamped":
        reason = "a clamped robot is driven by hand, one joint at a time, watching the force"
        raise InputError.at(FaultCode.OPTION_INVALID, str(file), "", reason, "leave --program out")
    languages = _languages()
    language = languages.get(file.suffix.lower())
    if language is None:
        known = ", ".join(f"{ending} ({entry.maker})" for ending, entry in languages.items())
        reason = "the file ending belongs to no known robot language"
        raise InputError.at(FaultCode.FORMAT_UNKNOWN, str(file), "", reason, f"use one of {known}")
    name = file.stem
    valid = re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and len(name) <= language.longest_name
    if not valid or name.lower() in language.reserved:
        mend = (
            f"write a letter, then letters, digits or _, at most {language.longest_name} characters, and none of "
            f"{', '.join(sorted(language.reserved))}"
        )
        raise InputError.at(
            FaultCode.NAME_INVALID, str(file), "", f"{language.maker} has no programs of this name", mend
        )
    if len(campaign.chain.joint_names) != AXES:
        reason = f"robot programs are for six joints, and {len(campaign.chain.joint_names)} are logged of this robot"
        mend = "leave --program out, and move the robot by hand as the run sheet states"
        raise InputError.at(FaultCode.JOINT_COUNT, campaign.manifest.robot, "joints", reason, mend)
    return language


def write_program(file: Path, campaign: Campaign, plan: PlanResult, cell: Cell, *, overwrite: bool = False) -> None:
    """Write the program: it waits before the first move and at every pose, and starts at no time by itself.

    Raises
    ------
    InputError : see `check_program`; a move is not free; or the file cannot be written or holds something else.
    """
    from stiffcal.planning.robot_programs.language import Halt, Move, Remark, program_text

    language = check_program(file, campaign)
    if plan.blocked_moves:
        before, after = plan.blocked_moves[0]
        reason = f"there is no collision-free joint move from {before} to {after}"
        mend = "allow more candidates or another seed, reduce link_radius_m, or leave --program out"
        raise InputError.at(FaultCode.POSE_UNREACHABLE, "plan.toml", "keep_out", reason, mend)
    steps: list[Halt | Move | Remark] = [Halt("first pose: move by hand")]
    for run in plan.runs:
        steps.append(Remark(f"{run.id}: {load_text(run.wrench)}, as the run sheet states"))
        steps += [Move(joints) for joints in (*run.approach, run.joints)]
        steps.append(Halt(f"{run.id}: load, unload, start" if run.wrench.any() else f"{run.id}: measure, start"))
    text = program_text(language, file.stem, _head(campaign, plan, cell), steps)
    write_output(file, text.encode("ascii"), PROGRAM, overwrite)


def load_text(wrench: Floats) -> str:
    """Return the load steps (K, 6) of a run in words: sizes along the direction of the largest force."""
    from stiffcal.planning.wording import direction_and_sizes

    load = direction_and_sizes(wrench)
    return "no load" if load is None else f"{load[1]} N along {load[0]}, base axes"


def _head(campaign: Campaign, plan: PlanResult, cell: Cell) -> list[str]:
    robot = (campaign.robot.name or "a robot")[:LONGEST_NAME]
    names = [name[:LONGEST_NAME] for name in plan.joint_names]
    from stiffcal.planning.capsules import NEIGHBOUR

    low, high = np.degrees(cell.limits.T)
    limits = [f"  {name}: {a:.1f} to {b:.1f}" for name, a, b in zip(names, low, high, strict=True)]
    boxes = [
        f"  keep-out box {number}: {_corner(box[0])} to {_corner(box[1])}"
        for number, box in enumerate(cell.boxes, start=1)
    ]
    lowest = "  no lowest height" if cell.lowest is None else f"  no link below {cell.lowest:.3f} m"
    return [
        f"Joint moves from run to run of a plan, made by stiffcal for {robot}",
        "The poses and the joint moves between them were CHECKED AGAINST THESE ONLY:",
        "joint limits with their margin, degrees:",
        *limits,
        f"links as capsules of radius {cell.radius:.3f} m about the lines between the joints, and",
        *(boxes or ["  no keep-out box"]),
        lowest,
        f"  each other, where more than {NEIGHBOUR * cell.radius:.3f} m of the arm lies between them",
        "NOT CHECKED: the way to the first pose, neighbouring links, tool, cables, load, everything else.",
        "Joint angles are those of the campaign logs: first compare zero and sign of each with the display.",
        "Set tool and load data of the controller. Run it in manual mode at reduced speed, with an enabling switch.",
        "It waits before the first move and at every pose. Load only while it waits, and unload before starting again.",
    ]


def _corner(corner: Floats) -> str:
    return f"({', '.join(f'{part:.3f}' for part in corner)}) m"
