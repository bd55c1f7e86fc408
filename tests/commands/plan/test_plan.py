"""`plan`: inputs from plan.toml, what is answered, and every mistake named in one line."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pypdf
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.plan_file import load_plan
from stiffcal.commands.plan import plan_campaign
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.planning.campaign import choice as plan_choice
from stiffcal.planning.campaign.model import with_rotation
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.design import information
from stiffcal.planning.information import information_of_runs
from stiffcal.planning.results import PlanResult
from stiffcal.stages.plans.model import planned_model
from stiffcal.stages.steps import RunContext
from tests.laboratory.printed_toml import pairs_in

CAMPAIGNS = Path(__file__).parents[3] / "campaigns"
LOAD = "[load]\nforce_N = 450.0\n"
REGION = "[region]\nmin_m = [{}, -0.6, 0.2]\nmax_m = [{}, 0.6, 1.2]\nforce_N = 400.0\n"


REFINED = plan_choice.SPREADS


@pytest.fixture
def irb4400(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return paper 002's campaign without logs. Poses stay where they are drawn, but where `refined` is asked for."""
    monkeypatch.setattr(plan_choice, "SPREADS", ())
    for name in ("campaign.toml", "robot.toml", "model.toml"):
        shutil.copy(CAMPAIGNS / "irb4400" / name, tmp_path / name)
    return tmp_path


