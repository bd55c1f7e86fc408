"""The step function: against the solved correction, its memory, its filter, and what it refuses."""

from __future__ import annotations

import tracemalloc
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats, Integers
from stiffcal.compensation.exports.step import CompensationStep, StepSettings
from stiffcal.compensation.targets import correct_joints
from stiffcal.compensation.tool_weight import weight_on_sensor
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import BeamFrame, Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place, StateOrder, Values
from stiffcal.model.forms import form_of
from stiffcal.model.scalar_laws import ScalarLaw
from tests.compensation.test_targets import drives, regular
from tests.laboratory.robots import (
    SEVEN_STIFFNESS,
    SIX_STIFFNESS,
    force_sensor_setup,
    seven_axes,
    shifted,
    six_axes,
    six_axis_joints,
)

EFFECTS = find_effects()


def placed(name: str, place: Place, values: dict[str, float]) -> PlacedEffect:
    return PlacedEffect(EFFECTS[name], place, values)


def springs_36() -> CompliantRobot:
    """Return paper 001's model: three rotations and three translations at each of six joints."""
    robot = drives(six_axes(), SIX_STIFFNESS)
    more = []
    for k in range(1, 7):
        joint = Place("joints", (k,))
        more.append(placed("bearing-tilt", joint, {"x": 2e-7, "y": 3e-7}))
        more.append(placed("joint-translation", joint, {"tx": 1e-8, "ty": 5e-9, "tz": 4e-9}))
    return replace(robot, placed=(*robot.placed, *more))


def everything_linear() -> CompliantRobot:
    """Return a robot with base, tool, beams, coupled drives and shifted bearings."""
    coupling = np.eye(6)
    coupling[2, 1] = -1.0
    beam = BeamFrame(2, shifted(0.89, 0.0, 0.0), 0.89)
    chain = replace(
        six_axes(),
        coupling=coupling,
        mechanical=np.arange(6) == 2,
        bearing=np.array([0.1, -0.05, 0.02, 0.3, 0.0, 0.04]),
        beams={"swing": beam},
    )
    setup = Place("setup")
    give = {"rx": 1e-7, "ry": 2e-7, "rz": 1e-7, "tx": 1e-8, "ty": 1e-8, "tz": 5e-9}
    more = (
        placed("bearing-tilt", Place("joints", (2,)), {"x": 4e-7, "y": 2e-7}),
        placed("axis-coupling", Place("pairs", (5, 6)), {"c": 3e-6}),
        placed("link-beam", Place("links", (), "swing"), {"EI2": 2e6, "EI3": 3e6, "GJ": 1e6, "EA": 1e9}),
        placed("base-compliance", setup, give),
        placed("tool-compliance", setup, give),
    )
    robot = drives(chain, SIX_STIFFNESS)
    return replace(robot, placed=(*robot.placed, *more))


def every_law() -> CompliantRobot:
    """Return 36 springs and every law that is not proportional to its load, and a balancing spring."""
    robot = springs_36()
    spring = {"joint": 2, "anchor_m": [0.2, 0.1, 0.5], "arm_m": [0.15, 0.3, 0.0], "rate_N_m": 4e4, "preload_N": 3000.0}
    laws = {
        "backlash": (4, {"width": 4e-4, "band": 12.0}),
        "two-slope": (3, {"c": 4e-7, "knee": 150.0}),
        "friction-hysteresis": (2, {"c": 6e-7, "slip": 120.0}),
        "asymmetric-stiffness": (1, {"c": 3e-7}),
        "periodic-stiffness": (5, {"a": 1e-6, "b": -2e-6, "order": 3.0}),
        "cubic-stiffness": (6, {"c2": 1e-8, "c3": -3e-11}),
        "gravity-compensator": (2, {"rate": 3.5e4}),
    }
    more = [placed(name, Place("joints", (joint,)), values) for name, (joint, values) in laws.items()]
    more.append(placed("friction-hysteresis", Place("joints", (5,)), {"c": 5e-6, "slip": 9.0}))
    curved = form_of(EFFECTS["bearing-tilt"], ("x2",))
    more.append(PlacedEffect(curved, Place("joints", (3,)), {"x": 1e-7, "x2": 2e-11, "x3": 1e-14, "y": 1e-7}))
    over_angle = form_of(EFFECTS["cubic-stiffness"], ("p1",))
    torque = {"p1": 8e5, "p2": -4e7, "p3": 9e9}
    more.append(PlacedEffect(over_angle, Place("joints", (2,)), torque))
    return replace(robot, chain=replace(robot.chain, compensator=spring), placed=(*robot.placed, *more))


