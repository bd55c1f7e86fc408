"""The clamped robot in pictures (004, Fig. 5 to 8): branches with their play, torque over angle, play by pose."""

from __future__ import annotations

import numpy as np

from stiffcal.experiments.clamped.curves import ClampedCurve, ClampedPose
from stiffcal.experiments.presentation import Band, Line, Marks, Names, Panel, Picture, Series, Span
from stiffcal.uncertainty import NORMAL_95

_ROW_MM = 52.0


def branches_picture(curves: tuple[ClampedCurve, ...]) -> Picture:
    """Return torque over angle of every joint in the pose that moved it furthest: both branches, the law, the play."""
    caption = (
        "Torque over angle of ", Names(tuple(curve.joint for curve in curves)),
        (", averaged over cycles, in the pose that moved the joint furthest: both directions, the fitted law, and the "
        "play in grey."),
    )  # fmt: skip
    panels = tuple(_branches(curve.joint, curve.widest_pose) for curve in curves)
    return Picture(panels, columns=2, height=_height(len(curves)), caption=caption)


def _height(n_panels: int) -> float:
    return _ROW_MM * ((n_panels + 1) // 2) + 10


def _branches(joint: str, pose: ClampedPose) -> Panel:
    series: list[Series] = []
    if pose.low is not None and pose.high is not None:
        series.append(Span(float(np.rad2deg(pose.low)), float(np.rad2deg(pose.high)), label="play"))
    for is_rising, marker, colour, label in ((True, "^", 0, "angle growing"), (False, "v", 1, "angle falling")):
        of_branch = np.flatnonzero(pose.up == is_rising)
        order = of_branch[np.argsort(pose.angle[of_branch])]
        angle = np.rad2deg(pose.angle[order])
        series.append(Marks(angle, pose.torque[order], marker, colour, size=2.4, edge=0.6, label=label))
        series.append(Line(angle, pose.fitted[order], width=0.9, label="fit"))
    title = f"{joint}, run {pose.run}" + (" (left out)" if pose.left_out else "")
    return Panel(title, "angle, arm against motor [°]", "torque on the joint [N·m]", tuple(series))


def curves_picture(curves: tuple[ClampedCurve, ...]) -> Picture:
    """Return the torque-angle curve of every joint, counted from the flank, with the readings of all poses used."""
    caption = (
        "Torque over the spring's angle of ", Names(tuple(curve.joint for curve in curves)),
        (", counted from the flank, play, friction and the sensor's zero taken off: readings of all poses that are "
        "used, the third-order polynomial (dashed) and its 95 % interval."),
    )  # fmt: skip
    return Picture(tuple(_curve(curve) for curve in curves), columns=2, height=_height(len(curves)), caption=caption)


def _curve(curve: ClampedCurve) -> Panel:
    used = [pose for pose in curve.poses if pose.run in curve.curve_runs]
    series: list[Series] = [
        Marks(
            np.rad2deg(pose.spring_angle), pose.spring_torque, str(number), number, size=2.2, edge=0.5, label=pose.run,
            layer=2.0,
        )
        for number, pose in enumerate(used)
    ]  # fmt: skip
    angle = np.rad2deg(curve.angle)
    half = NORMAL_95 * curve.std
    series.append(Band(angle, curve.torque - half, curve.torque + half))
    series.append(Line(angle, curve.torque, is_dashed=True))
    return Panel(
        curve.joint, "angle from the flank [°]", "torque [N·m]", tuple(series), x_ticks=5, has_zero_lines=True,
        has_own_legend=True,
    )  # fmt: skip


def play_picture(curves: tuple[ClampedCurve, ...]) -> Picture:
    """Return the play that each pose gives of each joint, with what it is known to; poses left out as crosses."""
    series: list[Series] = []
    for place, curve in enumerate(curves):
        poses = [pose for pose in curve.poses if pose.play is not None]
        spots = place + (np.arange(len(poses)) - 0.5 * (len(poses) - 1)) * min(0.22, 0.7 / max(len(poses), 1))
        if curve.result is not None:
            play = np.full(2, np.rad2deg(curve.result.play))
            series.append(Line(np.array([place - 0.42, place + 0.42]), play, width=1.0, label="joint", layer=1.0))
        for spot, pose in zip(spots, poses, strict=True):
            is_cross = bool(pose.left_out)
            series.append(
                Marks(
                    np.array([spot]), np.rad2deg([pose.play or 0.0]), "x" if is_cross else "o", 1 if is_cross else 0,
                    size=4.5, label="pose, left out" if is_cross else "pose, used",
                    spread=np.rad2deg([pose.doubt]), note=pose.run,
                )
            )  # fmt: skip
    panel = Panel(
        "", "", "play [°]", tuple(series), x_limits=(-0.6, len(curves) - 0.4), head_room=0.3,
        x_names=tuple(curve.joint for curve in curves),
    )  # fmt: skip
    caption = (
        (
            "Play of each joint by pose, with its resolution (encoder step and noise) and the scatter between cycles. "
            "Crosses: poses left out, because the motion hardly exceeds the play. The line is the joint's play."
        ),
    )
    return Picture((panel,), columns=1, height=70.0, caption=caption)
