"""The clamped robot as people read it: a row for each joint."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import NOT_KNOWN, significant
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from rich.console import Console

    from stiffcal.experiments.clamped.results import ClampedSection


def degrees(radians: float | None, digits: int = 3) -> str:
    """Return an angle in degrees.

    Examples
    --------
    >>> degrees(0.0017453), degrees(None)
    ('0.100', '–')
    """
    return NOT_KNOWN if radians is None else significant(math.degrees(radians), digits)


def show_clamped(console: Console, section: ClampedSection | None) -> None:
    """Draw play, friction and reversal error joint by joint; the definition of play stands below."""
    if section is None or not section.joints:
        return
    table = plain_table(
        "clamped", "play, ± 95 % [°]>", "friction [N·m]>", "reversal error [°]>", "torque reached [N·m]>", "poses"
    )
    for joint in section.joints:
        half = degrees(NORMAL_95 * joint.play_std, 2)
        low, high = joint.curve.torque
        table.add_row(
            f"joint {joint.joint} ({joint.name})",
            f"{degrees(joint.play)} ± {half}" if joint.play_found else f"none found, ± {half}",
            significant(joint.friction) if joint.friction_found else "none found",
            degrees(joint.reversal_error, 2),
            f"{significant(low)} … {significant(high)}",
            ", ".join(joint.runs),
        )
    console.print(table)
    console.print(f"play: {section.definition.play}", soft_wrap=True)