def runs(run: Integers) -> StateOrder:
    """Return the order of states (n,) without times: before a run's first state weight alone has acted."""
    unknown = np.full(len(run), np.nan)
    return StateOrder(run, unknown, unknown, np.zeros((6, len(run))), unknown, unknown)


def samples(robot: CompliantRobot, setup: MeasurementSetup, n: int = 30) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(4)
    joints = regular(robot.chain, six_axis_joints(rng, 4 * n), setup)[:n]
    return joints, rng.normal(size=(n, 6)) * np.repeat([250.0, 30.0], 3)


@pytest.mark.parametrize("make", [springs_36, everything_linear])
def test_a_first_call_is_the_balance(make: object) -> None:
    robot: CompliantRobot = make()  # type: ignore[operator]
    setup = force_sensor_setup(robot.chain, 10.0, (0.0, 0.01, 0.1))
    joints, wrench = samples(robot, setup)
    exact = correct_joints(robot, joints, wrench, setup)
    step = CompensationStep(robot, setup)
    seen = []
    for q, w in zip(joints, wrench, strict=True):
        step.reset()
        seen.append([*step(q, w), *step.deflection])
    found = np.array(seen)
    size = np.linalg.norm(exact.deflection, axis=1)
    assert np.all(np.linalg.norm(found[:, 6:] - exact.deflection, axis=1) < 1e-4 * size)
    loaded = solve_balance(robot, robot.chain.model_angles(joints + found[:, :6]), wrench, setup)
    unloaded = solve_balance(robot, robot.chain.model_angles(joints), wrench, setup).unloaded_position
    left = np.linalg.norm(loaded.target_position - unloaded, axis=2)[:, 0]
    assert np.all(left < 0.05 * np.linalg.norm(exact.deflection[:, :3], axis=1))


@pytest.mark.parametrize("deformed", [True, False])
@pytest.mark.parametrize(("target", "load"), [(7, 5), (4, 7), (3, 5)])
def test_load_and_target_on_other_bodies(target: int, load: int, deformed: bool) -> None:
    """What is kept in place, and where the force is read, may be a link; the papers' first-order form is exact."""
    robot = replace(everything_linear(), deformed=deformed)
    there = np.eye(4)
    there[:3, 3] = [0.1, 0.05, 0.1]
    on = {body: Attachment(body, there) for body in (target, load)}
    setup = force_sensor_setup(robot.chain, 10.0, (0.0, 0.01, 0.1))
    joints, wrench = samples(robot, setup, 8)
    setup = replace(setup, targets=(on[target],), wrench_axes=on[load], wrench_point=on[load])
    exact = solve_balance(robot, robot.chain.model_angles(joints), wrench, setup).displacement[:, 0]
    step = CompensationStep(robot, setup)
    for q, w, moved in zip(joints, wrench, exact, strict=True):
        step.reset()
        step(q, w)
        assert np.linalg.norm(step.deflection - moved) < (1e-4 if deformed else 1e-12) * np.linalg.norm(moved)


