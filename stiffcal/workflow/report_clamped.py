"""What the report shows of clamped runs: branches, curves, and the play by pose."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.experiments.clamped.parts import BRANCHES
from stiffcal.experiments.clamped.results import RunResult
from stiffcal.report.clamped_curves import ClampedCurve, ClampedPose
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.store import values_of
from stiffcal.uncertainty import NORMAL_95
from stiffcal.workflow.steps import Ingested

_POINTS = 201


def clamped_curves(data: Ingested, identified: IdentifyResult) -> tuple[ClampedCurve, ...]:
    """Return every joint that a clamped run moved; none where there are no clamped runs."""
    section = identified.clamped
    if section is None or not section.runs or BRANCHES not in data.store.tables:
        return ()
    table = data.store.read_table(BRANCHES)
    runs = np.array(table.column("run").to_pylist(), dtype=np.str_)
    columns = {name: values_of(table.column(name)) for name in ("angle_rad", "torque_Nm", "up", "law_Nm")}
    results = {joint.joint: joint for joint in section.joints}
    curves = []
    for joint in sorted({run.joint for run in section.runs}):
        poses = tuple(
            _pose(run, {name: values[runs == run.run] for name, values in columns.items()})
            for run in section.runs
            if run.joint == joint
        )
        result = results.get(joint)
        low, high = (0.0, 0.0) if result is None else result.curve.reach
        angle = np.linspace(low, high, 0 if result is None else _POINTS)
        powers = np.stack([angle, angle**2, angle**3])
        curve = np.zeros(3) if result is None else np.array([result.curve.p1, result.curve.p2, result.curve.p3])
        covariance = np.zeros((3, 3)) if result is None else result.curve.covariance
        through = () if result is None else tuple(result.curve.runs)
        std = np.sqrt(np.maximum(np.einsum("in,ij,jn->n", powers, covariance, powers), 0.0))
        curves.append(ClampedCurve(data.joint_names[joint - 1], poses, result, angle, curve @ powers, std, through))
    return tuple(curves)


def _pose(run: RunResult, columns: dict[str, NDArray[Any]]) -> ClampedPose:
    law = run.law
    angle, torque, up = columns["angle_rad"], columns["torque_Nm"], columns["up"].astype(bool)
    sign = np.where(up, 1.0, -1.0)
    even = torque - law.zero - sign * law.friction
    spring = even / (1.0 + sign * np.sign(even) * law.drag)
    turned = angle - sign * law.lag - law.middle
    outside = np.abs(turned) > 0.5 * law.width
    from_flank = turned - 0.5 * law.width * np.sign(turned)
    half = 0.5 * (run.play or 0.0)
    return ClampedPose(
        run=run.run,
        left_out=run.left_out,
        angle=angle,
        torque=torque,
        up=up,
        fitted=columns["law_Nm"],
        play=run.play,
        doubt=max(run.resolution or 0.0, NORMAL_95 * (run.play_between_cycles or 0.0)),
        motion=run.motion,
        low=law.middle - half if half else None,
        high=law.middle + half if half else None,
        spring_angle=from_flank[outside],
        spring_torque=spring[outside],
        remark=run.saturated or "",
    )
