"""`init --from FOLDER`: sources, patterns, runs, what is not used, and what is left to be written."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xlsxwriter

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.init import init_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.answers import numbers_of
from stiffcal.propose.from_folder import draft_from_folder, propose_from_folder
from stiffcal.propose.lines import Question

JOINTS_DEG = np.array([-30.0, -70.0, 20.0, 15.0, 40.0, 10.0])
ENDING = {"force": ".csv", "tracker": ".txt", "joints": ".h5"}
Naming = Callable[[int, str], str]


def usual(k: int, device: str) -> str:
    return f"pose{k:02d}_{device}{ENDING[device]}"


def write_log(path: Path, device: str, k: int, encoding: str = "utf-8") -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    time = np.arange(0.0, 2.0, 0.1)
    if device == "joints":
        with h5py.File(path, "w") as file:
            group = file.create_group("controller")
            group["t"] = time
            for n, angle in enumerate(JOINTS_DEG + k, start=1):
                group[f"A{n}"] = np.full(time.size, angle)
        return
    head = {
        "force": "Zeit [ms];Kraft X [N];Kraft Y [N];Kraft Z [N]",
        "tracker": "Prüfling 1\nTime [s];X [mm];Y [mm];Z [mm]",
    }
    rows = (f"{second * (1e3 if device == 'force' else 1):.1f};{k + second:.3f};-2,5;{second:.3f}" for second in time)
    text = "\n".join((head[device], *(row.replace(".", ",") for row in rows))) + "\n"
    path.write_bytes(text.encode(encoding))


def folder_of(folder: Path, naming: Naming = usual, runs: int = 3) -> Path:
    for k in range(1, runs + 1):
        for device in ENDING:
            write_log(folder / naming(k, device), device, k)
    return folder


def manifest_of(folder: Path, **options: Any) -> tuple[dict[str, Any], list[str]]:
    draft = draft_from_folder(folder, robot="irb4400", **options)
    return tomllib.loads(draft.manifest), list(draft.runs)


def test_a_source_for_each_device_and_a_pattern_for_its_files(tmp_path: Path) -> None:
    manifest, runs = manifest_of(folder_of(tmp_path))
    files = {source["file"]: source for source in manifest["sources"].values()}
    assert set(files) == {f"raw/{{run}}_{device}{ending}" for device, ending in ENDING.items()}
    assert runs == ["pose01", "pose02", "pose03"]
    assert files["raw/{run}_force.csv"]["time"] == {"column": "Zeit [ms]", "unit": "ms"}
    assert files["raw/{run}_joints.h5"]["joints"]["units"] == {"position": "deg"}
    assert "runs" not in manifest


@pytest.mark.parametrize(
    "naming",
    [
        lambda k, device: f"2026-11-20_10{k + 15}{40 + k + len(device)}_{device}_P{k}{ENDING[device]}",
        lambda k, device: f"{device}/run_{k}{ENDING[device]}",
        lambda k, device: f"{device[0].upper()}_{k:02d}{ENDING[device].replace('csv', 'dat')}",
        lambda k, device: f"P{k}/{device}{ENDING[device]}",
    ],
)
def test_the_folder_that_is_written_has_the_runs(tmp_path: Path, naming: Naming) -> None:
    folder_of(tmp_path / "campaign" / "raw", naming)
    result = init_campaign(tmp_path / "campaign", tables=[tmp_path / "campaign" / "raw"], robot="irb4400")
    assert len(result.runs or []) == 3
    assert result.warnings == []
    assert len(result.to_write or []) == 2
    text = (tmp_path / "campaign" / "campaign.toml").read_text()
    (tmp_path / "campaign" / "campaign.toml").write_text(text.replace("= []", "= [0.0, 0.0, 0.1]"))
    campaign = load_campaign(tmp_path / "campaign")
    assert [run.id for run in campaign.manifest.runs] == result.runs
    assert all(len(run.files) == 3 for run in campaign.manifest.runs)


def test_logs_that_lie_elsewhere_are_copied(tmp_path: Path) -> None:
    folder_of(tmp_path / "usb", lambda k, device: f"P{k}/{device}{ENDING[device]}")
    init_campaign(tmp_path / "campaign", tables=[tmp_path / "usb"], robot="irb4400")
    assert (tmp_path / "campaign" / "raw" / "P1" / "force.csv").read_bytes() == (
        tmp_path / "usb/P1/force.csv"
    ).read_bytes()


def test_missing_partner_stray_files_and_a_log_twice(tmp_path: Path) -> None:
    folder_of(tmp_path)
    write_log(tmp_path / "pose04_force.csv", "force", 4)
    write_log(tmp_path / "test.csv", "force", 4)
    write_log(tmp_path / "pose3_force.csv", "force", 4)
    (tmp_path / "notes.txt").write_text("slipped once\n")
    (tmp_path / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0")
    (tmp_path / ".hidden.csv").write_text("")
    draft = draft_from_folder(tmp_path, robot="irb4400")
    assert list(draft.runs) == ["pose01", "pose02", "pose03"]
    for name in ("pose04_force", "test.csv", "pose3_force", "notes.txt", "photo.jpg"):
        assert [name in remark for remark in draft.remarks].count(True) == 1, name
    assert len(draft.remarks) == 5


@pytest.mark.parametrize("date_1904", [False, True])
def test_dates_of_a_workbook_are_its_times(tmp_path: Path, date_1904: bool) -> None:
    folder_of(tmp_path, runs=1)
    (tmp_path / usual(1, "tracker")).unlink()
    with xlsxwriter.Workbook(tmp_path / "pose01_tracker.xlsx", {"date_1904": date_1904}) as book:
        sheet = book.add_worksheet()
        sheet.write_row(0, 0, ["Zeit", "X [mm]", "Y [mm]", "Z [mm]"])
        for k in range(1, 21):
            at = datetime(2026, 11, 2, 9, 0, k, 400_000)
            sheet.write_datetime(k, 0, at, book.add_format({"num_format": "dd.mm.yyyy hh:mm:ss.000"}))
            sheet.write_row(k, 1, [1.0, 2.0 + k, 3.0])
    manifest, _ = manifest_of(tmp_path)
    assert manifest["sources"]["tracker"]["time"] == {"column": "Zeit", "unit": "iso8601"}


def test_logs_that_are_not_read_for_one_reason_are_one_remark(tmp_path: Path) -> None:
    folder_of(tmp_path)
    for k in range(1, 8):
        (tmp_path / f"pose0{k}_camera.jpg").write_bytes(b"\xff\xd8\xff\xe0")
    (remark,) = draft_from_folder(tmp_path, robot="irb4400").remarks
    assert "pose01_camera.jpg" in remark
    assert "2 more" in remark


def test_a_device_with_few_logs_does_not_take_the_others_runs(tmp_path: Path) -> None:
    folder_of(tmp_path, runs=5)
    for k in (1, 2):
        (tmp_path / f"pose{k:02d}_probe.csv").write_text("t [s],X [mm],Y [mm],Z [mm]\n0,1,2,3\n0.1,1,2,3\n")
    draft = draft_from_folder(tmp_path, robot="irb4400")
    assert len(draft.runs) == 5
    assert len(draft.remarks) == 1


@pytest.mark.parametrize("place", ["TCP_{} [mm]", "RIst.{}"])
@pytest.mark.parametrize("tracked", [True, False])
def test_a_place_that_the_controller_computes_is_not_measured(tmp_path: Path, place: str, tracked: bool) -> None:
    folder_of(tmp_path)
    header = ",".join(["t [s]", *(f"A{n} [deg]" for n in range(1, 7)), *(place.format(axis) for axis in "XYZ")])
    for k in (1, 2, 3):
        rows = (f"{0.1 * n},{','.join(map(str, JOINTS_DEG + k))},{900 + k},{70 + n},400" for n in range(20))
        (tmp_path / f"pose{k:02d}_joints.h5").unlink()
        (tmp_path / f"pose{k:02d}_a.csv").write_text("\n".join((header, *rows)) + "\n")
        if not tracked:
            (tmp_path / f"pose{k:02d}_tracker.txt").unlink()
    manifest, _ = manifest_of(tmp_path)
    poses = {source["file"]: source["pose"]["position"] for source in manifest["sources"].values() if "pose" in source}
    measured = {"raw/{run}_tracker.txt": ["X [mm]", "Y [mm]", "Z [mm]"]}
    assert poses == measured if tracked else "RIst.X" not in str(poses)


def test_what_no_log_states_is_asked_for(tmp_path: Path) -> None:
    asked: list[Question] = []

    def ask(question: Question) -> str:
        asked.append(question)
        return "0.1, 0, 0.2" if question.key == "xyz_m" else ""

    draft = draft_from_folder(folder_of(tmp_path), robot="irb4400", ask=ask)
    assert [(question.table, question.key) for question in asked] == [
        ("frames.load_point", "xyz_m"),
        ("frames.ft_sensor", "rpy_deg"),
    ]
    manifest = tomllib.loads(draft.manifest)
    assert manifest["frames"]["load_point"]["xyz_m"] == [0.1, 0.0, 0.2]
    assert manifest["frames"]["ft_sensor"]["rpy_deg"] == []
    with pytest.raises(InputError):
        numbers_of("12", 3)


def test_a_tool_point_leaves_less_to_write(tmp_path: Path) -> None:
    manifest, _ = manifest_of(folder_of(tmp_path), tool=(0.0, 0.0, 0.2))
    assert manifest["frames"]["tool"]["xyz_m"] == [0.0, 0.0, 0.2]
    assert set(manifest["frames"]) == {"tool", "ft_sensor", "tracker"}


def test_what_can_be_found_or_left_out_is_not_to_be_written(tmp_path: Path) -> None:
    """The target's place from the unloaded poses; noise and the tool's mass stand as comments with their units."""
    draft = draft_from_folder(folder_of(tmp_path))
    manifest = tomllib.loads(draft.manifest)
    assert manifest["frames"]["target"] == {"parent": "flange", "estimate": True}
    assert "[frames.target]" not in "".join(draft.to_write)
    assert any("[frames.target]" in line for line in draft.guessed)
    comments = "".join(line for line in draft.manifest.splitlines() if line.startswith("#"))
    assert all(entry in comments for entry in ("{ position = 0.015 }", "{ force = 0.5 }", "mass_kg ="))
    # the rows of an unknown robot are one thing to write, not a guess for each number
    rows = tomllib.loads(draft.robot)["joints"]
    assert [len(rows), len({len(row) for row in rows})] == [6, 1]
    assert not [line for line in draft.guessed if line.startswith("robot.toml")]
    assert [line for line in draft.to_write if line.startswith("robot.toml")]


def test_one_run_without_a_name_is_listed(tmp_path: Path) -> None:
    manifest, runs = manifest_of(folder_of(tmp_path, lambda k, device: f"{device}{ENDING[device]}", runs=1))
    assert runs == ["run1"]
    assert len(manifest["runs"][0]["files"]) == 3


@pytest.mark.parametrize(("gone", "source"), [("force", "ft"), ("joints", "controller"), ("tracker", "tracker")])
def test_an_instrument_that_is_missing_is_left_to_be_added(tmp_path: Path, gone: str, source: str) -> None:
    folder_of(tmp_path)
    for path in tmp_path.glob(f"*_{gone}*"):
        path.unlink()
    draft = draft_from_folder(tmp_path, robot="irb4400")
    assert len(draft.runs) == 3
    assert [line for line in draft.to_write if f"[sources.{source}]" in line]
    assert len(draft.to_write) == 3


@pytest.mark.parametrize("device", list(ENDING))
def test_one_log_of_one_instrument(tmp_path: Path, device: str) -> None:
    log = tmp_path / f"take{ENDING[device]}"
    write_log(log, device, 1)
    result = init_campaign(tmp_path / "campaign", tables=[log], robot="irb4400")
    assert result.runs == ["take"]
    assert len([line for line in result.to_write or [] if "[sources." in line]) == 2
    assert (tmp_path / "campaign" / "raw" / log.name).exists()


def test_one_log_without_times_is_an_instrument_s_too(tmp_path: Path) -> None:
    log = tmp_path / "polaris.csv"
    log.write_text("Frame,X [mm],Y [mm],Z [mm]\n" + "".join(f"{n},{n}.5,2.5,3.5\n" for n in range(20)))
    result = init_campaign(tmp_path / "campaign", tables=[log], robot="irb4400")
    assert result.runs == ["polaris"]
    assert len([line for line in result.to_write or [] if "[sources." in line]) == 3


def test_a_rate_that_nothing_states_is_left_to_be_written(tmp_path: Path) -> None:
    folder_of(tmp_path)
    for k in range(1, 4):
        rows = "".join(f"{k + 0.1 * n},2,3\n" for n in range(20))
        (tmp_path / f"pose{k:02d}_tracker.txt").write_text(f"X [mm],Y [mm],Z [mm]\n{rows}")
    draft = draft_from_folder(tmp_path, robot="irb4400")
    assert tomllib.loads(draft.manifest)["sources"]["tracker"]["time"] == {}
    answered = draft_from_folder(tmp_path, robot="irb4400", ask=lambda question: "50" if question.key == "time" else "")
    assert tomllib.loads(answered.manifest)["sources"]["tracker"]["time"] == {"rate_hz": 50.0}


def test_nothing_to_read(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        propose_from_folder(tmp_path / "campaign", tmp_path)
    assert caught.value.faults[0].code is FaultCode.FILE_MISSING
    assert caught.value.faults[0].file == str(tmp_path)  # as it was given


def test_links_out_of_the_folder_are_not_followed(tmp_path: Path) -> None:
    folder_of(tmp_path / "usb")
    secret = tmp_path / "secret.csv"
    shutil.copy(tmp_path / "usb" / "pose01_force.csv", secret)
    (tmp_path / "usb" / "pose09_force.csv").symlink_to(secret)
    draft = draft_from_folder(tmp_path / "usb", robot="irb4400")
    assert "raw/pose09_force.csv" not in draft.copies
    assert len(draft.remarks) == 1


def test_signals_of_one_table_with_rows_of_their_own_are_two_sources(tmp_path: Path) -> None:
    head = "__time,/ft/force/x,/ft/force/y,/ft/force/z,/probe/point/x,/probe/point/y,/probe/point/z\n"
    for k in (1, 2, 3):
        rows = (f"{0.1 * n:.1f},{n},2.5,{k}.5,,,\n{0.1 * n + 0.03:.2f},,,,862.{n},75.{k},391.5\n" for n in range(20))
        (tmp_path / f"P{k}_merged.csv").write_text(head + "".join(rows), "utf-8")
        write_log(tmp_path / f"P{k}_joints.h5", "joints", k)
    manifest, runs = manifest_of(tmp_path)
    assert runs == ["P1", "P2", "P3"]
    rows_of = {
        next(iter(source.keys() & {"wrench", "pose"})): source["rows"]
        for source in manifest["sources"].values()
        if source["file"] == "raw/{run}_merged.csv"
    }
    assert rows_of == {"wrench": "/ft/force/x != ''", "pose": "/probe/point/x != ''"}


def test_rows_without_a_reading_are_left_out_in_a_folder_too(tmp_path: Path) -> None:
    folder_of(tmp_path, runs=4)
    hidden = tmp_path / "pose04_tracker.txt"  # the last: of the first alone it would not be known
    hidden.write_text(hidden.read_text("utf-8") + "2,1;;;\n", "utf-8")
    manifest, _ = manifest_of(tmp_path)
    (tracker,) = (source for source in manifest["sources"].values() if "pose" in source)
    assert tracker["rows"] == "`X [mm]` != ''"


def test_single_logs_of_different_lengths_are_logs_and_no_tables(tmp_path: Path) -> None:
    (tmp_path / "force.csv").write_text(
        "t [s],Fx,Fy,Fz\n" + "".join(f"{k / 50},{k},1.5,2.5\n" for k in range(90)), "utf-8"
    )
    (tmp_path / "arm.csv").write_text(
        "t [s],X,Y,Z\n" + "".join(f"{k / 3},862.{k},75.5,391.5\n" for k in range(6)), "utf-8"
    )
    axes = "".join(f"{k / 40},0,-70,60,10,4{k % 10},-30\n" for k in range(70))
    (tmp_path / "axes.csv").write_text("t [s],A1,A2,A3,A4,A5,A6\n" + axes, "utf-8")
    init_campaign(
        tmp_path / "new", tables=[tmp_path / f"{name}.csv" for name in ("force", "arm", "axes")], robot="kr125"
    )
    manifest = tomllib.loads((tmp_path / "new" / "campaign.toml").read_text("utf-8"))
    assert len(manifest["sources"]) == len(manifest["runs"][0]["files"]) == 3


def test_a_tool_point_for_load_and_target_both_is_marked(tmp_path: Path) -> None:
    draft = draft_from_folder(folder_of(tmp_path), robot="irb4400", tool=(0.0, 0.0, 0.2))
    assert any("xyz_m" in line and "both" in line for line in draft.guessed)


def test_a_wrong_answer_is_asked_for_again(monkeypatch: pytest.MonkeyPatch) -> None:
    from stiffcal.cli.init import _ask

    answers = iter(["0,0", "here", "0, 0, 0.2"])
    monkeypatch.setattr("typer.prompt", lambda *args, **options: next(answers))
    assert _ask(Question("frames.tool", "xyz_m", "where it is")) == "0, 0, 0.2"
    monkeypatch.setattr("typer.prompt", lambda *args, **options: "")
    assert _ask(Question("frames.tool", "xyz_m", "where it is")) == ""


def test_a_folder_with_one_table_of_runs_is_that_table(tmp_path: Path) -> None:
    """Next to the robot file that is named: twelve poses were "1 run: states", and robot.toml was in the way."""
    practice = Path(__file__).parents[2] / "campaigns" / "hidden" / "03"
    lab = tmp_path / "lab"
    shutil.copytree(practice / "raw", lab / "raw")
    shutil.copy(practice / "robot.toml", lab)
    before = (lab / "robot.toml").read_bytes()
    init_campaign(lab, tables=[lab / "raw"], robot=str(lab / "robot.toml"), tool=(0.06, -0.04, 0.1))
    source = tomllib.loads((lab / "campaign.toml").read_text("utf-8"))["sources"]
    assert [one["run"] for one in source.values()] == [{"column": "run"}]
    assert (lab / "robot.toml").read_bytes() == before


def test_another_robot_file_is_in_the_way(tmp_path: Path) -> None:
    practice = Path(__file__).parents[2] / "campaigns" / "hidden" / "03"
    (tmp_path / "robot.toml").write_text("# mine\n", "utf-8")
    with pytest.raises(InputError) as refused:
        init_campaign(tmp_path, tables=[practice / "raw"], robot=str(practice / "robot.toml"), tool=(0.06, -0.04, 0.1))
    assert refused.value.code is FaultCode.FILE_EXISTS
    assert (tmp_path / "robot.toml").read_text("utf-8") == "# mine\n"
