"""A wrong file is reported in one line per fault: file, key path, reason, mend; all faults at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.toml.pruning import unrelated_faults
from stiffcal.documents import document_of
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_campaign
from tests.laboratory.campaign_folders import MANIFEST, ROBOT, changed, write_campaign

PYDANTIC_WORDS = (
    "pydantic",
    "validation error",
    "type=",
    "Input should",
    "model_type",
    "extra_forbidden",
    "For further",
)


def faults_of(folder: Path) -> tuple[Fault, ...]:
    with pytest.raises(InputError) as caught:
        load_campaign(folder)
    for fault in caught.value.faults:
        assert "\n" not in str(fault)
        assert fault.reason
        assert fault.mend
        assert not any(word in str(fault) for word in PYDANTIC_WORDS), str(fault)
    return caught.value.faults


def one_fault(folder: Path) -> Fault:
    faults = faults_of(folder)
    assert len(faults) == 1, [str(fault) for fault in faults]
    return faults[0]


def test_the_unbroken_folder_loads(tmp_path: Path) -> None:
    campaign = load_campaign(write_campaign(tmp_path / "cell2"))
    assert campaign.name == "cell2"
    assert not campaign.model_written
    assert campaign.model.effects[0].joints == (1, 2, 3, 4, 5, 6)
    assert campaign.chain is campaign.chain


FRAMES = '[frames.a]\nparent = "b"\n[frames.b]\nparent = "a"\n'
RUNS = '[[runs]]\nid = "pose1"\n[[runs]]\nid = "pose1"\n'

MANIFEST_FAULTS = {
    "misspelt key": ([("wrench =", "wrensh =")], "sources.table.wrensh", 'did you mean "wrench"'),
    "misspelt nested key": ([("columns =", "colums =")], "sources.table.wrench.colums", 'did you mean "columns"'),
    "key under another name": ([("xyz_m", "xyz")], "frames.tool.xyz", 'did you mean "xyz_m"'),
    "unknown unit": ([('"deg"', '"degrees_of_arc"')], "sources.table.joints.units.position", "rad"),
    "unit of another quantity": ([('force = "N"', 'force = "mm"')], "sources.table.wrench.units.force", "length"),
    "number for a text": ([('"raw/table.csv"', "7")], "sources.table.file", "quotes"),
    "missing schema": ([('schema = "stiffcal/campaign/1"\n', "")], "schema", 'schema = "stiffcal/campaign/1"'),
    "schema of a later version": ([("campaign/1", "campaign/9")], "schema", "stiffcal/campaign/1"),
    "two numbers for a place": ([("[0.0, 0.0, 0.2]", "[0.0, 0.2]")], "frames.tool.xyz_m", "write 3"),
    "force without a point": ([(', point = "tool"', "")], "sources.table.wrench", "its point of application"),
    "wrench without axes": ([(', axes = "base", point', ", point")], "sources.table.wrench", "the axes of the wrench"),
    "unknown frame": ([('body = "tool"', 'body = "tol"')], "sources.table.deflection.body", 'did you mean "tool"'),
    "unknown parent": ([('parent = "flange"', 'parent = "flansh"')], "frames.tool.parent", 'did you mean "flange"'),
    "parents in a circle": ([("[frames.tool]", FRAMES + "[frames.tool]")], "frames.a.parent", "loop"),
    "deflection in moving axes": (
        [('body = "tool", axes = "base"', 'body = "tool", axes = "tool"')],
        "sources.table.deflection.axes",
        "moves with the robot",
    ),
    "rotation not orthogonal": (
        [("xyz_m", "matrix = [[1, 0, 0], [0, 1, 0.1], [0, 0, 1]]\nxyz_m")],
        "frames.tool.matrix",
        "not orthogonal",
    ),
    "mirrored rotation": (
        [("xyz_m", "matrix = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\nxyz_m")],
        "frames.tool.matrix",
        "mirror",
    ),
    "quaternion not unit": (
        [("xyz_m", "quaternion_wxyz = [1, 0.1, 0, 0]\nxyz_m")],
        "frames.tool.quaternion_wxyz",
        "length is 1.00499",
    ),
    "two rotations": (
        [("xyz_m", "quaternion_wxyz = [1, 0, 0, 0]\nrpy_deg = [0, 0, 0]\nxyz_m")],
        "frames.tool.rpy_deg",
        "given twice",
    ),
    "file outside": ([('"raw/table.csv"', '"../table.csv"')], "sources.table.file", "outside the campaign folder"),
    "absolute file": ([('"raw/table.csv"', '"/tmp/table.csv"')], "sources.table.file", "outside the campaign folder"),
    "file missing": ([('"raw/table.csv"', '"raw/tabel.csv"')], "sources.table.file", 'did you mean "table.csv"'),
    "format unknown": ([('"raw/table.csv"', '"raw"')], "sources.table", "does not determine the format"),
    "run of rows not stated": ([('run = { each = "row" }', 'sampling = "states"')], "sources.table", "which run"),
    "log without time": (
        [('run = { each = "row" }', 'run = { column = "run" }\nsampling = "time"')],
        "sources.table",
        "no time",
    ),
    "five columns against six joints": (
        [("A1..A6", "A1..A5")],
        "sources.table.joints.position",
        "5 columns, but robot.toml has 6",
    ),
    "excluded source unknown": (
        [("[sources", 'exclude = [{ source = "tabel", rows = [1], why = "x" }]\n\n[sources')],
        "exclude[1].source",
        'did you mean "table"',
    ),
    "plugin missing": ([("[sources", 'plugins = ["my_effect.py"]\n[sources')], "plugins[1]", "no such file"),
    "one column of two signals": (
        [('"dx", "dy", "dz"', '"A2", "dy", "A3"')],
        "sources.table.deflection.translation",
        'column "A2" is named in sources.table.joints.position as well',
    ),
    "one column of two quantities of a signal": (
        [('"dz"]', '"dz"], rotation = ["rx", "dy", "rz"]')],
        "sources.table.deflection.rotation",
        'column "dy" is named in sources.table.deflection.translation as well',
    ),
    "infinite number": ([("[0.0, 0.0, 0.2]", "[0.0, 0.0, inf]")], "frames.tool.xyz_m[3]", "finite"),
}


@pytest.mark.parametrize("name", MANIFEST_FAULTS)
def test_manifest_fault_is_named(tmp_path: Path, name: str) -> None:
    changes, place, words = MANIFEST_FAULTS[name]
    fault = one_fault(write_campaign(tmp_path / "c", changed(MANIFEST, *changes)))
    assert fault.file == "campaign.toml"
    assert fault.place == place
    assert words in str(fault)


def test_keys_of_joints_may_share_columns(tmp_path: Path) -> None:
    """Where only the commanded angles are logged they are the position too."""
    keys = 'position = "A1..A6", command = "A1..A6"'
    load_campaign(write_campaign(tmp_path / "c", changed(MANIFEST, ('position = "A1..A6"', keys))))


def test_two_runs_with_one_name(tmp_path: Path) -> None:
    faults = faults_of(write_campaign(tmp_path / "c", MANIFEST + RUNS))
    assert 'runs[2] (pose1): 2 runs have the name "pose1"' in str(faults[0])


def test_toml_syntax_fault_has_its_line(tmp_path: Path) -> None:
    fault = one_fault(write_campaign(tmp_path / "c", changed(MANIFEST, ('robot = "robot.toml"', "robot = robot.toml"))))
    assert (fault.file, fault.place) == ("campaign.toml", "line 2, column 9")
    assert "quotes" in fault.mend


def test_not_utf8(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c")
    (folder / "campaign.toml").write_bytes(b"# line\n# Pr\xfcfstand\n")
    assert one_fault(folder).place == "line 2"


def test_byte_order_mark_is_no_fault(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c")
    (folder / "campaign.toml").write_bytes(b"\xef\xbb\xbf" + MANIFEST.encode())
    load_campaign(folder)


def test_all_faults_of_all_files_at_once(tmp_path: Path) -> None:
    manifest = changed(MANIFEST, ("columns =", "colums ="), ('"deg"', '"degg"'), ("[0.0, 0.0, 0.2]", "[0.2]"))
    robot = changed(ROBOT, ("d_m = 0.3", "d = 0.3"), ("modified-dh", "craig"))
    model = 'schema = "stiffcal/model/1"\nbalanced = "deformed"\n'
    faults = faults_of(write_campaign(tmp_path / "c", manifest, robot, model))
    reported = {fault.file for fault in faults}
    places = {fault.place for fault in faults}
    assert reported == {"campaign.toml", "robot.toml", "model.toml"}
    assert {
        "sources.table.wrench.colums",
        "sources.table.joints.units.position",
        "frames.tool.xyz_m",
        "joints[1] (A1).d",
        "convention",
        "balanced",
    } <= places


def test_a_wrong_key_does_not_hide_the_other_faults(tmp_path: Path) -> None:
    """Wrong keys, missing files, unknown frames and too few columns, all in one go, and no fault by consequence."""
    manifest = changed(
        MANIFEST,
        ("[sources.table]", 'plugin = ["x"]\n[sources.table]'),
        ('"raw/table.csv"', '"raw/tabel.csv"'),
        ("A1..A6", "A1..A5"),
        ('point = "tool"', 'pont = "tool"'),
        ('body = "tool"', 'body = "prob"'),
    )
    places = [fault.place for fault in faults_of(write_campaign(tmp_path / "c", manifest))]
    assert sorted(places) == [
        "plugin",
        "sources.table.deflection.body",
        "sources.table.file",
        "sources.table.joints.position",
        "sources.table.wrench.pont",
    ]


def test_no_fault_follows_from_a_frame_that_could_not_be_read(tmp_path: Path) -> None:
    manifest = changed(MANIFEST, ('parent = "flange"\n', ""))
    assert one_fault(write_campaign(tmp_path / "c", manifest)).place == "frames.tool.parent"


def test_a_fault_is_a_consequence_by_the_names_it_is_about_not_by_its_words() -> None:
    words, names = 'a sentence that quotes "tool"', ("tool",)
    about_it = Fault(FaultCode.FRAME_UNKNOWN, "campaign.toml", "sources.a.pose.body", "any words", "mend", names)
    quoting = Fault(FaultCode.VALUE_INVALID, "campaign.toml", "sources.b.time", words, "mend")
    assert unrelated_faults(["frames.tool"], [about_it, quoting]) == [quoting]


def test_a_run_without_a_name_is_one_fault(tmp_path: Path) -> None:
    manifest = changed(MANIFEST, ("A1..A6", "A1..A5")) + '[[runs]]\nid = "a"\n[[runs]]\nholdout = true\n'
    places = [fault.place for fault in faults_of(write_campaign(tmp_path / "c", manifest))]
    assert places == ["runs[2].id", "sources.table.joints.position"]


ROBOT_FAULTS = {
    "no convention": ([('convention = "modified-dh"\n', "")], "convention", "neither"),
    "both": ([("convention =", 'urdf = "r.urdf"\nconvention =')], "convention", "both"),
    "same name twice": ([('"A2"', '"A1"')], "joints (A1)", "2 joints have the name"),
    "logged joint unknown": ([("d_m = 0.3", "d_m = 0.3\nlogged = { J2 = 1 }")], "joints[1] (A1).logged.J2", "no joint"),
    "limits the wrong way": (
        [("d_m = 0.3", "d_m = 0.3\nlimits_deg = [9, -9]")],
        "joints[1] (A1).limits_deg",
        "not below",
    ),
    "direction of two": ([("d_m = 0.3", "d_m = 0.3\ndirection = 2")], "joints[1] (A1).direction", "1 or -1"),
    "gear ratio zero": ([("d_m = 0.3", "d_m = 0.3\ngear_ratio = 0.0")], "joints[1] (A1).gear_ratio", "zero"),
    "mass without centre": ([("d_m = 0.3", "d_m = 0.3\nlink = { mass_kg = 3 }")], "joints[1] (A1).link", "centre"),
    "flange not a rotation": (
        [("[[joints]]", "[flange]\nquaternion_wxyz = [2, 0, 0, 0]\n[[joints]]")],
        "flange.quaternion_wxyz",
        "length is 2",
    ),
}


@pytest.mark.parametrize("name", ROBOT_FAULTS)
def test_robot_fault_is_named(tmp_path: Path, name: str) -> None:
    changes, place, words = ROBOT_FAULTS[name]
    faults = [
        fault
        for fault in faults_of(write_campaign(tmp_path / "c", robot=changed(ROBOT, *changes)))
        if fault.file == "robot.toml"
    ]
    assert faults[0].place == place
    assert words in str(faults[0])


def test_robot_with_five_joints_against_six_columns(tmp_path: Path) -> None:
    robot = ROBOT[: ROBOT.index('[[joints]]\nname = "A6"')]
    fault = one_fault(write_campaign(tmp_path / "c", robot=robot))
    assert fault.place == "sources.table.joints.position"
    assert fault.reason == "6 columns, but robot.toml has 5 joints"


def test_model_places_are_checked(tmp_path: Path) -> None:
    model = (
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "backlash"\njoints = [7]\n'
        '[[effects]]\ntype = "link-beam"\nlinks = ["boom"]\n'
    )
    faults = faults_of(write_campaign(tmp_path / "c", model=model))
    assert [fault.place for fault in faults] == ["effects[1] (backlash).joints", "effects[2] (link-beam).links"]


def test_missing_pieces(tmp_path: Path) -> None:
    assert "no such folder" in str(one_fault(tmp_path / "nowhere"))
    (tmp_path / "empty").mkdir()
    assert "stiffcal init" in str(one_fault(tmp_path / "empty"))
    folder = write_campaign(tmp_path / "c")
    (folder / "robot.toml").unlink()
    fault = one_fault(folder)
    assert (fault.code, fault.file, fault.place) == (FaultCode.FILE_MISSING, "campaign.toml", "robot")
    assert fault.reason == "no such file: robot.toml"
    assert "stiffcal init DIR --from TABLE.csv --robot NAME" in fault.mend


def test_logs_may_be_missing_where_they_are_not_needed(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c")
    (folder / "raw" / "table.csv").unlink()
    load_campaign(folder, check_files=False)
    assert one_fault(folder).place == "sources.table.file"


LOGS = """schema = "stiffcal/campaign/1"
robot = "robot.toml"
[sources.ft]
time = { rate_hz = 100 }
joints = { position = "A1..A6" }
[[runs]]
id = "a"
files = { ft = "raw/a_ft.csv" }
[[runs]]
id = "b"
files = { ft = "raw/b_ft.csv" }
[[runs]]
id = "c"
files = { ft = "raw/c_ft.csv" }
"""


def with_logs(folder: Path, manifest: str, *names: str) -> Path:
    """Write a folder of logs, empty as they are."""
    write_campaign(folder, manifest)
    for name in names:
        (folder / "raw" / name).write_text("A1\n")
    return folder


def test_a_log_named_by_two_runs(tmp_path: Path) -> None:
    doubled = changed(LOGS, ("raw/b_ft.csv", "raw/a_ft.csv"))
    fault = one_fault(with_logs(tmp_path / "c", doubled, "a_ft.csv", "c_ft.csv"))
    assert str(fault) == (
        "campaign.toml: runs[2] (b).files.ft: raw/a_ft.csv is also used by run a; give the log of this run "
        "[key-conflict]"
    )


@pytest.mark.parametrize(
    "apart",
    [
        ('"b"\n', '"b"\nstates = "raw/b_holds.csv"\n'),
        ("[[runs]]", '[[exclude]]\nsource = "ft"\nrun = "b"\nrows = [1]\nwhy = "of a"\n[[runs]]'),
        ("time = {", 'run = { column = "run" }\nsampling = "time"\ntime = {'),
    ],
    ids=["holds", "rows", "run column"],
)
def test_a_log_of_two_runs_that_are_distinguished(tmp_path: Path, apart: tuple[str, str]) -> None:
    doubled = changed(LOGS, ("raw/b_ft.csv", "raw/a_ft.csv"), apart)
    load_campaign(with_logs(tmp_path / "c", doubled, "a_ft.csv", "c_ft.csv", "b_holds.csv"))


def test_another_runs_log_is_not_suggested_for_a_missing_one(tmp_path: Path) -> None:
    fault = one_fault(with_logs(tmp_path / "c", LOGS, "a_ft.csv", "c_ft.csv"))
    assert fault.reason == "no such file: raw/b_ft.csv"
    assert fault.mend == "add it, or correct the name"
    (tmp_path / "c/raw/B_ft.csv").write_text("A1\n")
    assert one_fault(tmp_path / "c").mend == 'did you mean "B_ft.csv"?'


def test_a_missing_folder_is_one_line(tmp_path: Path) -> None:
    fault = one_fault(write_campaign(tmp_path / "c", LOGS.replace("raw/", "logs/")))
    assert str(fault) == (
        "campaign.toml: runs[1] (a).files.ft: no such folder: logs; 3 files are expected in it, logs/a_ft.csv first; "
        "put the files there [file-missing]"
    )
    missing = document_of(check_campaign(tmp_path / "c"))["missing"]
    assert [line for line in missing if "logs" in line] == ["folder logs: not there yet, 3 files are named in it"]
