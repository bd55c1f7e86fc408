"""Robot programs of a plan: the poses that the controller would drive to, and what protects people."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.plan_file import PlanFile, load_plan
from stiffcal.commands.plan import plan_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.means import cell_of
from stiffcal.planning.campaign.program import write_program
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.candidates import Cell
from stiffcal.planning.results import PlanResult
from tests.commands.plan.test_plan import CAMPAIGNS, LOAD, irb4400, with_plan
from tests.laboratory.hostile_names import ALLOWED

__all__ = ["irb4400"]  # the fixture
BOX = "[[keep_out]]\nmin_m = [1.0, -0.5, 0.0]\nmax_m = [2.0, 0.5, 0.9]\n"
NUMBER = r"(-?\d+\.\d+)"
# What an outside reader of the language takes for a joint target, and the unit in rad.
MOVES = {
    ".src": (rf"^PTP {{AXIS: {', '.join(f'A{k} {NUMBER}' for k in range(1, 7))}}}$", np.radians(1.0)),
    ".mod": (rf"^ *MoveAbsJ \[\[{','.join([NUMBER] * 6)}\],\[(?:9E9,?){{6}}\]\]\\NoEOffs, slow, fine, tool0;$",
             np.radians(1.0)),
    ".script": (rf"^ *movej\(\[{', '.join([NUMBER] * 6)}\], a=0.2, v=0.2\)$", 1.0),
}  # fmt: skip
STOPS = {
    ".src": r"^HALT$",
    ".mod": r"^ *Stop;$",
    ".script": r"^ *popup\(.*blocking=True\)$",
    ".ls": r"^ *\d+: *PAUSE ;$",
}
COMMENTS = {".src": "; ", ".mod": "  ! ", ".script": "  # ", ".ls": "  !"}
ENDINGS = sorted(STOPS)


Planned: TypeAlias = tuple[Campaign, PlanResult, Cell]


@pytest.fixture(scope="module")
def planned() -> Planned:
    """Return a plan of paper 002's robot."""
    campaign = load_campaign(CAMPAIGNS / "irb4400", check_files=False)
    plan = plan_campaign(CAMPAIGNS / "irb4400", request=PlanRequest(runs=4, force=450.0))
    return campaign, plan, cell_of(campaign, PlanFile.model_validate({}))


def targets(text: str, ending: str) -> Floats:
    """Return (n, 6) the joint targets of a program in the order of its moves, rad."""
    if ending != ".ls":
        pattern, unit = MOVES[ending]
        return np.array([[unit * float(part) for part in row] for row in re.findall(pattern, text, re.MULTILINE)])
    body, positions = text.split("/POS\n")
    listed = {}
    for number, content in re.findall(r"^P\[(\d+)\]\{\n(.*?)^\};$", positions, re.MULTILINE | re.DOTALL):
        listed[number] = [float(angle) for angle in re.findall(r"J\d= (-?\d+\.\d+) deg", content)]
    order = re.findall(r"^ *\d+:J P\[(\d+)\] 10% FINE ;$", body, re.MULTILINE)
    return np.array([np.radians(listed[number]) for number in order])


@pytest.fixture(scope="module")
def around(tmp_path_factory: pytest.TempPathFactory) -> Planned:
    """Return a plan of five runs with a box in the way."""
    return with_cell(tmp_path_factory.mktemp("around"), BOX)


def with_cell(folder: Path, text: str) -> Planned:
    """Return a plan of five runs in a cell of which plan.toml says this."""
    for name in ("campaign.toml", "robot.toml", "model.toml"):
        shutil.copy(CAMPAIGNS / "irb4400" / name, folder / name)
    plan = plan_campaign(with_plan(folder, "runs = 5\n" + LOAD + text))
    campaign = load_campaign(folder, check_files=False)
    return campaign, plan, cell_of(campaign, load_plan(folder))


def written(planned: Planned, folder: Path, ending: str) -> tuple[PlanResult, str]:
    """Return the plan and its program in the language of the ending."""
    campaign, plan, cell = planned
    file = folder / f"poses{ending}"
    write_program(file, campaign, plan, cell)
    return plan, file.read_text(encoding="ascii")


def test_a_plan_writes_its_program(irb4400: Path) -> None:
    file = irb4400 / "poses.src"
    plan = plan_campaign(with_plan(irb4400, "runs = 3\n" + LOAD + BOX), request=PlanRequest(program=file))
    assert plan.program == str(file)
    poses = np.concatenate([np.vstack([*run.approach, run.joints]) for run in plan.runs])
    np.testing.assert_allclose(targets(file.read_text(encoding="ascii"), ".src"), poses, atol=np.radians(0.001))


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_program_drives_to_the_planned_poses(around: Planned, tmp_path: Path, ending: str) -> None:
    plan, text = written(around, tmp_path, ending)
    assert not plan.blocked_moves
    poses = np.concatenate([np.vstack([*run.approach, run.joints]) for run in plan.runs])
    # there is a pose on the way, otherwise this shows less
    assert len(poses) > len(plan.runs)
    np.testing.assert_allclose(targets(text, ending), poses, atol=np.radians(0.001))