@pytest.mark.parametrize("make", [springs_36, everything_linear])
def test_a_loop_keeps_to_the_balance(make: object) -> None:
    """A second of motion and a changing load at 4 ms: each call goes on from the shape of the one before."""
    robot: CompliantRobot = make()  # type: ignore[operator]
    setup = force_sensor_setup(robot.chain, 10.0, (0.0, 0.01, 0.1))
    ends, loads = samples(robot, setup, 2)
    share = np.linspace(0.0, 1.0, 250)[:, None]
    joints = ends[0] + 0.2 * share * (ends[1] - ends[0])
    wrench = loads[0] + np.sin(6.0 * share) * loads[1]
    exact = solve_balance(robot, robot.chain.model_angles(joints), wrench, setup).displacement[:, 0]
    step = CompensationStep(robot, setup)
    found = []
    for q, w in zip(joints, wrench, strict=True):
        step(q, w)
        found.append(step.deflection.copy())
    size = np.linalg.norm(exact, axis=1).max()
    assert np.linalg.norm(np.array(found) - exact, axis=1).max() < 5e-4 * size
    # a blow: the load there at once, within a per cent in the first cycle, nearly all in the second
    blow = 2.0 * wrench[-1]
    moved = solve_balance(robot, robot.chain.model_angles(joints[-1:]), blow[None], setup).displacement[0, 0]
    step(joints[-1], blow)
    assert np.linalg.norm(step.deflection - moved) < 1e-2 * np.linalg.norm(moved)
    step(joints[-1], blow)
    assert np.linalg.norm(step.deflection - moved) < 5e-4 * np.linalg.norm(moved)


def test_seven_joints_by_least_motion() -> None:
    rng = np.random.default_rng(5)
    chain = seven_axes()
    robot, setup = drives(chain, SEVEN_STIFFNESS), force_sensor_setup(chain, 2.0)
    joints, wrench = rng.uniform(-1.2, 1.2, (20, 7)), rng.normal(size=(20, 6)) * np.repeat([40.0, 5.0], 3)
    exact = correct_joints(robot, joints, wrench, setup)
    step = CompensationStep(robot, setup, StepSettings(sweeps=3))
    offsets = np.array([step(q, w).copy() for q, w in zip(joints, wrench, strict=True)])
    assert np.allclose(offsets, exact.joints - joints, atol=0.05 * np.abs(exact.joints - joints).max())


def test_no_call_allocates() -> None:
    """Nothing is kept; numbers that Python makes on the way are less than a kilobyte, given back within the call."""
    robot = springs_36()
    setup = force_sensor_setup(robot.chain, 10.0, (0.0, 0.01, 0.1))
    joints, wrench = (np.ascontiguousarray(one[0]) for one in samples(robot, setup, 1))
    step = CompensationStep(robot, setup, StepSettings(cutoff_hz=20.0, tool_mass=5.0))
    tracemalloc.start()
    try:
        for _ in range(200):
            step(joints, wrench)
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        for _ in range(500):
            step(joints, wrench)
        after, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 200
    assert peak - before < 1000


def test_what_is_returned_is_one_array() -> None:
    robot = springs_36()
    setup = force_sensor_setup(robot.chain)
    joints, wrench = samples(robot, setup, 2)
    step = CompensationStep(robot, setup)
    assert step(joints[0], wrench[0]) is step(joints[1], wrench[1]) is step.offsets


def test_the_tools_weight_is_taken_out() -> None:
    robot = springs_36()
    chain = robot.chain
    setup = force_sensor_setup(chain, 10.0)
    joints, wrench = samples(robot, setup, 2)
    com = (0.02, -0.01, 0.15)
    hung = weight_on_sensor(chain, chain.model_angles(joints), setup.wrench_axes, 7.0, np.array(com))
    plain = CompensationStep(robot, setup)
    never = CompensationStep(robot, setup, StepSettings(tool_mass=7.0, tool_com=com))
    assert np.allclose(never(joints[1], wrench[1] + hung[1]), plain(joints[1], wrench[1]), atol=1e-12)
    settings = StepSettings(tool_mass=7.0, tool_com=com, zeroed_at=joints[0])
    zeroed = CompensationStep(robot, setup, settings)
    assert np.allclose(zeroed(joints[1], wrench[1] + hung[1] - hung[0]), plain(joints[1], wrench[1]), atol=1e-12)
    assert np.linalg.norm(hung[1, :3]) == pytest.approx(7.0 * 9.81)


