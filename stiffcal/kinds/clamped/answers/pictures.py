"""The clamped robot in pictures (004, Fig. 5 to 8): branches with their play, torque over angle, play by pose."""

from __future__ import annotations

import numpy as np

from stiffcal.kinds.clamped.answers.curves import ClampedCurve, ClampedPose
from stiffcal.kinds.clamped.loops.torque_angle_fit import CURVE
from stiffcal.kinds.departures import Departure, departure_bars, departures_in_words, find_departures
from stiffcal.presentation.values import Band, Line, Marks, Names, Panel, Picture, Series, Span, Words
from stiffcal.quantity import ANGLE, MOMENT, STIFFNESS
from stiffcal.uncertainty import NORMAL_95

_ROW_MM = 43.0
_ANGLE, _TORQUE, _STIFF = ANGLE.usual, MOMENT.usual, STIFFNESS.usual
"""Angles are drawn in mrad."""


def branches_picture(curves: tuple[ClampedCurve, ...]) -> Picture:
    """Return torque over angle of every joint in the pose that moved it furthest: both branches, the law, the play."""
    caption = (
        "Torque over angle of ", Names(tuple(curve.joint for curve in curves)),
        (", averaged over cycles, in the pose with the largest motion: both directions, the fitted law, and the "
        "segment of low slope (grey)."),
    )  # fmt: skip
    panels = tuple(_branches(curve.joint, curve.widest_pose) for curve in curves)
    return _in_rows(panels, caption)


