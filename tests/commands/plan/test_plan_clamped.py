"""`plan` for clamped robots: which joint to drive in which fixture."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.frames.frames import resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.plan import plan_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import HELD
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.information import information_of_runs
from tests.laboratory.clamped_bench import CYCLE, clamped_bench
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

CAMPAIGN = Path(__file__).parents[3] / "campaigns" / "kr125"
PLAN = """schema = "stiffcal/plan-input/1"
experiment = "clamped"
robot_class = "medium"
candidates = 30
runs = 12
[load]
force_N = 600.0
moment_Nm = 60.0
[noise]
motor_angle_rad = 5e-6
force_N = 0.4
moment_Nm = 0.03
"""
FIXTURES = """[[fixtures]]
joints_deg = [0.0, -90.0, 90.0, 0.0, 30.0, 0.0]
[[fixtures]]
joints_deg = [20.0, -60.0, 60.0, 40.0, -50.0, 0.0]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a campaign of a clamped robot without logs."""
    for name in ("campaign.toml", "robot.toml"):
        shutil.copy(CAMPAIGN / name, tmp_path / name)
    return tmp_path


def test_the_expected_uncertainties_are_those_of_the_fit() -> None:
    """Of clamped runs that a bench of its own plays."""
    chain, noise = six_axes(), Noise(0.0, 0.0, 0.0, 0.0, "manifest", np.inf, motor_angle=2e-6)
    poses = np.radians([[0.0, -90.0, 30.0, 20.0, 40.0, 10.0], [30.0, -60.0, 60.0, -50.0, -50.0, 80.0]])
    states = clamped_bench(chain, poses, range(1, 7), np.zeros((6, 6)))
    drive = find_effects()["joint-compliance"]
    placed = [PlacedEffect(drive, Place("joints", (k,)), {"c": 1.0 / SIX_STIFFNESS[k - 1]}) for k in range(1, 7)]
    robot = CompliantRobot(chain, tuple(placed), deformed=False)
    fit = identify_parameters(states, robot, Settings(noise=noise))
    per_run = 2 * len(CYCLE) - 1
    joints = states.joints.reshape(12, per_run, 6)
    wrench = states.wrench.reshape(12, per_run, 6)
    assert HELD in states.setup.target_names
    runs = information_of_runs(
        robot, np.repeat(poses, 6, axis=0), wrench[:, 1:], states.setup, noise, False, kind="clamped",
        turn=joints[:, 1:] - joints[:, :1],
    )  # fmt: skip
    rows = runs.factors.reshape(-1, 6)
    promised = np.sqrt(np.diagonal(np.linalg.inv(rows.T @ rows))) * runs.scale
    np.testing.assert_allclose(promised, np.sqrt(np.diagonal(fit.covariance)), rtol=0.02)


def test_every_joint_is_driven_within_what_the_sensor_bears(folder: Path) -> None:
    (folder / "plan.toml").write_text(PLAN + FIXTURES, encoding="utf-8")
    out = folder / "next"
    plan = plan_campaign(folder, request=PlanRequest(campaign=out))
    assert plan.experiment == "clamped"
    assert {run.moved_joint for run in plan.runs} == {1, 2, 3, 4, 5, 6}
    poses = np.radians([[0, -90, 90, 0, 30, 0], [20, -60, 60, 40, -50, 0]])
    for run in plan.runs:
        assert min(np.abs(run.joints - pose).max() for pose in poses) < 1e-9
        force, moment = (np.linalg.norm(run.wrench[:, part], axis=1).max() for part in (slice(0, 3), slice(3, 6)))
        assert force <= 600.0 + 1e-6
        assert moment <= 60.0 + 1e-6
        assert max(force / 600.0, moment / 60.0) > 0.999 or (run.turn or 0.0) == pytest.approx(0.02)
    assert all(parameter.relative is not None for parameter in plan.parameters)
    made = load_campaign(out, check_files=False)
    assert [(run.experiment, run.moved_joint) for run in made.manifest.runs] == [
        ("clamped", run.moved_joint) for run in plan.runs
    ]


def test_the_wrench_turns_the_driven_joint_against_its_motor(folder: Path) -> None:
    """Work: a fixture that holds a motor back pushes against the way that the motor takes the flange."""
    (folder / "plan.toml").write_text(PLAN, encoding="utf-8")
    plan = plan_campaign(folder)
    campaign = load_campaign(folder, check_files=False)
    chain = campaign.chain
    sensor = resolve_frames(campaign.manifest, chain)["ft_sensor"]
    for run in plan.runs:
        assert run.moved_joint is not None
        ends = np.stack([run.joints, run.joints])
        ends[1, run.moved_joint - 1] += 1e-6
        place, rotation = attached_poses(chain, chain.model_angles(ends), sensor)
        turn = rotation[1] @ rotation[0].T
        way = np.array([*(place[1] - place[0]), turn[2, 1], turn[0, 2], turn[1, 0]])
        first = run.wrench[int(np.argmax(np.linalg.norm(run.wrench, axis=1) > 0.0))]
        assert first @ way < 0.0


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        (PLAN.replace("force_N = 600.0\nmoment_Nm = 60.0\n", ""), FaultCode.KEY_MISSING, "load.force_N"),
        (PLAN.replace("motor_angle_rad = 5e-6\n", ""), FaultCode.KEY_MISSING, "noise.motor_angle_rad"),
        (PLAN + "[[fixtures]]\njoints_deg = [1.0, 2.0]\n", FaultCode.JOINT_COUNT, "fixtures 1"),
    ],
)
def test_a_mistake_is_named(folder: Path, text: str, code: FaultCode, place: str) -> None:
    (folder / "plan.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as raised:
        plan_campaign(folder)
    assert (raised.value.code, raised.value.faults[0].place) == (code, place)


def test_no_program_drives_a_clamped_robot(folder: Path) -> None:
    (folder / "plan.toml").write_text(PLAN, encoding="utf-8")
    with pytest.raises(InputError) as raised:
        plan_campaign(folder, request=PlanRequest(program=folder / "poses.src"))
    assert raised.value.code == FaultCode.OPTION_INVALID


def test_a_joint_on_a_bench_of_its_own_is_planned_as_its_runs_are(tmp_path: Path) -> None:
    folder = tmp_path / "bench"
    shutil.copytree(CAMPAIGN.parent / "joints" / "01", folder, ignore=shutil.ignore_patterns("raw"))
    head = 'schema = "stiffcal/plan-input/1"\nruns = 3\n'
    noise = "[noise]\nmotor_angle_rad = 5e-6\nmoment_Nm = 0.1\n"
    for load, missing in (("", "load.force_N"), ("[load]\nforce_N = 500.0\n", "load.moment_Nm")):
        (folder / "plan.toml").write_text(head + load + noise, encoding="utf-8")
        with pytest.raises(InputError) as refused:
            plan_campaign(folder)
        assert (refused.value.code, refused.value.place) == (FaultCode.KEY_MISSING, missing)
    (folder / "plan.toml").write_text(f"{head}[load]\nmoment_Nm = 100.0\n{noise}", encoding="utf-8")
    plan = plan_campaign(folder)
    assert plan.experiment == "clamped"
    assert [run.moved_joint for run in plan.runs] == [1, 1, 1]
