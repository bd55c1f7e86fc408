"""The C code by `CompensationStep`, the exact balance, and compilers that take every warning for an error."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.compensation.exports.c_code import c_source
from stiffcal.compensation.exports.controller_model import controller_model
from stiffcal.compensation.exports.step import CompensationStep, StepSettings
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from tests.compensation.test_step import every_law, everything_linear, runs, samples, springs_36
from tests.compensation.test_targets import drives
from tests.laboratory.compilers import SANITIZED, STRICT, build, compiler
from tests.laboratory.hostile_names import NAMES
from tests.laboratory.replay import by_program, by_python, c_program
from tests.laboratory.robots import SEVEN_STIFFNESS, force_sensor_setup, seven_axes, six_axis_joints
from tests.laboratory.track_and_arm import SCARA, TRACK, draw_joints, robot_of

ACCURACY = 1e-10
"""rad, m: the same sums in another order. Rounding of 1e-16 of some metres, times the solver's condition of 1e5."""
PEER_PRODUCTS = 24
"""Products of 6 by 6 matrices that take the limit of a call, 3 µs, at 3 GHz: 121 ns each, measured on an idle core."""
TOOL = StepSettings(cutoff_hz=40.0, tool_mass=5.0, tool_com=(0.01, -0.02, 0.1), zeroed_at=np.full(6, 0.3))


def setup_of(robot: CompliantRobot) -> MeasurementSetup:
    return force_sensor_setup(robot.chain, 10.0, (0.0, 0.01, 0.1))


def path(n: int, joints: int = 6) -> tuple[Floats, Floats]:
    """Return a motion through the workspace with loads of many turning points and a sensor's noise."""
    rng = np.random.default_rng(8)
    time = np.linspace(0.0, 1.0, n)[:, None]
    centre = six_axis_joints(rng, 1)[0] if joints == 6 else rng.uniform(-0.5, 0.5, joints)
    angles = centre + 0.4 * np.sin(time * rng.uniform(5.0, 40.0, joints) + rng.uniform(0.0, 6.0, joints))
    waves = np.sin(time * rng.uniform(20.0, 300.0, 6)) * np.repeat([300.0, 40.0], 3)
    return angles, waves + rng.normal(size=(n, 6)) * np.repeat([5.0, 0.5], 3)


@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_a_replay_with_every_law(name: str, tmp_path: Path) -> None:
    """Hysteresis, filter, tool's weight, memory, under both sanitizers; 10 000 steps take no more branches."""
    robot = every_law()
    setup = setup_of(robot)
    program = c_program(controller_model(robot, setup, TOOL), tmp_path / "code", *SANITIZED, compiler=name)
    joints, reading = path(2000)
    ours = by_program(program, joints, reading, alone=False)
    theirs = by_python(CompensationStep(robot, setup, TOOL), joints, reading, alone=False)
    assert ours.solved.all()
    assert np.abs(ours.offsets - theirs.offsets).max() < ACCURACY
    assert np.abs(ours.deflection - theirs.deflection).max() < ACCURACY
    np.testing.assert_allclose(ours.wrench, theirs.wrench, atol=1e-9)
    assert np.abs(theirs.offsets).max() > 1e-3
    still = by_program(program, joints, reading, alone=True)
    assert np.abs(ours.deflection - still.deflection).max() > 1e-5  # the memory is in the replay


@pytest.mark.parametrize("make", [springs_36, everything_linear, every_law])
def test_states_each_by_itself(make: object, tmp_path: Path) -> None:
    """Loads of both signs, small and large; 10 000 states take no more branches."""
    robot: CompliantRobot = make()  # type: ignore[operator]
    setup = setup_of(robot)
    program = c_program(controller_model(robot, setup), tmp_path / "code", *SANITIZED)
    joints, reading = samples(robot, setup, 400)
    joints, reading = np.tile(joints, (4, 1)), np.concatenate([reading, -reading, 0.3 * reading, 2.0 * reading])
    ours = by_program(program, joints, reading, alone=True)
    theirs = by_python(CompensationStep(robot, setup), joints, reading, alone=True)
    assert len(ours.offsets) == 1600
    assert np.abs(ours.offsets - theirs.offsets).max() < ACCURACY
    some = slice(0, 400)
    exact = solve_balance(
        robot, robot.chain.model_angles(joints[some]), reading[some], setup, runs(np.arange(400))
    ).displacement[:, 0]
    miss = np.abs(ours.deflection[some] - exact).max()
    assert miss < np.abs(theirs.deflection[some] - exact).max() + ACCURACY
    assert miss < 2e-3 * np.abs(exact).max()


def test_seven_joints_first_order_and_frames_on_other_bodies(tmp_path: Path) -> None:
    chain = seven_axes()
    limits = np.tile([-2.0, 2.0], (7, 1))
    robot = replace(drives(replace(chain, limits=limits), SEVEN_STIFFNESS), deformed=False)
    there = np.eye(4)
    there[:3, 3] = [0.1, 0.05, 0.1]
    setup = replace(
        setup_of(robot),
        targets=(Attachment(6, there),),
        wrench_axes=Attachment(0, np.eye(4)),
        wrench_point=Attachment(8, there),
        moments_measured=False,
    )
    settings = StepSettings(sweeps=2, largest_correction=2e-4)
    program = c_program(controller_model(robot, setup, settings), tmp_path / "code", *SANITIZED)
    joints, reading = path(500, 7)
    joints[100:110] = 1.99995  # a limit cuts some offsets off
    ours = by_program(program, joints, reading, alone=False)
    theirs = by_python(CompensationStep(robot, setup, settings), joints, reading, alone=False)
    assert np.abs(ours.offsets - theirs.offsets).max() < ACCURACY
    assert np.abs(np.abs(theirs.offsets).max(axis=1) - 2e-4).min() < 1e-12


