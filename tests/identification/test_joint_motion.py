"""Each joint separately: displacement between two tracked links against the wrench there (paper 001)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.bodies.cartesian_stiffness import cartesian_stiffnesses, stiffness_by_equation_15
from stiffcal.identification.bodies.joint_lines import joint_compliance
from stiffcal.identification.bodies.joint_motion import joint_motions, measured_joints
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import played

TILT = np.array([4e6, 4e6, 3e6, 9e5, 8e5, 5e5])
TRANSLATION = 2e-9
BODIES = (7, 5, 4, 3, 2, 1)
NAMES = ("tool", "five", "four", "three", "two", "one")


def robot(play: bool = False, coupled: bool = False) -> CompliantRobot:
    """Return a robot with 36 springs, play in joint 4, and a coupling in joint 3."""
    found = find_effects()
    placed = []
    for k in range(1, 7):
        values = {
            "joint-compliance": {"c": 1.0 / SIX_STIFFNESS[k - 1]},
            "bearing-tilt": {"x": 1.0 / TILT[k - 1], "y": 1.2 / TILT[k - 1]},
            "joint-translation": dict.fromkeys(("tx", "ty", "tz"), TRANSLATION),
        }
        placed += [PlacedEffect(found[name], Place("joints", (k,)), value) for name, value in values.items()]
    if play:
        placed.append(PlacedEffect(found["backlash"], Place("joints", (4,)), {"width": 1e-3, "band": 30.0}))
    if coupled:
        placed.append(PlacedEffect(found["joint-full"], Place("joints", (3,)), {"c46": 3e-7}))
    return CompliantRobot(six_axes(), tuple(placed))


def full_wrenches(share: float) -> list[Floats]:
    """Return four runs of wrenches with forces and couples in all directions, unloaded first."""
    rng = np.random.default_rng(5)
    runs = []
    for _ in range(4):
        wrench = rng.normal(size=(60, 6)) * np.repeat([400.0, 120.0], 3) * share
        wrench[0] = 0.0
        runs.append(wrench)
    return runs


@cache
def tracked(noise: float = 0.0, play: bool = False, share: float = 1.0, coupled: bool = False) -> LoadStates:
    """Return load states with a target on every link, under a share of the full load."""
    one = robot(play, coupled)
    chain = one.chain
    states = played(one, runs=4, wrench=full_wrenches(share))
    rng = np.random.default_rng(2)
    targets = tuple(Attachment(body, np.eye(4)) for body in BODIES)
    for target in targets:
        target.transform[:3, 3] = rng.uniform(-0.2, 0.2, 3)
    setup = replace(states.setup, targets=targets, target_names=NAMES)
    balance = solve_balance(one, chain.model_angles(states.joints), states.wrench, setup)
    shape = balance.target_position.shape
    turn = rotation_from_vector(4.0 * noise * rng.normal(size=shape))
    unknown = np.full((*shape[:2], 6), np.nan)
    return replace(
        states, setup=setup, position=balance.target_position + noise * rng.normal(size=shape),
        rotation=turn @ balance.target_rotation, deflection=unknown, position_scatter=unknown[:, :, :3],
    )  # fmt: skip


def true_diagonal(joint: int) -> Floats:
    k = joint - 1
    return np.array([TRANSLATION] * 3 + [1.0 / TILT[k], 1.2 / TILT[k], 1.0 / SIX_STIFFNESS[k]])


def test_what_is_not_noise_comes_back() -> None:
    # small loads: the wrenches are taken on the undeformed chain
    motions = joint_motions(tracked(share=0.02), six_axes())
    assert [motion.joint for motion in motions] == [1, 2, 3, 4, 5, 6]
    assert [(motion.inboard, motion.outboard) for motion in motions[:2]] == [("", "one"), ("one", "two")]
    for motion in motions:
        found = joint_compliance(motion)
        value = np.array([line.compliance for line in found.lines])
        assert np.allclose(value[3:], true_diagonal(motion.joint)[3:], rtol=2e-3)
        assert np.allclose(value[:3], TRANSLATION, rtol=0.05)
        assert found.matrix is not None
        assert np.allclose(np.diag(found.matrix)[3:], true_diagonal(motion.joint)[3:], rtol=2e-3)


def test_rotations_rise_above_the_noise_and_translations_do_not() -> None:
    above: list[bool] = []
    deviations: list[float] = []
    for motion in joint_motions(tracked(noise=30e-6), six_axes()):
        found = joint_compliance(motion)
        above += [line.above_noise for line in found.lines]
        deviations += [
            (line.compliance - true) / line.std
            for line, true in zip(found.lines, true_diagonal(motion.joint), strict=True)
        ]
        assert not any(line.curved for line in found.lines)
    shape = np.array(above).reshape(6, 6)
    assert shape[:, 3:].all()
    assert not shape[:, :3].any()
    # 36 numbers, each within what its own uncertainty says
    assert np.sqrt(np.mean(np.square(deviations))) < 1.4
    assert np.max(np.abs(deviations)) < 4.0


def test_play_bends_the_line_of_its_joint_alone() -> None:
    curved = {
        (motion.joint, line.component)
        for motion in joint_motions(tracked(20e-6, play=True), six_axes())
        for line in joint_compliance(motion).lines
        if line.curved
    }
    assert curved == {(4, "rz")}


def test_couplings_next_to_the_diagonal() -> None:
    for coupled in (False, True):
        motions = joint_motions(tracked(noise=20e-6, coupled=coupled), six_axes())
        found = {motion.joint: set(joint_compliance(motion).couplings) for motion in motions}
        assert found == {k: ({("rx", "rz"), ("rz", "rx")} if coupled and k == 3 else set()) for k in range(1, 7)}


def test_hidden_bodies_are_left_out() -> None:
    states = tracked(20e-6)
    position, rotation = states.position.copy(), states.rotation.copy()
    position[10:20, 2], rotation[10:20, 2] = np.nan, np.nan
    hidden = joint_motions(replace(states, position=position, rotation=rotation), six_axes())
    observed = [int(np.isfinite(motion.displacement[:, 0]).sum()) for motion in hidden]
    n = len(states)
    assert observed == [n, n, n, n - 10, n - 10, n]
    position[0], rotation[0] = np.nan, np.nan  # nothing seen in the reference: the next least load takes its place
    again = joint_motions(replace(states, position=position, rotation=rotation), six_axes())
    assert np.allclose(
        [joint_compliance(motion).lines[5].compliance for motion in again],
        [joint_compliance(motion).lines[5].compliance for motion in joint_motions(states, six_axes())],
        rtol=0.02,
    )


def test_one_body_alone_shows_no_joint() -> None:
    states = tracked()
    setup = replace(states.setup, targets=states.setup.targets[:1], target_names=("tool",))
    alone = replace(states, setup=setup, position=states.position[:, :1], rotation=states.rotation[:, :1])
    assert joint_motions(alone, six_axes()) == ()
    # links 2 and 4 without a target: joints 2 to 5 have no body on one of their sides
    some = [0, 1, 3, 5]
    setup = replace(
        states.setup, targets=tuple(states.setup.targets[b] for b in some), target_names=("t", "5", "3", "1")
    )
    left = replace(states, setup=setup, position=states.position[:, some], rotation=states.rotation[:, some])
    assert set(measured_joints(left, six_axes())) == {1, 6}


def test_cartesian_stiffness_where_all_is_full() -> None:
    chain = six_axes()
    found = cartesian_stiffnesses(tracked(share=0.02), chain)
    assert len(found) == 4
    states = tracked()
    for one in found:
        run = [info.name for info in states.runs].index(one.run)
        members = np.flatnonzero(states.run == run)
        assert np.allclose(one.stiffness, one.stiffness.T, atol=0.02 * np.abs(one.stiffness).max())
        # without noise both ways are one, but for what a straight line leaves of the finite balance
        assert np.allclose(one.stiffness, one.from_compliance, rtol=0.02, atol=1e-3 * np.abs(one.stiffness).max())
        assert one.n == len(members)
        # and the robot's own, wrench by wrench about the target in base axes
        setup = replace(states.setup, wrench_axes=Attachment(0, np.eye(4)), wrench_point=states.setup.targets[0])
        joints = chain.model_angles(np.repeat(states.joints[members[:1]], 6, axis=0))
        moved = solve_balance(robot(), joints, np.eye(6), setup).displacement[:, 0]
        assert np.allclose(one.compliance, moved.T, atol=0.01 * np.sqrt(np.outer(np.diag(moved), np.diag(moved))).max())
        assert np.allclose(np.diag(one.compliance), np.diag(moved), rtol=0.01)
    # in this noise (120 µrad) the stiffest directions of all four are lost: no pose is full
    assert cartesian_stiffnesses(tracked(noise=30e-6), chain) == ()
    noisy = cartesian_stiffnesses(tracked(noise=3e-6), chain)
    assert {"pose1", "pose4"} <= {one.run for one in noisy}
    by_run = {one.run: one for one in found}
    for one in noisy:
        exact = by_run[one.run]
        true = np.diag(exact.stiffness)
        # noise in the displacement draws eq. 15 down, and leaves the compliance's way as it is
        assert np.min(np.diag(one.stiffness) / true) < 0.9
        assert np.allclose(np.diag(one.compliance), np.diag(exact.compliance), rtol=0.1)


def test_states_without_a_coordinate_are_left_out_of_the_cartesian_stiffness() -> None:
    """A table may lack a single cell of a pose; and a robot that never moves has no stiffness."""
    states, chain = tracked(share=0.02), six_axes()
    position = states.position.copy()
    position[5, 0, 0] = np.nan
    run = states.runs[states.run[5]].name
    whole, lacking = (
        {one.run: one.n for one in cartesian_stiffnesses(given, chain)}
        for given in (states, replace(states, position=position))
    )
    assert lacking == {**whole, run: whole[run] - 1}
    still = replace(
        states, position=np.zeros_like(position), rotation=np.broadcast_to(np.eye(3), states.rotation.shape).copy()
    )
    assert cartesian_stiffnesses(still, chain) == ()


def test_forces_alone_are_not_full() -> None:
    states = tracked()
    wrench = states.wrench.copy()
    wrench[:, 3:] = 0.0
    assert cartesian_stiffnesses(replace(states, wrench=wrench), six_axes()) == ()
    wrench = np.vstack([np.eye(6), -np.eye(6)])
    assert np.allclose(stiffness_by_equation_15(wrench @ np.diag([1.0, 2, 3, 4, 5, 6]), wrench)[2, 2], 1 / 3)