def test_weight_on_a_sensor_by_pinocchio() -> None:
    pin = pytest.importorskip("pinocchio")
    chain = six_axes()
    setup = force_sensor_setup(chain)
    angles = chain.model_angles(six_axis_joints(np.random.default_rng(1), 1))
    from tests.laboratory.pinocchio_robot import pinocchio_model, place_and_jacobian

    com = np.array([0.02, -0.01, 0.15])
    bare, loaded = pinocchio_model(chain), pinocchio_model(chain, 7.0, com)
    torque = pin.computeGeneralizedGravity(loaded, loaded.createData(), angles[0]) - pin.computeGeneralizedGravity(
        bare, bare.createData(), angles[0]
    )
    wrench = weight_on_sensor(chain, angles, setup.wrench_axes, 7.0, com)[0]
    _, rotation, jacobian = place_and_jacobian(bare, chain, angles[0], setup.wrench_axes)
    in_base = np.concatenate([rotation @ wrench[:3], rotation @ wrench[3:]])
    assert np.allclose(jacobian.T @ in_base, -torque, atol=1e-9)


def test_the_filter_settles_on_the_first_sample_and_lags_by_its_delay() -> None:
    robot = springs_36()
    setup = force_sensor_setup(robot.chain)
    joints, wrench = samples(robot, setup, 1)
    step = CompensationStep(robot, setup, StepSettings(cycle_s=0.001, cutoff_hz=10.0))
    first = step(joints[0], wrench[0]).copy()
    assert np.allclose(first, CompensationStep(robot, setup)(joints[0], wrench[0]), atol=1e-12)
    assert np.allclose(step(joints[0], wrench[0]), first, atol=1e-7)
    step(joints[0], 0.0 * wrench[0])
    assert np.linalg.norm(step.wrench) > 0.99 * np.linalg.norm(wrench[0])
    step.reset()
    assert np.allclose(step(joints[0], 0.0 * wrench[0]), 0.0, atol=1e-12)


def test_offsets_stay_within_limits_and_in_proportion() -> None:
    robot = springs_36()
    setup = force_sensor_setup(robot.chain)
    joints, wrench = samples(robot, setup, 1)
    free = CompensationStep(robot, setup)(joints[0], wrench[0]).copy()
    most = 0.4 * float(np.abs(free).max())
    small = CompensationStep(robot, setup, StepSettings(largest_correction=most))(joints[0], wrench[0])
    assert np.allclose(small, 0.4 * free, rtol=1e-9)
    limits = np.tile([-7.0, 7.0], (6, 1))
    limits[1] = [joints[0, 1] - 0.5 * abs(free[1]), joints[0, 1] + 0.5 * abs(free[1])]
    narrow = replace(robot, chain=replace(robot.chain, limits=limits))
    held = CompensationStep(narrow, setup)(joints[0], wrench[0])
    assert abs(held[1]) == pytest.approx(0.5 * abs(free[1]))


def test_a_law_that_is_no_data_is_named() -> None:
    """A user's own effect, nonlinear and without `scalar_laws`."""
    robot = springs_36()

    class OwnGap(type(EFFECTS["backlash"])):  # type: ignore[misc]
        def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
            return ()

    gap = PlacedEffect(OwnGap(), Place("joints", (4,)), {"width": 1e-3, "band": 5.0})
    setup = force_sensor_setup(robot.chain)
    with_gap = replace(robot, placed=(*robot.placed, gap))
    with pytest.raises(ValueError, match="backlash at j4"):
        CompensationStep(with_gap, setup)
    step = CompensationStep(with_gap, setup, StepSettings(leave_out=("backlash",)))
    assert step.left_out == ("backlash.j4",)
    joints, wrench = samples(robot, setup, 1)
    assert np.allclose(step(joints[0], wrench[0]), CompensationStep(robot, setup)(joints[0], wrench[0]), atol=1e-15)


