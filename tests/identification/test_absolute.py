"""Absolute places: columns against differences and pinocchio, which numbers are kept, and what a fit of them gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.effects.joint_offset import JointOffset
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.gauge import redundant_geometry
from stiffcal.identification.fitting.geometry import with_geometry
from stiffcal.identification.fitting.identify import identify_parameters, predict_observations
from stiffcal.measurements.load_states import TrackerPlace
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector, transform
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.assembled.measured_frames import placed_frame
from stiffcal.model.balance.equilibrium import solve_balance
from tests.laboratory.absolute_places import SIGMA, TARGET, absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, seven_axes, six_axes

FRAMES = (placed_frame("tracker", True), placed_frame(TARGET, False))
SPRINGS = [{"c": 1.0 / float(k)} for k in SIX_STIFFNESS]


def with_frames(chain: Chain, *placed: PlacedEffect) -> CompliantRobot:
    return CompliantRobot(chain, (*FRAMES, *placed))


def geometry(seed: int, size: float = 1.0) -> list[dict[str, float]]:
    """Return assembly's errors of six joints: 0.3 mm, 0.5 mrad."""
    rng = np.random.default_rng(seed)
    spread = size * np.array([3e-4, 3e-4, 5e-4, 5e-4])
    return [dict(zip(("x", "y", "rx", "ry"), spread * rng.normal(size=4), strict=True)) for _ in range(6)]


def rigid_everything(chain: Chain) -> CompliantRobot:
    eccentric = on_all_joints(JointEccentricity(), 6, [{"order": 2.0}] * 6)
    return with_frames(
        chain, *on_all_joints(LinkGeometry(), 6), *on_all_joints(JointOffset(), 6), *eccentric
    )  # fmt: skip


def relative_error(robot: CompliantRobot, chain: Chain) -> dict[str, float]:
    """Return full name to how far each column is from a central difference of the prediction, of its size."""
    data = observe(absolute_states(chain, 12, 4), chain)
    columns = free_columns(robot)
    found = np.concatenate([block.columns for block in evaluate(robot, data, columns)], axis=2)
    errors, values = {}, robot.values()
    for column, row in zip(columns, found, strict=True):
        name = robot.placed[column.placed].parameter_name(column.symbol)
        at, step = values.get(name, 0.0), 1e-5
        ends = [predict_observations(robot.with_values({name: at + sign * step}), data) for sign in (1.0, -1.0)]
        exact = (ends[0] - ends[1]) / (2.0 * step)
        errors[name] = float(np.linalg.norm(row - exact) / np.linalg.norm(exact))
    return errors