@pytest.fixture
def refined(irb4400: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have poses refined, for tests of which poses serve best."""
    monkeypatch.setattr(plan_choice, "SPREADS", REFINED)


def with_plan(folder: Path, text: str, candidates: int = 40) -> Path:
    head = f'schema = "stiffcal/plan-input/1"\ncandidates = {candidates}\n'
    (folder / "plan.toml").write_text(head + text, encoding="utf-8")
    return folder


def test_a_band_that_nobody_named_is_no_goal_of_the_runs_nor_of_another_hour(irb4400: Path) -> None:
    values = '"backlash.j1.width" = { value = 6e-4 }, "backlash.j1.band" = { value = 12.0 }'
    with (irb4400 / "model.toml").open("a", encoding="utf-8") as model:
        model.write(f'\n[[effects]]\ntype = "backlash"\njoints = [1]\nparameters = {{ {values} }}\n')
    plan = plan_campaign(with_plan(irb4400, "runs = 4\n" + LOAD))
    relative = {parameter.name: parameter.relative or np.inf for parameter in plan.parameters}
    band = relative.pop("backlash.j1.band")
    assert max(relative.values()) < band < np.inf
    assert plan.gain[-1].worst_relative == pytest.approx(max(relative.values()))
    assert plan.another_hour is not None
    assert (plan.another_hour.worst_relative or np.inf) < max(relative.values())


def test_every_parameter_has_its_expected_uncertainty(irb4400: Path) -> None:
    plan = plan_campaign(with_plan(irb4400, "runs = 8\n" + LOAD))
    assert [parameter.name for parameter in plan.parameters] == [f"joint-compliance.j{k}.c" for k in range(1, 7)]
    assert len(plan.runs) == 8
    assert sorted(run.rank for run in plan.runs) == list(range(1, 9))
    relative = [parameter.relative or np.nan for parameter in plan.parameters]
    assert plan.gain[-1].worst_relative == pytest.approx(max(relative))
    for parameter in plan.parameters:
        assert parameter.half_width == pytest.approx((parameter.relative or np.nan) * parameter.value)
    assert 0.9 < plan.efficiency <= 1.0
    assert not plan.not_identified


@pytest.mark.practice
@pytest.mark.usefixtures("refined")
def test_a_plan_is_better_than_random_poses_at_full_load(irb4400: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half the runs of the plan do as well as random possible ones (in the median of them)."""
    half = plan_campaign(with_plan(irb4400, "runs = 8\n" + LOAD))
    # random poses stay where they were drawn
    monkeypatch.setattr(plan_choice, "SPREADS", ())
    worst = []
    for seed in range(5):
        # as many candidates as runs: nothing is left to choose
        text = f"runs = 16\nseed = {seed + 10}\nrepeats = 1\n" + LOAD + "directions = [[1.0, 0.3, -0.6]]\n"
        worst.append(plan_campaign(with_plan(irb4400, text, candidates=16)).gain[-1].worst_relative or np.inf)
    assert (half.gain[-1].worst_relative or np.inf) < np.median(worst)


@pytest.mark.usefixtures("refined")
def test_refined_joint_angles_are_better_and_possible(irb4400: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = "runs = 8\n[limits_deg]\nA1 = [-40.0, 30.0]\n" + LOAD
    refined = plan_campaign(with_plan(irb4400, text), request=PlanRequest(criterion="determinant"))
    monkeypatch.setattr(plan_choice, "SPREADS", ())
    drawn = plan_campaign(irb4400, request=PlanRequest(criterion="determinant"))

    def volume(plan: PlanResult) -> float:
        return float(np.sum(np.log([parameter.relative or np.nan for parameter in plan.parameters])))

    assert volume(refined) < volume(drawn) - 0.2
    first = np.degrees([run.joints[0] for run in refined.runs])
    assert first.min() >= -35.0 - 1e-9
    assert first.max() <= 25.0 + 1e-9


def test_minutes_decide_on_the_number_of_runs(irb4400: Path, tmp_path: Path) -> None:
    text = "minutes = 100.0\nwarm_up_minutes = 30.0\nminutes_per_run = 5.0\nminutes_per_step = 2.0\n" + LOAD
    sheet = tmp_path / "runs.csv"
    plan = plan_campaign(with_plan(irb4400, text), request=PlanRequest(sheet=sheet))
    # two load steps and two unloaded states: 13 min each
    assert len(plan.runs) == 5
    assert plan.minutes == pytest.approx(95.0)
    first, *_ = csv.DictReader(sheet.read_text(encoding="utf-8").splitlines())
    assert (first["run"], first["state"], first["minutes"]) == ("", "warm-up: move all joints", "30")


def test_the_run_sheet_has_every_state(irb4400: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "runs.csv"
    plan = plan_campaign(with_plan(irb4400, "runs = 3\n" + LOAD), request=PlanRequest(sheet=sheet))
    rows = list(csv.DictReader(sheet.read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 3 * 4
    first = [row for row in rows if row["run"] == plan.runs[0].id]
    force = [np.linalg.norm([float(row[f"{axis} [N]"]) for axis in ("Fx", "Fy", "Fz")]) for row in first]
    assert force == pytest.approx([0.0, 225.0, 450.0, 0.0], abs=0.2)
    angles = [float(first[0][f"A{k} [deg]"]) for k in range(1, 7)]
    assert angles == pytest.approx(np.degrees(plan.runs[0].joints), abs=0.01)


def test_the_run_sheet_on_paper_has_every_run(irb4400: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "runs.pdf"
    plan = plan_campaign(with_plan(irb4400, "runs = 3\n" + LOAD), request=PlanRequest(sheet=sheet))
    text = " ".join(page.extract_text() for page in pypdf.PdfReader(sheet).pages)
    for run in plan.runs:
        assert run.id in text
        for angle in np.degrees(run.joints):
            assert f"{angle:.2f}".replace("-", "−") in text
    assert all(parameter.name in text for parameter in plan.parameters)
    with pytest.raises(InputError) as raised:
        plan_campaign(irb4400, request=PlanRequest(sheet=tmp_path / "runs.docx"))
    assert raised.value.code == FaultCode.FORMAT_UNKNOWN


def test_a_plan_for_a_path_predicts_better_there(irb4400: Path, tmp_path: Path) -> None:
    path = tmp_path / "path.csv"
    head = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz\n"
    path.write_text(head + "0,0,0,0,45,0,0,0,-500\n5,0,0,0,45,0,0,0,-500\n10,0,0,0,45,0,100,0,-500\n", encoding="utf-8")
    folder = with_plan(irb4400, "runs = 6\n" + LOAD)
    for_path = plan_campaign(folder, request=PlanRequest(purpose=str(path)))
    assert for_path.criterion == "prediction"
    assert for_path.prediction_half_width_m is not None
    assert 1e-6 < for_path.prediction_half_width_m < 1e-4
    named = {parameter.name: parameter.relative for parameter in plan_campaign(folder).parameters}
    widest = max(relative or np.inf for relative in named.values())
    # the plan for stiffness has the smaller largest uncertainty: each is best at its own purpose
    assert widest <= max(parameter.relative or np.inf for parameter in for_path.parameters) * (1.0 + 1e-9)


def test_parameters_without_values_are_planned_with_typical_ones(irb4400: Path) -> None:
    (irb4400 / "model.toml").write_text(
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [1, 2, 3, 4, 5, 6]\n',
        encoding="utf-8",
    )
    plan = plan_campaign(with_plan(irb4400, "runs = 8\n" + LOAD))
    assert all(parameter.assumed for parameter in plan.parameters)
    assert plan.warnings


def test_a_joint_that_the_load_cannot_turn_is_not_identified(irb4400: Path) -> None:
    """A force on the axis of the last joint does not turn it."""
    text = (irb4400 / "campaign.toml").read_text(encoding="utf-8")
    frame = '\n[frames.on_axis]\nparent = "flange"\nxyz_m = [0.0, 0.0, 0.24]\n'
    (irb4400 / "campaign.toml").write_text(text.replace("\n[tool]", frame + "\n[tool]"), encoding="utf-8")
    plan = plan_campaign(with_plan(irb4400, "runs = 8\n" + LOAD + 'point = "on_axis"\n'))
    assert plan.not_identified == ["joint-compliance.j6.c"]
    assert [remedy.parameter for remedy in plan.remedies or []] == plan.not_identified
    means = (plan.remedies or [])[0].means
    # across the axis it turns the joint, along it it does not
    assert any("along its x axis" in text for text in means)
    assert not any("along its z axis" in text or "times the load" in text for text in means)
    assert all(parameter.half_width is not None for parameter in plan.parameters[:5])


FULL_BOX = "[[keep_out]]\nmin_m = [-9.0, -9.0, -9.0]\nmax_m = [9.0, 9.0, 9.0]\n"
AWAY = "[tracker]\nposition_m = [9.0, 0.0, 1.0]\nreflector_axis = [0.0, 0.0, 1.0]\nacceptance_deg = 0.001\n"
EMPTY_BOX = "[[keep_out]]\nmin_m = [1.0, 0.0, 0.0]\nmax_m = [0.0, 1.0, 1.0]\n"
ONE_POSE = "[limits_deg]\n" + "".join(f"A{k} = [20.0, 32.0]\n" for k in range(1, 7))
NO_AXIS = "[tracker]\nposition_m = [9.0, 0.0, 1.0]\naxis = [0.0, 0.0, 0.0]\n"
BEHIND = "[tracker]\nposition_m = [9.0, 0.0, 1.0]\naxis = [1.0, 0.0, 0.0]\ncone_deg = 20.0\n"


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        ("", FaultCode.KEY_MISSING, "load.force_N"),
        (LOAD + FULL_BOX, FaultCode.POSE_UNREACHABLE, "keep_out"),
        (LOAD + AWAY, FaultCode.POSE_UNREACHABLE, "tracker.acceptance_deg"),
        (LOAD + BEHIND, FaultCode.POSE_UNREACHABLE, "tracker.cone_deg"),
        ("[limits_deg]\nA2 = [30.0, 35.0]\n" + LOAD, FaultCode.POSE_UNREACHABLE, "limits_deg.A2"),
        ("[limits_deg]\nA9 = [30.0, 35.0]\n" + LOAD, FaultCode.JOINT_UNKNOWN, "limits_deg"),
        ("[load]\nforce_N = 1e-3\n", FaultCode.DATA_MISSING, "load"),
        ("[load]\nforce_N = 9.0\ndead_weights_kg = [5.0]\n", FaultCode.KEY_CONFLICT, "load.dead_weights_kg"),
        (LOAD + "directions = [[0.0, 0.0, 0.0]]\n", FaultCode.VALUE_INVALID, "load.directions"),
        (LOAD + 'point = "nowhere"\n', FaultCode.FRAME_UNKNOWN, "load.point"),
        ("minutes = 3.0\n" + LOAD, FaultCode.VALUE_INVALID, "minutes"),
        (LOAD + EMPTY_BOX, FaultCode.VALUE_INVALID, "keep_out 1"),
        (LOAD + NO_AXIS, FaultCode.VALUE_INVALID, "tracker.axis"),
        (LOAD + "[tracker]\n", FaultCode.KEY_MISSING, "tracker.position_m"),
        (LOAD + REGION.format(7.0, 8.0), FaultCode.POSE_UNREACHABLE, "region"),
        (LOAD + REGION.format(2.0, 1.0), FaultCode.VALUE_INVALID, "region"),
        ('parameters = ["backlash.j1.width"]\n' + LOAD, FaultCode.PARAMETER_UNKNOWN, "parameters"),
        # one pose under three directions, forth and back: six runs differ
        ("runs = 9\n" + LOAD + ONE_POSE, FaultCode.POSE_UNREACHABLE, "runs"),
        ('experiment = "absolute"\n' + LOAD, FaultCode.KEY_CONFLICT, "load.force_N"),
    ],
)  # fmt: skip
def test_a_mistake_is_named(irb4400: Path, text: str, code: FaultCode, place: str) -> None:
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(irb4400, text))
    fault = raised.value.faults[0]
    assert (fault.code, fault.file, fault.place) == (code, "plan.toml", place)
    assert "\n" not in str(fault)


def test_what_is_offered_where_runs_would_be_near_copies_makes_the_plan(irb4400: Path) -> None:
    text = ONE_POSE + LOAD
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(irb4400, "runs = 20\n" + text))
    (fault,) = raised.value.faults
    offered = {change.kind: int(*change.sizes) for change in fault.changes}
    repeats, fewer = offered["repeats"], offered["runs"]
    assert len(plan_campaign(with_plan(irb4400, f"runs = 20\nrepeats = {repeats}\n" + text)).runs) == 20
    assert len(plan_campaign(with_plan(irb4400, f"runs = {fewer}\n" + text)).runs) == fewer


def test_the_load_of_a_plan_is_more_than_the_springs_hold(irb4400: Path) -> None:
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(irb4400, "[load]\nforce_N = 2.9e5\n"))
    assert raised.value.code == FaultCode.NO_BALANCE


def test_a_force_for_absolute_poses_is_refused_where_it_was_given(irb4400: Path) -> None:
    folder = with_plan(irb4400, 'experiment = "absolute"\n')
    with pytest.raises(InputError) as raised:
        plan_campaign(folder, request=PlanRequest(force=30.0))
    (fault,) = raised.value.faults
    assert (fault.code, fault.file, fault.place) == (FaultCode.OPTION_CONFLICT, "command line", "--force")


def test_the_noise_that_is_asked_for_is_enough(tmp_path: Path) -> None:
    """What is to be added, in the words of the refusal, makes the plan: with orientation measured, two numbers."""
    for name in ("campaign.toml", "robot.toml"):
        shutil.copy(CAMPAIGNS / "hidden" / "01" / name, tmp_path / name)
    shutil.copy(CAMPAIGNS / "irb4400" / "model.toml", tmp_path / "model.toml")
    plan = "runs = 2\n" + LOAD
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(tmp_path, plan))
    (fault,) = raised.value.faults
    assert (fault.code, fault.place) == (FaultCode.KEY_MISSING, "noise.translation_m")
    noise = "\n".join(pairs_in(fault.mend))
    assert len(plan_campaign(with_plan(tmp_path, f"{plan}[noise]\n{noise}\n")).runs) == 2


