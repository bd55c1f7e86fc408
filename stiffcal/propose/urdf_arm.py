"""Which part of a URDF a table's joint columns describe: the ends of the chain, and the columns in its order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.robot.urdf.chain import MOVING, PRISMATIC, UrdfRobot, chain_between, possible_tips
from stiffcal.campaign.robot.urdf.elements import UrdfJoint
from stiffcal.campaign.robot.urdf.tree import read_tree
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.joint_columns import columns_of_joints
from stiffcal.propose.lines import ProposedLine
from stiffcal.propose.table_sniffing import SniffedColumn

_USUAL_TIPS = ("tool0", "flange", "tcp", "tool", "ee_link", "end_effector")


@dataclass(frozen=True)
class UrdfArm:
    """The chain of a URDF that a table describes."""

    columns: tuple[SniffedColumn, ...]
    """One for each joint, base to tip; empty where the columns do not carry the joints' names."""
    lines: tuple[ProposedLine, ...]
    """``base_link`` and ``tip_link`` of robot.toml, as far as they are needed."""
    prismatic: frozenset[SniffedColumn] = frozenset()
    """Those of the columns that hold positions of prismatic joints."""


def arm_of_table(path: Path, columns: Sequence[SniffedColumn]) -> UrdfArm:
    """Return the chain whose joints have columns; without such columns the chain of all joints that turn.

    Joints before the first and behind the last that has a column (a rail, a torso, fingers) are left out.

    Parameters
    ----------
    path : the URDF.
    columns : of the table.

    Raises
    ------
    InputError
        The URDF cannot be read, the chain is part of a closed loop, or a moving joint between two that have columns
        has none.
    """
    tree = read_tree(path, path.name)
    tips = possible_tips(tree)
    chains = [chain_between(tree, None, tip) for tip in tips]
    found = [columns_of_joints(columns, [joint.name for joint in chain.moving]) for chain in chains]
    best = max(range(len(tips)), key=lambda k: (len(found[k]), -_preference(tips[k]), -k))
    chain, column_of = chains[best], found[best]
    moving = [joint for joint in chain.path if joint.kind != "fixed"]
    used = [k for k, joint in enumerate(moving) if joint.name in column_of] or [
        k for k, joint in enumerate(moving) if joint.kind in MOVING and joint.kind != PRISMATIC and joint.mimic is None
    ]
    if not used:
        return UrdfArm((), ())
    before, arm, behind = moving[: used[0]], moving[used[0] : used[-1] + 1], moving[used[-1] + 1 :]
    tree.check_serial(chain.path[chain.path.index(arm[0]) : chain.path.index(arm[-1]) + 1])
    if column_of:
        _check_complete(arm, column_of, path.name)
    lines = [*_base_line(before), *_tip_line(chain, behind, [tip for tip in tips if tip != chain.tip])]
    if not column_of:
        return UrdfArm((), tuple(lines))
    prismatic = frozenset(column_of[joint.name] for joint in arm if joint.kind == PRISMATIC)
    return UrdfArm(tuple(column_of[joint.name] for joint in arm), tuple(lines), prismatic)


def _preference(tip: str) -> int:
    return _USUAL_TIPS.index(tip) if tip in _USUAL_TIPS else len(_USUAL_TIPS)


def _check_complete(arm: Sequence[UrdfJoint], column_of: dict[str, SniffedColumn], file: str) -> None:
    for joint in arm:
        if joint.name in column_of:
            continue
        mend = 'if the joint did not move, make its type "fixed" in the URDF, with its position in <origin>'
        if joint.kind in MOVING:
            reason, mend = "no column of the table has its name", f"add the column {joint.name}; {mend}"
            code = FaultCode.COLUMN_MISSING
        else:
            reason, code = f"the stiffness of a {joint.kind} joint cannot be identified", FaultCode.URDF_INVALID
        raise InputError.at(code, file, f"joint {joint.name}", reason, mend)


def _base_line(before: Sequence[UrdfJoint]) -> list[ProposedLine]:
    if not before:
        return []
    doubt = f"{_named(before)}: everything before this link is taken as fixed"
    return [ProposedLine(f"base_link = {toml_text.value(before[-1].child)}", doubt)]


def _tip_line(chain: UrdfRobot, behind: Sequence[UrdfJoint], others: Sequence[str]) -> list[ProposedLine]:
    if behind:
        doubt = f"{_named(behind)}: everything after this link is taken as fixed"
        return [ProposedLine(f"tip_link = {toml_text.value(behind[0].parent)}", doubt)]
    if others:
        return [
            ProposedLine(toml_text.pair("tip_link", chain.tip), f"the flange; the URDF has {', '.join(others)} too")
        ]
    return []


def _named(joints: Sequence[UrdfJoint]) -> str:
    names = ", ".join(f"{joint.name} ({joint.kind})" for joint in joints)
    return f"no column for joint{'s' * (len(joints) > 1)} {names}"
