"""A robot.toml to fill in, for `init --from`."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.escapes import toml_text
from stiffcal.propose.lines import ProposedLine


def robot_lines(joints: Sequence[str]) -> list[ProposedLine]:
    """Return a robot.toml to fill in: a row for each joint."""
    mend = 'or "dh"; fill in the rows, or repeat with --robot NAME or --urdf FILE'
    lines = [ProposedLine('schema = "stiffcal/robot/1"'), ProposedLine('convention = "modified-dh"', mend)]
    for name in joints:
        lines += [ProposedLine(text) for text in ("", "[[joints]]", f"name = {toml_text.value(name)}")]
        lines += [ProposedLine(f"{key} = 0.0", "") for key in ("a_m", "alpha_deg", "d_m", "theta_deg")]
    return [*lines, ProposedLine(""), ProposedLine("[flange]"), ProposedLine("xyz_m = [0.0, 0.0, 0.0]", "")]
