"""A joint's apparent compliance, run by run, against what it follows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.diagnosis.answers.pattern_results import CompliancePattern, FollowedBy
from stiffcal.quantity import COMPLIANCE, FORCE, JOINT_ANGLE, MOMENT, ShownUnit
from stiffcal.report.figures import canvas
from stiffcal.uncertainty import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@canvas.styled
def draw_pattern(pattern: CompliancePattern) -> Figure:
    """Draw each run's apparent change of compliance with 95 % bars, and the fitted law.

    Returns
    -------
    Figure; compliances, angles, torques, forces, times in their units; directions as numbers.
    """
    angle = pattern.follows is FollowedBy.JOINT_ANGLE
    factor = JOINT_ANGLE.usual.factor if angle else pattern.scale
    what, unit = {
        FollowedBy.JOINT_ANGLE: (f"angle of joint {pattern.of_joint}", JOINT_ANGLE.usual),
        FollowedBy.JOINT_TORQUE: (f"size of the torque on joint {pattern.of_joint}", MOMENT.usual),
        FollowedBy.LOAD: ("size of the load", FORCE.usual),
        FollowedBy.TIME: ("time", ShownUnit("s")),
        FollowedBy.LAST_MOTION: (
            f"last motion of joint {pattern.of_joint}: 1 with its torque, −1 against it",
            ShownUnit(""),
        ),
    }[pattern.follows]
    figure = canvas.new_figure(canvas.PAGE_WIDTH_MM, 60)
    axes = figure.subplots()
    at = np.array([point.at for point in pattern.points]) * factor
    compliance = np.array([point.compliance for point in pattern.points])
    shown = canvas.unit_of(COMPLIANCE, compliance)
    compliance *= shown.factor
    half_width = NORMAL_95 * shown.factor * np.array([point.std for point in pattern.points])
    axes.errorbar(at, compliance, half_width, fmt="o", color=canvas.COLOURS[0], markersize=4.0, label="a run, 95 %")
    curve = np.array(pattern.curve).reshape(-1, 2)
    axes.plot(curve[:, 0] * factor, curve[:, 1] * shown.factor, color=canvas.ACCENT, label="fitted law")
    axes.axhline(0.0, color=canvas.PALE, linewidth=1.0, zorder=0)
    axes.set_xlabel(unit.in_brackets(what))
    axes.set_ylabel(shown.in_brackets("change of compliance"))
    canvas.share_legend(figure, axes.get_legend_handles_labels()[0])
    return figure