def test_forces_that_nobody_means(campaign: Path) -> None:
    folder = with_plan(campaign, "runs = 3\n" + LOAD, candidates=8)
    for force in (float("inf"), 1e9):
        with pytest.raises(InputError) as refused:
            plan_campaign(folder, request=PlanRequest(force=force))
        assert [fault.code for fault in refused.value.faults] == [FaultCode.OPTION_INVALID]
    of_units = [
        [line for line in plan_campaign(folder, request=PlanRequest(force=force)).warnings if " kN?" in line]
        for force in (200.0, 0.2)
    ]
    assert [len(lines) for lines in of_units] == [0, 1]


def test_a_plan_for_a_region_predicts_better_there(irb4400: Path) -> None:
    folder = with_plan(irb4400, "runs = 5\n" + LOAD + REGION.format(1.0, 1.6))
    there, for_stiffness = (plan_campaign(folder, request=PlanRequest(purpose=p)) for p in ("region", "stiffness"))
    assert (there.criterion, there.predicted_at, for_stiffness.predicted_at) == ("prediction", "region", "region")
    assert (there.prediction_half_width_m or 1.0) < (for_stiffness.prediction_half_width_m or 0.0)
    mixed = plan_campaign(folder, request=PlanRequest(purpose="stiffness=1, region=3"))
    assert mixed.criterion == "mix"
    assert [(goal.goal, goal.weight) for goal in mixed.goals or []] == [("stiffness", 0.25), ("region", 0.75)]
    assert all(0.8 < goal.efficiency <= 1.0 for goal in mixed.goals or [])
    # each goal is served better than by the plan for the other
    worst = [max(p.relative or np.inf for p in plan.parameters) for plan in (mixed, there)]
    assert worst[0] < worst[1]
    assert (mixed.prediction_half_width_m or 1.0) < (for_stiffness.prediction_half_width_m or 0.0)


