"""`export -o compensation.c` for a campaign: the code drives paper 002's path, and the true robot judges it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.compensate import compensate_campaign
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.export import export_campaign
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.compensation.corrected_path import CompensateRequest
from stiffcal.compensation.exports.controller import ControllerOptions, reading_setup
from stiffcal.compensation.exports.step import CompensationStep
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.compensation.path import CompensationPath, read_path
from stiffcal.compensation.path_forces import Forces
from stiffcal.compensation.targets import CorrectionOptions, errors_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from tests.laboratory.compilers import SANITIZED, STRICT, build
from tests.laboratory.few_effects import few_effects
from tests.laboratory.replay import DRIVER, by_program, by_python
from tests.laboratory.small_campaign import write_small_campaign

BACKLASH = """
[[effects]]
type = "backlash"
joints = [4]
parameters = { "backlash.j4.width" = { value = 2e-3 }, "backlash.j4.band" = { value = 5.0 } }
"""
TRUE_ROBOT = Path(__file__).parents[2] / "campaigns" / "irb4400" / "compensation"
LOOP = ControllerOptions(sensor="load_point")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return paper 002's campaign with logs; model.toml holds the six drives and three bearings without values."""
    folder = tmp_path_factory.mktemp("compensation") / "irb4400"
    simulate_campaign(TRUE_ROBOT, folder)
    return folder


def rms_mm(errors: Floats) -> float:
    return 1e3 * float(np.sqrt(np.mean(np.sum(errors[:, :3] ** 2, axis=1))))


def readings_of(fitted: FittedRobot, path: CompensationPath) -> Floats:
    """Return the path's wrenches (n, 6) in the axes of the frame load_point, about whose origin they are."""
    chain, frame = fitted.campaign.chain, fitted.frame("load_point", "--sensor")
    _, rotation = attached_poses(chain, chain.model_angles(path.joints), frame)
    parts = path.wrench.reshape(-1, 2, 3)
    return np.asarray(np.einsum("nji,nkj->nki", rotation, parts).reshape(-1, 6))


@pytest.mark.parametrize(("bearings", "left"), [(True, 0.03), (False, 0.15)])
def test_the_path_of_paper_002_driven_by_the_code(measured: Path, tmp_path: Path, bearings: bool, left: float) -> None:
    """30 poses, each by itself; the exact balance of the robot as it is says what is left of the deflection."""
    store = RunContext(store=str(tmp_path / "store"))
    folder = measured if bearings else _drives_alone(measured, tmp_path)
    export_campaign(folder, store, tmp_path / "compensation.c", loop=LOOP)
    sources = [tmp_path / "compensation.c", DRIVER]
    program = build("gcc", tmp_path / "replay", sources, *SANITIZED, f"-I{tmp_path}")
    fitted = fitted_robot(load_campaign(folder, check_files=False), store)
    setup, _ = reading_setup(fitted, LOOP)
    path = read_path(fitted, fitted.aimed_at(None)[0], TRUE_ROBOT / "path.csv", Forces(), None)
    reading = readings_of(fitted, path)
    by_c = by_program(program, path.joints, reading, alone=True)
    by_step = by_python(CompensationStep(fitted.robot, setup), path.joints, reading, alone=True)
    assert np.abs(by_c.offsets - by_step.offsets).max() < 1e-10
    truth = fitted_robot(load_campaign(TRUE_ROBOT, check_files=False), RunContext())
    judged = [
        errors_of(truth.robot, path.joints, path.joints + offsets, path.wrench, path.setup, CorrectionOptions())
        for offsets in (np.zeros_like(by_c.offsets), by_c.offsets, by_step.offsets)
    ]
    before, after, after_python = (rms_mm(errors) for errors in judged)
    assert after == pytest.approx(after_python, abs=1e-6)
    assert before > 1.0
    assert after < left * before
    exact = compensate_campaign(folder, CompensateRequest(TRUE_ROBOT / "path.csv", judge=TRUE_ROBOT), store).judged
    assert exact is not None
    assert after < 1e3 * (exact.rms_after.translation or 0.0) + 0.005 * before