def test_columns_of_the_undeformed_robot_are_the_slope_of_its_places() -> None:
    chain = six_axes()
    rigid = replace(chain, bearing=np.array([0.1, -0.05, 0.0, 0.2, 0.0, 0.03]))
    coupled = np.diag([1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
    coupled[2, 1] = 1.0
    for robot_chain in (chain, rigid, replace(chain, coupling=coupled)):
        # a forward difference of 1 µm or 1 µrad makes half of it times the curvature
        assert max(relative_error(rigid_everything(robot_chain), robot_chain).values()) < 2e-6


def test_points_of_the_robot_itself_stay_where_they_are_whatever_the_measured_frames() -> None:
    """A page draws the joints of a fitted robot: no target and no tracker is among these points."""
    chain = six_axes()
    moved = {"frame.tracker.x": 1e-3, f"frame.{TARGET}.z": 1e-3}
    setup = force_sensor_setup(chain)
    angles = chain.model_angles(np.radians([[0.0, -70.0, 20.0, 0.0, 30.0, 0.0]]))
    wrench = np.array([[100.0, 0.0, -300.0, 0.0, 0.0, 0.0]])
    robot = with_frames(chain, *on_all_joints(JointCompliance(), 6, SPRINGS))
    plain, other = (solve_balance(each, angles, wrench, setup) for each in (robot, robot.with_values(moved)))
    np.testing.assert_array_equal(other.displacement, plain.displacement)


def test_away_from_the_nominal_robot_they_are_directions_of_a_step() -> None:
    chain = six_axes()
    robot = with_frames(chain, *on_all_joints(LinkGeometry(), 6, geometry(1, 3.0)))
    robot = robot.with_values({"frame.tracker.rx": 2e-3, "frame.tracker.x": 1e-3, f"frame.{TARGET}.y": 1e-3})
    # turns of 1.5 mrad between the frames that a column is written in, at ten times the wrist's lever
    assert max(relative_error(robot, chain).values()) < 0.05


def test_a_place_is_the_tracker_times_the_changed_chain() -> None:
    """Frames and geometry against products of matrices, at finite values."""
    pin = pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")
    from tests.laboratory.pinocchio_robot import pinocchio_model

    chain, values = six_axes(), geometry(2, 5.0)
    states = absolute_states(chain, 20, 5)
    tracker, target = np.array([1e-3, -2e-3, 5e-4, 2e-3, -1e-3, 3e-3]), np.array([1e-3, 2e-3, -1e-3])
    names = {f"frame.tracker.{s}": v for s, v in zip(("x", "y", "z", "rx", "ry", "rz"), tracker, strict=True)}
    names |= {f"frame.{TARGET}.{s}": v for s, v in zip("xyz", target, strict=True)}
    there = transform(rotation_from_vector(np.array([0.1, 0.2, 2.0])), np.array([3.0, -1.0, 0.4]))
    setup = replace(states.setup, trackers=(TrackerPlace("tracker", there),))
    states = replace(states, setup=setup)
    robot = with_frames(chain, *on_all_joints(LinkGeometry(), 6, values)).with_values(names)
    data = observe(states, chain)

    fixed = []
    for nominal, own in zip(chain.fixed, values, strict=True):
        shift = np.eye(4)
        shift[:2, 3] = own["x"], own["y"]
        shift[:3, :3] = rotation_from_vector(np.array([own["rx"], own["ry"], 0.0]))
        fixed.append(nominal @ shift)
    model = pinocchio_model(replace(chain, fixed=np.array(fixed)))
    registered = there
    true = np.eye(4)
    true[:3, :3] = rotation_from_vector(tracker[3:]) @ registered[:3, :3]
    true[:3, 3] = registered[:3, 3] + tracker[:3]
    place = setup.targets[0].transform[:3, 3] + target
    expected = []
    for q in chain.model_angles(states.joints):
        motion = model.createData()
        pin.forwardKinematics(model, motion, q)
        in_base = motion.oMi[6].homogeneous @ chain.flange @ np.append(place, 1.0)
        in_tracker = np.linalg.solve(true, in_base)
        expected.append((registered @ in_tracker)[:3])
    nominal_places = -data.measured.T  # measured places are zero
    np.testing.assert_allclose(predict_observations(robot, data).T + nominal_places, expected, atol=1e-12)


def test_four_numbers_per_joint_and_the_targets_are_kept() -> None:
    """4 n + 3 for a target of one place, the tracker included; the rest moves with the others in every pose."""
    for chain in (six_axes(), seven_axes()):
        n = chain.n_joints
        robot = with_frames(chain, *on_all_joints(LinkGeometry(), n))
        states = absolute_states(six_axes(), 4, 1)
        states = replace(states, joints=np.zeros((4, n)), setup=absolute_states(chain, 1, 1).setup)
        redundant = redundant_geometry(robot, observe(states, chain), frozenset())
        assert redundant == {
            "frame.tracker.z",
            "frame.tracker.rz",
            *(f"link-geometry.j1.{s}" for s in ("x", "y", "rx", "ry")),
        }


def test_a_measured_pose_keeps_four_numbers_per_joint_and_six() -> None:
    chain = six_axes()
    frames = (placed_frame("tracker", True), placed_frame(TARGET, True))
    states = absolute_states(chain, 4, 1)
    states = replace(states, rotation=np.tile(np.eye(3), (4, 1, 1, 1)))
    robot = CompliantRobot(chain, (*frames, *on_all_joints(LinkGeometry(), 6)))
    kept = 12 + 24 - len(redundant_geometry(robot, observe(states, chain), frozenset()))
    assert kept == 4 * 6 + 6


def test_zeros_of_the_first_and_the_last_joint_belong_to_the_frames() -> None:
    chain = six_axes()
    robot = with_frames(chain, *on_all_joints(JointOffset(), 6))
    redundant = redundant_geometry(robot, observe(absolute_states(chain, 4, 1), chain), frozenset())
    assert {"joint-offset.j6.zero"} <= redundant
    assert {"joint-offset.j1.zero"} <= redundant or {"frame.tracker.rz"} <= redundant
    assert not {f"joint-offset.j{k}.zero" for k in (2, 3, 4, 5)} & redundant


def test_a_given_tracker_keeps_joint_one() -> None:
    chain = six_axes()
    robot = CompliantRobot(chain, (FRAMES[1], *on_all_joints(LinkGeometry(), 6)))
    assert not redundant_geometry(robot, observe(absolute_states(chain, 4, 1), chain), frozenset())


def test_a_fit_finds_geometry_and_springs_within_their_uncertainty() -> None:
    chain = six_axes()
    weights = np.zeros((60, 6))
    weights[30:, 2] = -400.0
    truth = with_frames(
        chain, *on_all_joints(LinkGeometry(), 6, [{}, *geometry(7)[1:]]), *on_all_joints(JointCompliance(), 6, SPRINGS)
    ).with_values({"frame.tracker.x": 5e-4, "frame.tracker.ry": 1e-3, f"frame.{TARGET}.z": -4e-4})
    states = measured_by(truth, absolute_states(chain, 60, 8, wrench=weights), 9)
    blank = with_frames(chain, *on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6))
    fit = identify_parameters(states, blank)
    assert fit.last_step is None
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / fit.dof))
    true, found = truth.values(), fit.robot.values()
    away = np.array([found[name] - true.get(name, 0.0) for name in fit.free_names])
    chi2 = float(away @ np.linalg.solve(fit.covariance, away))
    assert chi2 < len(away) + 4.0 * np.sqrt(2.0 * len(away))
    assert fit.noise is not None
    assert fit.noise.translation == SIGMA
    # the geometry is measured by the same places: no tolerance of it is added
    assert with_geometry(fit, states).parameters == fit.parameters