def test_the_parameters_that_are_named_count(irb4400: Path) -> None:
    one = "joint-compliance.j6.c"
    every, named = (
        plan_campaign(with_plan(irb4400, f"runs = 4\n{text}" + LOAD)) for text in ("", f'parameters = ["{one}"]\n')
    )
    assert (named.parameters[5].relative or 1.0) < 0.95 * (every.parameters[5].relative or 0.0)


def test_another_hour_is_worth_what_a_longer_plan_brings(irb4400: Path) -> None:
    text = "minutes_per_run = 11.0\n" + LOAD  # 15 min a run
    plan, longer = (plan_campaign(with_plan(irb4400, f"runs = {n}\n" + text)) for n in (6, 10))
    hour = plan.another_hour
    assert hour is not None
    assert hour.runs == 4
    assert hour.worst_relative == pytest.approx(longer.gain[-1].worst_relative, rel=0.1)
    assert hour.smaller == pytest.approx(1.0 - (hour.worst_relative or 0.0) / (plan.gain[-1].worst_relative or 1.0))


def test_a_class_of_robot_gives_the_values(irb4400: Path) -> None:
    (irb4400 / "model.toml").unlink()
    light, heavy = (
        plan_campaign(with_plan(irb4400, f'runs = 4\nrobot_class = "{c}"\n' + LOAD)) for c in ("light", "heavy")
    )
    assert [p.value for p in heavy.parameters] == [5e-7] * 3 + [3e-6] * 3
    # what is softer shows more
    assert (light.gain[-1].worst_relative or 1.0) < 0.3 * (heavy.gain[-1].worst_relative or 0.0)