def _drives_alone(measured: Path, tmp_path: Path) -> Path:
    folder = Path(shutil.copytree(measured, tmp_path / "drives", ignore=shutil.ignore_patterns("store")))
    edit_model(folder, "remove", "bearing-tilt", everywhere=True)
    return folder


def code_of(folder: Path, output: Path, options: ControllerOptions | None = None) -> str:
    export_campaign(folder, RunContext(), output, loop=options)
    return output.read_text(encoding="ascii")


def test_the_head_says_whether_the_model_is_complete(tmp_path: Path) -> None:
    """Not diagnosed, diagnosed with something missing, and values that nothing here has measured."""
    folder = write_small_campaign(tmp_path / "small", poses=6, hidden=BACKLASH)
    answer = export_campaign(folder, RunContext(), tmp_path / "first.c")
    assert " * NOT VERIFIED: " in (tmp_path / "first.c").read_text()
    assert any(warning.startswith("NOT VERIFIED") for warning in answer.warnings)
    with few_effects():
        diagnosed = diagnose_campaign(folder)
    assert diagnosed.missing
    assert f' * INCOMPLETE: by "stiffcal diagnose" the model lacks {diagnosed.missing[0].effect}' in code_of(
        folder, tmp_path / "second.c"
    )
    assert " * NOT VERIFIED: " in code_of(TRUE_ROBOT, tmp_path / "third.c")


def test_a_complete_model_says_so(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small")
    with few_effects():
        diagnosed = diagnose_campaign(folder)
    assert diagnosed.adequate
    answer = export_campaign(folder, RunContext(), tmp_path / "loop.c")
    text = (tmp_path / "loop.c").read_text()
    assert "INCOMPLETE" not in text
    assert "NOT VERIFIED" not in text
    assert not [warning for warning in answer.warnings if "diagnose" in warning]


@pytest.mark.parametrize(
    ("options", "place"),
    [
        (ControllerOptions(cycle_ms=0.0), "--cycle-ms"),
        (ControllerOptions(cycle_ms=float("nan")), "--cycle-ms"),
        (ControllerOptions(filter_hz=200.0), "--filter"),
        (ControllerOptions(tool="3,0,0"), "--tool"),
        (ControllerOptions(zeroed_at="1,2"), "--zeroed-at"),
        (ControllerOptions(sensor="nowhere"), "--sensor"),
        (ControllerOptions(target="base"), "--target"),
    ],
)
def test_options_that_cannot_be_are_named(tmp_path: Path, options: ControllerOptions, place: str) -> None:
    with pytest.raises(InputError) as caught:
        export_campaign(TRUE_ROBOT, RunContext(), tmp_path / "loop.c", loop=options)
    assert caught.value.faults[0].place == place
    assert not list(tmp_path.iterdir())


def test_a_tool_whose_sensor_has_its_point_elsewhere_is_refused(tmp_path: Path) -> None:
    """The campaign's forces are in the sensor's axes about the hook; with the sensor named its weight can be taken."""
    with pytest.raises(InputError) as caught:
        export_campaign(TRUE_ROBOT, RunContext(), tmp_path / "loop.c", loop=ControllerOptions(tool="3,0,0,0.1"))
    assert caught.value.faults[0].code is FaultCode.MODEL_UNSUITABLE
    export_campaign(
        TRUE_ROBOT, RunContext(), tmp_path / "loop.c", loop=ControllerOptions(tool="3,0,0,0.1", sensor="ft_sensor")
    )


def test_hostile_file_names_make_plain_functions(tmp_path: Path) -> None:
    output = tmp_path / 'cell "4"; int x -- é.c'
    export_campaign(TRUE_ROBOT, RunContext(), output)
    assert "int cell_4_int_x_step(" in output.read_text(encoding="ascii")
    build("gcc", tmp_path / "one.o", [output], *STRICT, "-c", f"-I{tmp_path}")