@pytest.mark.parametrize("ending", ENDINGS)
def test_it_waits_before_the_first_move_and_at_every_pose(around: Planned, tmp_path: Path, ending: str) -> None:
    plan, text = written(around, tmp_path, ending)
    move = r"^ *\d+:J P\[" if ending == ".ls" else r"^ *(?:PTP|MoveAbsJ|movej)\b"
    kinds = [
        "stop" if re.match(STOPS[ending], line) else "move"
        for line in text.splitlines()
        if re.match(STOPS[ending], line) or re.match(move, line)
    ]
    expected = ["stop"]
    for run in plan.runs:
        expected += ["move"] * (len(run.approach) + 1) + ["stop"]
    assert kinds == expected


def test_the_poses_keep_the_limits_with_their_margin(tmp_path: Path) -> None:
    planned = with_cell(tmp_path, "[limits_deg]\nA1 = [-40.0, 30.0]\n")
    for ending in ENDINGS:
        first = np.degrees(targets(written(planned, tmp_path, ending)[1], ending)[:, 0])
        assert first.min() >= -35.001
        assert first.max() <= 25.001


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_head_states_what_was_checked(around: Planned, tmp_path: Path, ending: str) -> None:
    _, text = written(around, tmp_path, ending)
    words = " ".join(re.sub(r"^ *(?:\d+:)? *[;!#]|;$", "", line).strip() for line in text.splitlines())
    words = re.sub(" +", " ", words)
    assert "CHECKED AGAINST THESE ONLY" in words
    assert "keep-out box 1: (1.000, -0.500, 0.000) m to (2.000, 0.500, 0.900) m" in words
    assert "NOT CHECKED: the way to the first pose" in words


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("name", [*sorted(ALLOWED.values())[:12], "x; PTP {AXIS: A1 90}", '"; Stop; !', ";ENDFOLD"])
def test_names_stay_in_comments(planned: Planned, tmp_path: Path, ending: str, name: str) -> None:
    """With hostile names of the robot and a joint all lines but comments are the same."""

    def code(text: str) -> list[str]:
        lines = [re.sub(r"^ *\d+:", "", line) for line in text.splitlines()]
        return [line for line in lines if not line.startswith(COMMENTS[ending])]

    campaign, plan, cell = planned
    texts = []
    for robot_name in ("a robot", name):
        file = tmp_path / f"poses{ending}"
        robot = campaign.robot.model_copy(update={"name": robot_name})
        write_program(
            file, replace(campaign, robot=robot), replace(plan, joint_names=(name, *plan.joint_names[1:])), cell
        )
        texts.append(file.read_text(encoding="ascii"))
    plain, hostile = texts
    assert code(hostile) == code(plain)
    assert "ENDFOLD" not in hostile


@pytest.mark.parametrize(
    ("file", "code"),
    [
        ("poses.txt", FaultCode.FORMAT_UNKNOWN),
        ("main.mod", FaultCode.NAME_INVALID),
        ("a b.src", FaultCode.NAME_INVALID),
        ("1a.script", FaultCode.NAME_INVALID),
        ("morethan8.ls", FaultCode.NAME_INVALID),
    ],
)
def test_a_name_that_the_controller_does_not_take_is_refused(irb4400: Path, file: str, code: FaultCode) -> None:
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(irb4400, LOAD), request=PlanRequest(program=irb4400 / file))
    assert raised.value.code == code
    assert not (irb4400 / file).exists()


def test_no_program_is_written_where_a_move_is_not_free(irb4400: Path) -> None:
    # a wall that the links cannot pass, with poses on both sides: joint 1 cannot turn by more than 170 degrees
    wall = "[[keep_out]]\nmin_m = [0.45, -0.01, -9.0]\nmax_m = [9.0, 0.01, 9.0]\n"
    limits = "[limits_deg]\nA1 = [-80.0, 80.0]\nA2 = [0.0, 60.0]\nA3 = [-40.0, 20.0]\n"
    with pytest.raises(InputError) as raised:
        plan_campaign(
            with_plan(irb4400, "runs = 5\n" + LOAD + limits + wall), request=PlanRequest(program=irb4400 / "poses.src")
        )
    assert raised.value.code == FaultCode.POSE_UNREACHABLE
    assert not (irb4400 / "poses.src").exists()
