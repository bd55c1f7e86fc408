"""Friction against MuJoCo: its drives turn with frictional loss, dampers, rotors and weight; ours finds them again."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.kinds.friction.fitting.joint_fits import FrictionFit, fit_friction
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, motion_rows, steady_rows
from stiffcal.kinds.friction.logs.friction_run import FrictionRun
from stiffcal.kinds.friction.logs.runs import reduce_friction
from stiffcal.measurements.load_states import RunInfo
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Place
from stiffcal.reduction.logs.blocks import blocks_of
from tests.laboratory.joint_strokes import LAW, stroke
from tests.laboratory.mujoco_drives import Drives, driven
from tests.laboratory.robots import six_axes

CHAIN = six_axes()
DRIVES = Drives(
    np.array([60.0, 50.0, 40.0, 12.0, 10.0, 5.0]),
    np.array([90.0, 80.0, 50.0, 8.0, 6.0, 3.0]),
    np.array([30.0, 25.0, 15.0, 2.0, 1.5, 0.5]),
)
POSE = np.radians([10.0, -60.0, 20.0, 30.0, 40.0, 0.0])


def run_of(name: str, time: Floats, angles: Floats, torque: Floats) -> FrictionRun:
    blocks = blocks_of(time, {"joints": angles, "joints.torque": torque})
    info = RunInfo(name, "friction")
    return FrictionRun(info, None, blocks.time, blocks.mean["joints"], blocks.mean["joints.torque"], None)


def fitted(rows: FrictionRows, *joints: int) -> FrictionFit:
    return fit_friction(rows, tuple(PlacedEffect(LAW, Place("joints", (joint,))) for joint in joints), CHAIN)


def test_steady_velocities_both_ways() -> None:
    """Joint 2 lifts the arm, 1.3 kN·m of weight: loss and damping come out, weight and inertia do not."""
    runs = []
    for speed, length in ((0.05, 0.15), (0.1, 0.3), (0.3, 0.9), (0.6, 0.9), (1.0, 0.9)):
        whole = length / speed + speed / 4.0

        def path(time: Floats, speed: float = speed, length: float = length, whole: float = whole) -> Floats:
            angles = np.tile(POSE, (time.size, 1))
            angles[:, 1] += stroke(time - 0.2, speed, length, 4.0) - stroke(time - 0.4 - whole, speed, length, 4.0)
            return angles

        runs.append(run_of(f"{speed}", *driven(CHAIN, DRIVES, path, 2.0 * whole + 0.6)))
    reduction = reduce_friction(runs, CHAIN)
    assert reduction.steady is not None
    assert reduction.steady.used.all()
    assert reduction.samples is not None
    (joint,) = fitted(steady_rows(reduction.samples), 2).joints
    found = {name.rsplit(".", 1)[-1]: value for name, value in joint.values.items()}
    assert found == pytest.approx({"coulomb": 50.0, "viscous": 80.0}, rel=1e-3)


def test_all_joints_at_once_by_the_rigid_body_model() -> None:
    """Nothing is steady: weight and inertia of every link are fitted too; the cubic window errs by some per cent."""
    rng = np.random.default_rng(3)
    size = rng.normal(size=(6, 4)) * np.array([0.4, 0.25, 0.25, 0.5, 0.5, 0.7])[:, None] / np.arange(1, 5)
    phase = rng.uniform(0.0, 2.0 * np.pi, (6, 4))
    pace = 2.0 * np.pi * 0.12 * np.arange(1, 5)

    def path(time: Floats) -> Floats:
        return np.asarray(POSE + (size * np.sin(pace * time[:, None, None] + phase)).sum(axis=2))

    reduction = reduce_friction([run_of("all", *driven(CHAIN, DRIVES, path, 12.0))], CHAIN)
    assert reduction.steady is None
    assert reduction.motion is not None
    fit = fitted(motion_rows(reduction.motion, CHAIN), *range(1, 7))
    found = np.array([list(one.values.values()) for one in fit.joints])
    np.testing.assert_allclose(found[:, 0], DRIVES.loss, rtol=0.06)
    np.testing.assert_allclose(found[:4, 1], DRIVES.damping[:4], rtol=0.10)