def _in_rows(panels: tuple[Panel, ...], caption: Words) -> Picture:
    """Return a picture of panels, two or three in a row, not higher than 100 mm for six of them."""
    columns = 2 if len(panels) <= 2 else 3
    return Picture(panels, columns=columns, height=_ROW_MM * -(-len(panels) // columns) + 10, caption=caption)


def _branches(joint: str, pose: ClampedPose) -> Panel:
    series: list[Series] = []
    if pose.low is not None and pose.high is not None:
        series.append(Span(_ANGLE.factor * float(pose.low), _ANGLE.factor * float(pose.high), label="low slope"))
    for is_rising, marker, colour, label in ((True, "^", 0, "increasing angle"), (False, "v", 1, "decreasing angle")):
        of_branch = np.flatnonzero(pose.up == is_rising)
        order = of_branch[np.argsort(pose.angle[of_branch])]
        angle = _ANGLE.factor * pose.angle[order]
        series.append(
            Marks(
                angle, pose.torque[order], marker, colour, size=2.4, edge=0.6, label=label, run=pose.run,
                sweep="up" if is_rising else "down",
            )
        )  # fmt: skip
        series.append(Line(angle, pose.fitted[order], width=0.9, label="fit"))
    title = f"{joint}, run {pose.run}" + (" (left out)" if pose.left_out else "")
    x_label = _ANGLE.in_brackets("angle, arm relative to motor")
    y_label = _TORQUE.in_brackets("torque on the joint")
    return Panel(title, x_label, y_label, tuple(series), joint=joint)


def curves_picture(curves: tuple[ClampedCurve, ...]) -> Picture:
    """Return the torque-angle curve of every joint, counted from the flank, with the readings of all poses used."""
    of_joints = [(curve.joint, departures(curve)) for curve in curves]
    caption: Words = (
        "Torque over the spring's angle of ", Names(tuple(curve.joint for curve in curves)),
        (", counted from the flank, with that segment, friction and zero offset of the sensor removed: readings of "
        "all used poses, the third-order polynomial (dashed) and its 95 % interval."),
        *departures_in_words(of_joints, _ANGLE.name, _ANGLE.factor),
    )  # fmt: skip
    return _in_rows(tuple(_curve(curve) for curve in curves), caption)


def departures(curve: ClampedCurve) -> list[Departure]:
    """Return where the readings leave the 95 % interval of the curve, over the angle in rad and in N·m."""
    used = [pose for pose in curve.poses if pose.run in curve.curve_runs]
    if not used or not curve.angle.size:
        return []
    angle = np.concatenate([pose.spring_angle for pose in used])
    torque = np.concatenate([pose.spring_torque for pose in used])
    within = (angle >= curve.angle.min()) & (angle <= curve.angle.max())
    angle, torque = angle[within], torque[within]
    half = NORMAL_95 * np.interp(angle, curve.angle, curve.std)
    return find_departures(angle, torque - np.interp(angle, curve.angle, curve.torque), half)


def _curve(curve: ClampedCurve) -> Panel:
    used = [pose for pose in curve.poses if pose.run in curve.curve_runs]
    series: list[Series] = [
        Marks(
            _ANGLE.factor * pose.spring_angle, pose.spring_torque, str(number), number, size=2.2, edge=0.5,
            label=pose.run, layer=2.0, run=pose.run, sweep="both",
        )
        for number, pose in enumerate(used)
    ]  # fmt: skip
    angle = _ANGLE.factor * curve.angle
    if curve.result is not None and CURVE[0] not in curve.result.at_bound:
        half = NORMAL_95 * curve.std
        series.append(Band(angle, curve.torque - half, curve.torque + half))
    series.append(Line(angle, curve.torque, is_dashed=True))
    series += departure_bars(curve.angle, curve.torque, np.isfinite(curve.angle), departures(curve), _ANGLE.factor)
    return Panel(
        curve.joint, _ANGLE.in_brackets("angle from the flank"), _TORQUE.in_brackets("torque"), tuple(series),
        x_ticks=5, has_zero_lines=True, has_own_legend=True, joint=curve.joint,
    )  # fmt: skip


def tangents_picture(curves: tuple[ClampedCurve, ...]) -> Picture:
    """Return the tangent stiffness of every joint over its torque, with the 95 % interval."""
    panels = []
    at_limit = any(curve.result is not None and "chord" in curve.result.at_bound for curve in curves)
    for curve in curves:
        tangents = [] if curve.result is None else sorted(curve.result.tangent_stiffness, key=lambda at: at.torque)
        torque = np.array([at.torque for at in tangents])
        value = np.array([at.stiffness for at in tangents])
        low, high = (np.array([at.interval[end] for at in tangents], dtype=np.float64) for end in (0, 1))
        series = (
            Band(torque, low, high, label="95 % interval"),
            Line(torque, value, width=0.9),
            Marks(torque, value, "o", 0, size=2.6, is_hollow=False, label="tangent stiffness"),
        )
        panels.append(
            Panel(
                curve.joint, _TORQUE.in_brackets("torque"), _STIFF.in_brackets("stiffness"), series,
                x_ticks=5, head_room=0.05, joint=curve.joint,
            )
        )  # fmt: skip
    caption: Words = (
        "Tangent stiffness of ", Names(tuple(curve.joint for curve in curves)),
        " over torque, the segment of low slope excluded.",
        *([" Without an interval: the search ended at a limit."] if at_limit else []),
    )  # fmt: skip
    return _in_rows(tuple(panels), caption)


def low_slope_picture(curves: tuple[ClampedCurve, ...]) -> Picture:
    """Return the low slope of each joint in each pose, with what it is known to; poses left out as crosses."""
    series: list[Series] = []
    for place, curve in enumerate(curves):
        poses = [pose for pose in curve.poses if pose.play is not None]
        spots = place + (np.arange(len(poses)) - 0.5 * (len(poses) - 1)) * min(0.22, 0.7 / max(len(poses), 1))
        if curve.result is not None:
            play = np.full(2, _ANGLE.factor * curve.result.low_slope)
            series.append(Line(np.array([place - 0.42, place + 0.42]), play, width=1.0, label="joint", layer=1.0))
        for spot, pose in zip(spots, poses, strict=True):
            is_cross = bool(pose.left_out)
            series.append(
                Marks(
                    np.array([spot]), np.array([_ANGLE.factor * (pose.play or 0.0)]),
                    "x" if is_cross else "o", 1 if is_cross else 0,
                    size=4.5, label="pose, left out" if is_cross else "pose, used",
                    spread=np.array([_ANGLE.factor * pose.doubt]), note=pose.run, run=pose.run,
                )
            )  # fmt: skip
    panel = Panel(
        "", "", _ANGLE.in_brackets("segment of low slope"), tuple(series), x_limits=(-0.6, len(curves) - 0.4),
        head_room=0.3, x_names=tuple(curve.joint for curve in curves),
    )  # fmt: skip
    caption = (
        (
            "Segment of low slope of each joint by pose, with its resolution (encoder step, noise, distance of "
            "readings) and the scatter between cycles. "
            "Crosses: poses excluded, because the motion barely exceeds the segment. Line: that of the joint."
        ),
    )
    return Picture((panel,), columns=1, height=56.0, caption=caption)