def test_twice_the_noise_is_twice_the_uncertainty(irb4400: Path) -> None:
    noise = "[noise]\ntranslation_m = {}\nforce_N = {}\n"
    one, two = (
        plan_campaign(with_plan(irb4400, "runs = 6\n" + LOAD + noise.format(2e-5 * f, 0.5 * f))) for f in (1.0, 2.0)
    )
    # the same runs serve best, but for exchanges that are worth next to nothing
    ratio = (two.gain[-1].worst_relative or 0.0) / (one.gain[-1].worst_relative or 1.0)
    assert ratio == pytest.approx(2.0, rel=0.05)


def test_dead_weights_pull_down(irb4400: Path) -> None:
    plan = plan_campaign(with_plan(irb4400, "runs = 4\n[load]\ndead_weights_kg = [20.0, 40.0]\n"))
    for run in plan.runs:
        np.testing.assert_allclose(run.wrench, [[0, 0, -196.2, 0, 0, 0], [0, 0, -392.4, 0, 0, 0]], atol=1e-9)


def test_the_campaign_folder_is_ready_for_the_logs(irb4400: Path, tmp_path: Path) -> None:
    out = tmp_path / "next"
    request = PlanRequest(campaign=out)
    plan = plan_campaign(with_plan(irb4400, "runs = 3\n" + LOAD), request=request)
    assert plan.files == ["campaign.toml", "robot.toml", "model.toml", "plan.toml", "runs.csv", "runs.pdf"]
    made = load_campaign(out, check_files=False)
    assert [run.id for run in made.manifest.runs] == [run.id for run in plan.runs]
    first = made.manifest.runs[0]
    assert first.joints_deg == pytest.approx(np.degrees(plan.runs[0].joints), abs=0.01)
    assert first.files == {
        "force": "raw/run01_force.csv", "digitizer": "raw/run01_digitizer.csv", "controller": "raw/run01_controller.h5",
    }  # fmt: skip
    with pytest.raises(InputError) as raised:
        plan_campaign(irb4400, request=request)
    assert raised.value.code == FaultCode.FILE_EXISTS