def test_what_is_no_number_gives_no_offsets_and_leaves_nothing_behind(tmp_path: Path) -> None:
    robot = every_law()
    setup = setup_of(robot)
    program = c_program(controller_model(robot, setup, TOOL), tmp_path / "code", *SANITIZED)
    joints, reading = path(40)
    joints[10, 2], reading[20, 4], reading[30, 0] = np.nan, np.inf, 1e200
    ours = by_program(program, joints, reading, alone=False)
    with np.errstate(all="ignore"):
        theirs = by_python(CompensationStep(robot, setup, TOOL), joints, reading, alone=False)
    assert np.flatnonzero(~ours.solved).tolist() == np.flatnonzero(~theirs.solved).tolist() == [10, 20, 30]
    assert not ours.offsets[~ours.solved].any()
    assert np.abs(ours.offsets - theirs.offsets).max() < ACCURACY


def test_a_call_takes_less_than_three_microseconds_at_three_gigahertz(tmp_path: Path) -> None:
    """Six joints, 36 springs, filter, tool's weight; products timed in turn with the calls; best of three medians."""
    robot = springs_36()
    flags = ("-O2", "-DTIMED", f"-DPEER_PRODUCTS={PEER_PRODUCTS}")
    program = c_program(controller_model(robot, setup_of(robot), TOOL), tmp_path / "code", *flags)
    joints, reading = path(20_000)
    medians = np.array([by_program(program, joints, reading, alone=False).words.split() for _ in range(3)], float)
    assert (medians[:, 0] / medians[:, 1]).min() < 1.0


@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_names_stay_in_their_comments(name: str, tmp_path: Path) -> None:
    """Hostile names in the head and as joints: the same instructions as with plain names, and no warning."""
    compiler(name)
    robot = springs_36()
    hostile = [*NAMES.values(), "*/ int main(void) { return 7; } /*", "??/", "end \\", "//", "*", "*/"]
    plain = controller_model(robot, setup_of(robot))
    for number, names in enumerate([tuple(hostile[k : k + 6]) for k in range(0, len(hostile) - 5, 6)]):
        source, header = c_source(replace(plain, joint_names=names), hostile, "compensation")
        folder = tmp_path / f"{number}"
        folder.mkdir()
        (folder / "compensation.c").write_text(source, encoding="ascii")
        (folder / "compensation.h").write_text(header, encoding="ascii")
        build(name, folder / "one.o", [folder / "compensation.c"], *STRICT, "-c", f"-I{folder}")
        code = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
        bare, _ = c_source(plain, ("",), "compensation")
        other = re.sub(r"/\*.*?\*/", "", bare, flags=re.DOTALL)
        assert code.replace(replace(plain, joint_names=names).hash, "") == other.replace(plain.hash, "")


def test_the_hash_follows_every_number(tmp_path: Path) -> None:
    robot = springs_36()
    model = controller_model(robot, setup_of(robot))
    program = c_program(model, tmp_path / "code", *STRICT)
    joints, reading = path(1)
    assert by_program(program, joints, reading, alone=True).words.strip() == model.hash
    assert model.hash == controller_model(robot, setup_of(robot)).hash
    mass = model.mass.copy()
    mass[0] = np.nextafter(mass[0], np.inf)
    assert replace(model, mass=mass).hash != model.hash
    assert replace(model, sweeps=2).hash != model.hash


@pytest.mark.parametrize("name", ["track", "scara"])
def test_prismatic_joints(name: str, tmp_path: Path) -> None:
    """A track with its arm and a quill: the code by `CompensationStep`, and both by the exact balance."""
    chain = chain_of(robot_of({"track": TRACK, "scara": SCARA}[name]), tmp_path)
    springs = np.where(chain.prismatic, 2e7, 4e5)
    robot = drives(chain, springs)
    setup = setup_of(robot)
    program = c_program(controller_model(robot, setup), tmp_path / "code", *SANITIZED)
    joints = draw_joints(chain, 300, seed=3)
    reading = path(300)[1]
    ours = by_program(program, joints, reading, alone=True)
    theirs = by_python(CompensationStep(robot, setup), joints, reading, alone=True)
    assert ours.solved.all()
    assert np.abs(ours.offsets - theirs.offsets).max() < ACCURACY
    assert np.abs(ours.deflection - theirs.deflection).max() < ACCURACY
    assert np.abs(ours.offsets[:, chain.prismatic]).max() > 1e-6
    exact = solve_balance(robot, chain.model_angles(joints), reading, setup).displacement[:, 0]
    assert np.abs(ours.deflection - exact).max() < 2e-3 * np.abs(exact).max()