def test_poses_that_hardly_turn_a_joint_leave_its_geometry_open() -> None:
    chain = six_axes()
    states = absolute_states(chain, 40, 8)
    joints = states.joints.copy()
    joints[:, 4] = joints[0, 4] + 1e-3 * joints[:, 4]
    truth = with_frames(chain, *on_all_joints(LinkGeometry(), 6, geometry(7, 0.1)))
    states = measured_by(truth, replace(states, joints=joints), 9)
    fit = identify_parameters(states, with_frames(chain, *on_all_joints(LinkGeometry(), 6)))
    redundant = redundant_geometry(truth, fit.data, frozenset())
    unknown = {parameter.name for parameter in fit.parameters if parameter.value is None} - redundant
    assert unknown
    for parameter in fit.parameters:
        if parameter.value is not None and parameter.std is not None and parameter.effect == "link-geometry":
            assert parameter.spec.tolerance is not None
            assert parameter.std <= parameter.spec.tolerance


def test_first_order_and_balanced_robots_agree_where_springs_are_stiff() -> None:
    chain = six_axes()
    robot = with_frames(
        chain, *on_all_joints(LinkGeometry(), 6, geometry(3)),
        *on_all_joints(JointCompliance(), 6, [{"c": own["c"] * 1e-3} for own in SPRINGS]),
    )  # fmt: skip
    data = observe(absolute_states(chain, 10, 2), chain)
    balanced, linear = (predict_observations(replace(robot, deformed=deformed), data) for deformed in (True, False))
    np.testing.assert_allclose(balanced, linear, atol=1e-8)


def test_columns_of_the_geometry_are_central_differences_of_pinocchios_frames() -> None:
    """To 1e-7 of each column: what steps of 0.1 mm and 0.1 mrad leave of third order is 2e-9, rounding 1e-11."""
    pin = pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")
    from tests.laboratory.pinocchio_robot import pinocchio_model

    chain, step = six_axes(), 1e-4
    states = absolute_states(chain, 12, 4)
    robot = CompliantRobot(chain, tuple(on_all_joints(LinkGeometry(), 6)))
    columns = free_columns(robot)
    found = np.concatenate([block.columns for block in evaluate(robot, observe(states, chain), columns)], axis=2)
    offset = pin.SE3(chain.flange) * pin.SE3(states.setup.targets[0].transform)

    def places(joint: int, symbol: str, size: float) -> np.ndarray:
        shift = np.eye(4)
        if symbol in "xy":
            shift["xy".index(symbol), 3] = size
        else:
            shift[:3, :3] = rotation_from_vector(size * np.eye(3)["xy".index(symbol[1])])
        fixed = chain.fixed.copy()
        fixed[joint - 1] = fixed[joint - 1] @ shift
        model = pinocchio_model(replace(chain, fixed=fixed))
        memory, rows = model.createData(), []
        for angles in chain.model_angles(states.joints):
            pin.forwardKinematics(model, memory, angles)
            rows.append((memory.oMi[6] * offset).translation)
        return np.array(rows).T

    for column, row in zip(columns, found, strict=True):
        joint = robot.placed[column.placed].place.joints[0]
        slope = (places(joint, column.symbol, step) - places(joint, column.symbol, -step)) / (2.0 * step)
        assert np.linalg.norm(row - slope) < 1e-7 * np.linalg.norm(slope)