def test_check_reads_the_folder_before_and_while_one_measures(irb4400: Path, tmp_path: Path) -> None:
    """Nothing measured yet is no fault; logs of the first run, simulated at its pose, are understood."""
    out = tmp_path / "next"
    plan_campaign(with_plan(irb4400, "runs = 3\n" + LOAD), request=PlanRequest(campaign=out))
    assert not check_campaign(out).ready
    shutil.copy(CAMPAIGNS / "irb4400" / "simulate.toml", irb4400)
    simulate_campaign(irb4400, tmp_path / "twin", seed=1)
    for source, ending in (("force", "csv"), ("digitizer", "csv"), ("joints", "h5")):
        name = {"joints": "controller"}.get(source, source)
        shutil.copy(tmp_path / "twin" / "raw" / f"pose1_{source}.{ending}", out / "raw" / f"run01_{name}.{ending}")
    checked = check_campaign(out)
    assert [run.id for run in checked.runs if run.n_states] == ["run01"]
    # half-way: what the first run shows counts for the further ones
    further = with_plan(out, "runs = 3\n" + LOAD)
    counted = plan_campaign(further)
    assert [run.id for run in counted.runs] == ["run04", "run05", "run06"]
    assert counted.values_from.startswith("1 of 3 runs")
    shutil.rmtree(out / "raw")
    alone = plan_campaign(further)
    assert max(p.relative or np.inf for p in counted.parameters) < max(p.relative or np.inf for p in alone.parameters)


TWO_SLOPE = """schema = "stiffcal/model/1"
[[effects]]
type = "joint-compliance"
joints = [1, 2, 3, 4, 5, 6]
[[effects]]
type = "two-slope"
joints = [2]
"""


@pytest.mark.practice
def test_an_unknown_knee_is_planned_for_over_its_range(irb4400: Path) -> None:
    """A knee that lies elsewhere in the range is known better by the plan for the range than by one for a value."""
    (irb4400 / "model.toml").write_text(TWO_SLOPE, encoding="utf-8")
    text = "runs = 8\n" + LOAD
    wide = plan_campaign(with_plan(irb4400, text + '[prior_range]\n"two-slope.j2.knee" = [10.0, 300.0]\n', 16))
    narrow = plan_campaign(with_plan(irb4400, text + '[prior_range]\n"two-slope.j2.knee" = [29.9, 30.1]\n', 16))
    assert any(not np.array_equal(a.joints, b.joints) for a, b in zip(wide.runs, narrow.runs, strict=True))
    # both senses, since the law has a knee
    assert all((run.wrench[:, :3] @ run.wrench[3, :3] < 0.0).any() for run in wide.runs)

    def with_knee(plan: PlanResult, knee: float) -> float:
        """Return the largest relative uncertainty that the plan's runs bring where the knee lies here."""
        campaign = load_campaign(irb4400, check_files=False)
        model = planned_model(campaign, load_plan(irb4400), RunContext())
        robot = model.robot.with_values({"two-slope.j2.knee": knee})
        runs = information_of_runs(
            robot, np.stack([run.joints for run in plan.runs]), np.stack([run.wrench for run in plan.runs]),
            model.setup, model.noise, with_rotation(campaign),
        )  # fmt: skip
        total = information(runs.factors).sum(axis=0)
        return float(np.sqrt(np.diagonal(np.linalg.inv(total)).max()))

    worst = [max(with_knee(plan, knee) for knee in (10.0, 30.0, 300.0)) for plan in (wide, narrow)]
    assert worst[0] < worst[1]


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ('"two-slope.j3.knee" = [10.0, 20.0]', FaultCode.PARAMETER_UNKNOWN),
        ('"joint-compliance.j2.c" = [1e-7, 1e-6]', FaultCode.PARAMETER_UNKNOWN),
        ('"two-slope.j2.knee" = [20.0, 10.0]', None),
    ],
)
def test_a_wrong_range_is_named(irb4400: Path, line: str, code: FaultCode | None) -> None:
    (irb4400 / "model.toml").write_text(TWO_SLOPE, encoding="utf-8")
    with pytest.raises(InputError) as raised:
        plan_campaign(with_plan(irb4400, LOAD + f"[prior_range]\n{line}\n"))
    assert raised.value.file == "plan.toml"
    assert code is None or raised.value.code == code