def test_laws_by_the_exact_balance() -> None:
    """Each state by itself: play, knee, curves, periodic stiffness and a balancing spring, weight included."""
    robot, setup = every_law(), force_sensor_setup(six_axes(), 10.0, (0.0, 0.01, 0.1))
    joints, wrench = samples(robot, setup)
    order = runs(np.arange(len(joints)))
    exact = solve_balance(robot, robot.chain.model_angles(joints), wrench, setup, order).displacement[:, 0]
    linear = solve_balance(springs_36(), robot.chain.model_angles(joints), wrench, setup).displacement[:, 0]
    step = CompensationStep(robot, setup, StepSettings(sweeps=12))
    for q, w, moved in zip(joints, wrench, exact, strict=True):
        step.reset()
        for _ in range(2):  # three sweeps, and twelve more with the same load
            step(q, w)
        assert np.linalg.norm(step.deflection - moved) < 5e-4 * np.linalg.norm(moved)
    assert np.all(np.linalg.norm(linear - exact, axis=1) > 0.05 * np.linalg.norm(exact, axis=1))


def test_memory_along_a_path_by_the_exact_balance() -> None:
    """The play operator advances once a call, from where weight alone has left it."""
    robot, setup = every_law(), force_sensor_setup(six_axes(), 10.0, (0.0, 0.01, 0.1))
    joints, wrench = samples(robot, setup, 3)
    n = 120
    share = np.linspace(0.0, 1.0, n)[:, None]
    path = joints[0] + 0.3 * share * (joints[1] - joints[0])
    loads = np.sin(9.0 * share) * wrench[0] + np.cos(14.0 * share) * wrench[1]
    order = runs(np.zeros(n, dtype=np.int64))
    exact = solve_balance(robot, robot.chain.model_angles(path), loads, setup, order).displacement[:, 0]
    alone = solve_balance(robot, robot.chain.model_angles(path), loads, setup).displacement[:, 0]
    step = CompensationStep(robot, setup, StepSettings(sweeps=12))
    found = []
    for q, w in zip(path, loads, strict=True):
        step(q, w)
        found.append(step.deflection.copy())
    size = np.linalg.norm(exact, axis=1).max()
    # as without laws: rotations of the second order are left out
    assert np.abs(np.array(found) - exact).max() < 5e-4 * size
    assert np.abs(alone - exact).max() > 0.005 * size


def test_readings_in_base_axes() -> None:
    robot = springs_36()
    setup = force_sensor_setup(robot.chain)
    in_base = replace(setup, wrench_axes=Attachment(0, np.eye(4)))
    joints, wrench = samples(robot, setup, 3)
    exact = solve_balance(robot, robot.chain.model_angles(joints), wrench, in_base).displacement[:, 0]
    step = CompensationStep(robot, in_base, StepSettings(sweeps=5))
    for q, w, moved in zip(joints, wrench, exact, strict=True):
        step(q, w)
        assert np.allclose(step.deflection, moved, atol=1e-5 * np.linalg.norm(moved))


def test_a_reading_that_is_no_number_gives_no_offsets_and_leaves_nothing_behind() -> None:
    robot = drives(six_axes(), SIX_STIFFNESS)
    setup = force_sensor_setup(robot.chain)
    joints, reading = (np.ascontiguousarray(values[0]) for values in samples(robot, setup, 1))
    step = CompensationStep(robot, setup, StepSettings(cutoff_hz=20.0))
    wanted = step(joints, reading).copy()
    assert step.solved
    assert step(joints, np.full(6, np.nan)).tolist() == [0.0] * 6
    assert not step.solved
    np.testing.assert_allclose(step(joints, reading), wanted, rtol=1e-12)
    assert step.solved
