"""A robot.toml to fill in, for `init --from`."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.escapes import toml_text
from stiffcal.propose.lines import ProposedLine

_REMARKS = (
    "# Base to wrist. theta_deg is the angle of the table where the controller shows 0; direction = -1 where it counts",
    "# the other way. With known masses: link = { mass_kg = 12, com_m = [0.1, 0.0, 0.0] }, in the joint's own frame.",
)


def robot_lines(joints: Sequence[str]) -> list[ProposedLine]:
    """Return a robot.toml to fill in: a row for each joint, as the tables of data sheets have them."""
    mend = 'or "dh" (alpha and a of a row after its theta and d); fill in the rows, or repeat with --robot or --urdf'
    zeros = "a_m = 0.0, alpha_deg = 0.0, d_m = 0.0, theta_deg = 0.0"
    return [
        ProposedLine('schema = "stiffcal/robot/1"'),
        ProposedLine('convention = "modified-dh"', mend),
        *map(ProposedLine, ("", *_REMARKS, toml_text.pair("joints", []).removesuffix("]"))),
        *(ProposedLine(f"  {{ name = {toml_text.value(name)}, {zeros} }},", "") for name in joints),
        *map(ProposedLine, ("]", "", "[flange]")),
        ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "in the last joint's frame"),
    ]
