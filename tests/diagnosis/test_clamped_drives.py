"""Clamped runs of several joints: what one drive lacks is named at it, and nothing at the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.clamped_bench import clamped_bench, held_jacobian
from tests.laboratory.named_effects import named
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

pytestmark = pytest.mark.long

POSES = np.array([[0.1, -1.0, 0.8, 0.2, 0.7, 0.1], [-0.4, -0.8, 1.1, -0.3, 0.9, 0.4]])
MOVED = (2, 5)
TRIED = ("joint-compliance", "cubic-stiffness", "backlash", "two-slope", "fixture-compliance", "friction-hysteresis")


def without_weight() -> Chain:
    """Return a robot whose joints carry the wrench alone: the torque of a law is known exactly."""
    return replace(six_axes(), gravity=np.zeros(3))


def bench(share: dict[int, float]) -> LoadStates:
    """Return runs of two joints whose drives give more by a cubic law: so much of their spring's at the largest torque.

    In a held chain a motor turns so much further for the same wrench.
    """
    chain = without_weight()
    states = clamped_bench(chain, POSES, MOVED, 1e-9 * np.eye(6))
    torque, joint = np.zeros(len(states)), np.array(MOVED)[states.run % len(MOVED)]
    for run in range(len(states.runs)):
        own, pose = states.run == run, POSES[run // len(MOVED)]
        axes = attached_poses(chain, chain.model_angles(pose[None]), states.setup.wrench_axes)[1][0]
        wrench = np.concatenate([states.wrench[own, :3] @ axes.T, states.wrench[own, 3:] @ axes.T], axis=1)
        torque[own] = wrench @ held_jacobian(chain, pose)[:, MOVED[run % len(MOVED)] - 1]
    joints = states.joints.copy()
    for moved, part in share.items():
        own = joint == moved
        at_largest = part / SIX_STIFFNESS[moved - 1]
        joints[own, moved - 1] -= at_largest * torque[own] ** 3 / np.abs(torque[own]).max() ** 2
    return replace(states, joints=joints)


def diagnosed(states: LoadStates) -> DiagnosedStates:
    effects = find_effects()
    springs = [PlacedEffect(effects["joint-compliance"], Place("joints", (k,))) for k in range(1, 7)]
    plate = PlacedEffect(effects["fixture-compliance"], Place("setup"))
    robot = CompliantRobot(without_weight(), (*springs, plate), deformed=False)
    return diagnose_states(states, robot, {name: effects[name] for name in TRIED})


def test_drives_with_springs_alone_lack_nothing() -> None:
    found = diagnosed(bench({}))
    assert named(found) == []
    assert not found.unexplained


def test_a_law_of_one_drive_is_named_at_it_alone() -> None:
    found = diagnosed(bench({5: 0.3}))
    assert named(found) == ["cubic-stiffness j5"]
    assert found.found[0].group.firm
    assert not found.unexplained


def test_laws_of_both_drives_are_both_named() -> None:
    found = diagnosed(bench({2: 0.3, 5: 0.3}))
    assert set(named(found)) == {"cubic-stiffness j2", "cubic-stiffness j5"}
    assert not found.unexplained
