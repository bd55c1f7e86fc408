"""Every mistake in a user's numbers is one line with exit 2, that names the file, the place and what to write."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.robot.sizes import gravity_mistake, implausible_length, mass_mistake
from stiffcal.cli.app import main
from stiffcal.commands.compare import compare_campaigns
from stiffcal.commands.identify import identify_campaign
from stiffcal.compensation.load_table import read_load_table
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.propose.table_sniffing import sniff_table
from tests.laboratory.campaign_folders import MANIFEST, ROBOT, changed, write_campaign
from tests.laboratory.small_campaign import write_small_campaign

URDF_CAMPAIGN = 'schema = "stiffcal/robot/1"\nurdf = "robot.urdf"\n'
URDF = '<robot name="r"><link name="base"/>' + "".join(
    f'<link name="l{k}"><inertial><origin xyz="0 0 0.1"/><mass value="10"/></inertial></link>'
    f'<joint name="A{k}" type="revolute"><parent link="{"base" if k == 1 else f"l{k - 1}"}"/><child link="l{k}"/>'
    f'<origin xyz="0 0 0.3" rpy="0 {k % 2} 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>'
    for k in range(1, 7)
) + "</robot>"  # fmt: skip


DEFLECTIONS = """schema = "stiffcal/campaign/1"
robot = "robot.toml"
[sources.table]
file = "raw/table.csv"
run = { each = "row" }
joints = { position = "A1..A6", units = { position = "deg" } }
wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, axes = "base", point = "flange" }
deflection = { translation = ["dx", "dy", "dz"], units = { translation = "mm" }, body = "flange", axes = "base" }
"""


def fault_of(folder: Path) -> str:
    """Return the one line about a campaign that cannot be loaded."""
    with pytest.raises(InputError) as caught:
        load_campaign(folder, check_files=False)
    assert len(caught.value.faults) == 1, caught.value
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        (
            "d_m = 0.3",
            "d_m = 300",
            "robot.toml: joints[1] (A1).d_m: 300 m exceeds the size of any robot; 300 looks like mm: write 0.3",
        ),
        (
            "d_m = 0.3",
            "a_m = -1200.0",
            "robot.toml: joints[1] (A1).a_m: -1200 m exceeds the size of any robot; -1200 looks like mm: write -1.2",
        ),
        (
            "d_m = 0.3",
            "bearing_m = 1e30",
            "robot.toml: joints[1] (A1).bearing_m: 1e+30 m exceeds the size of any robot; write it in m",
        ),
        (
            "d_m = 0.3",
            "link = { mass_kg = 2e6, com_m = [0, 0, 0.1] }",
            (
                "robot.toml: joints[1] (A1).link.mass_kg: 2000000 kg exceeds the mass of any robot; "
                "2000000 looks like g: write 2000"
            ),
        ),
        (
            "d_m = 0.3",
            "link = { mass_kg = 2, com_m = [0, 0, 150] }",
            "robot.toml: joints[1] (A1).link.com_m: 150 m exceeds the size of any robot; 150 looks like mm: write 0.15",
        ),
        (
            "d_m = 0.3",
            "theta_deg = 1e9",
            "robot.toml: joints[1] (A1).theta_deg: 1e+09° is more than a hundred turns; write the angle in degrees",
        ),
        (
            "d_m = 0.3",
            "gear_ratio = 1e-9",
            "robot.toml: joints[1] (A1).gear_ratio: a ratio of 1e-09; write a ratio of 1/1e+06 to 1e+06",
        ),
        (
            "d_m = 0.3",
            "d_m = 1e-300",
            (
                "robot.toml: joints[1] (A1).d_m: 1e-300 is smaller than any plausible value; "
                "write 0, or the intended number"
            ),
        ),
        (
            'convention = "modified-dh"',
            'convention = "dh"\ngravity_mps2 = [0, 0, -9810]',
            "robot.toml: gravity_mps2: gravity of 9810 m/s²; 9810 looks like mm/s²: write 9.81",
        ),
        (
            'convention = "modified-dh"',
            'convention = "dh"\nflange = { xyz_m = [0, 0, 140] }',
            "robot.toml: flange.xyz_m: 140 m exceeds the size of any robot; 140 looks like mm: write 0.14",
        ),
    ],
)
def test_a_robot_in_another_unit_is_refused_with_the_number_to_write(
    old: str, new: str, line: str, tmp_path: Path
) -> None:
    assert fault_of(write_campaign(tmp_path / "c", robot=changed(ROBOT, (old, new)))) == f"{line} [value-invalid]"


def test_a_tool_in_another_unit_is_refused_with_the_number_to_write(tmp_path: Path) -> None:
    tool = "\n[tool]\nmass_kg = 12.0\ncom_m = [0.0, 0.0, 190.0]\n"
    line = "campaign.toml: tool.com_m: 190 m exceeds the size of any robot; 190 looks like mm: write 0.19"
    assert fault_of(write_campaign(tmp_path / "c", MANIFEST + tool)) == f"{line} [value-invalid]"


def test_a_frame_on_the_robot_is_near_it_and_a_tracker_stands_anywhere(tmp_path: Path) -> None:
    near = "xyz_m = [0.0, 0.0, 0.2]"
    far = changed(MANIFEST, (near, "xyz_m = [0.0, 0.0, 60.0]"))
    line = "campaign.toml: frames.tool.xyz_m: 60 m exceeds the size of any robot; 60 looks like mm: write 0.06"
    assert fault_of(write_campaign(tmp_path / "c", far)) == f"{line} [value-invalid]"
    plant = MANIFEST + '\n[frames.plant]\nparent = "base"\nxyz_m = [4512.0, -812.5, 3.0]\n'
    load_campaign(write_campaign(tmp_path / "plant", plant), check_files=False)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            'xyz="0 0 0.3"',
            'xyz="0 nan 0.3"',
            'robot.urdf: joint A1, origin xyz: "0 nan 0.3" is not three finite numbers',
        ),
        ('xyz="0 0 0.3"', 'xyz="0 0 inf"', 'robot.urdf: joint A1, origin xyz: "0 0 inf" is not three finite numbers'),
        (
            'xyz="0 0 0.3"',
            'xyz="0 0 300"',
            "robot.urdf: joint A1, origin xyz: 300 m exceeds the size of any robot; 300 looks like mm: write 0.3",
        ),
        (
            'rpy="0 1 0"',
            'rpy="0 90000 0"',
            "robot.urdf: joint A1, origin rpy: rpy: 90000 rad is more than a hundred turns",
        ),
        ('axis xyz="0 0 1"', 'axis xyz="nan 0 1"', 'robot.urdf: joint A1, axis: "nan 0 1" is not three finite numbers'),
        (
            'axis xyz="0 0 1"',
            'axis xyz="0 0 -inf"',
            'robot.urdf: joint A1, axis: "0 0 -inf" is not three finite numbers',
        ),
        ('mass value="10"', 'mass value="-10"', "robot.urdf: link l1, mass: a mass of -10 kg"),
        ('mass value="10"', 'mass value="nan"', 'robot.urdf: link l1, mass: "nan" is not a number'),
        ('mass value="10"', 'mass value="inf"', "robot.urdf: link l1, mass: inf kg exceeds the mass of any robot"),
        ('lower="-3"', 'lower="nan"', 'robot.urdf: joint A1: "nan" is not a number'),
    ],
)
def test_a_urdf_with_numbers_that_are_none_is_one_line(old: str, new: str, words: str, tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c", robot=URDF_CAMPAIGN)
    (folder / "robot.urdf").write_text(changed(URDF, (old, new)), encoding="utf-8")
    assert fault_of(folder).startswith(words)


@pytest.mark.parametrize("axis", ["0 0 1e-300", "0 0 1e300", "1e-320 0 0", "1e-300 1e-300 0"])
def test_the_length_of_a_urdf_axis_does_not_matter(axis: str, tmp_path: Path) -> None:
    import numpy as np

    folder = write_campaign(tmp_path / "c", robot=URDF_CAMPAIGN)
    (folder / "robot.urdf").write_text(changed(URDF, ('axis xyz="0 0 1"', f'axis xyz="{axis}"')), encoding="utf-8")
    with np.errstate(all="raise", under="ignore"):
        chain = load_campaign(folder, check_files=False).chain
    assert np.isfinite(chain.fixed).all()
    assert np.allclose(np.linalg.det(chain.fixed[0, :3, :3]), 1.0)


@pytest.mark.parametrize("value", [5e-324, -1e-320, 1e308, float("inf"), float("nan")])
def test_every_number_has_words(value: float) -> None:
    assert "\n" not in str(implausible_length(value))
    assert "\n" not in str(mass_mistake(value))
    assert "\n" not in str(gravity_mistake((0.0, 0.0, value)))


@pytest.mark.parametrize(
    ("file", "old", "new", "place", "mend"),
    [
        ("robot.toml", "mass_kg = 100", "mass_kg = 100000", "joints (A3).link.mass_kg: ", "if it is in g, write 100"),
        (
            "robot.toml",
            "com_m = [0.4, 0.0, 0.06]",
            "com_m = [400.0, 0.0, 60.0]",
            "joints[2] (A2).link.com_m: ",
            "400 looks like mm: write 0.4",
        ),
        (
            "robot.toml",
            "com_m = [0.08, 0.15, 0.0]",
            "com_m = [80.0, 75.0, 0.0]",
            "joints (A3).link.com_m: ",
            "if com_m is in mm, divide it by 1000",
        ),
        (
            "campaign.toml",
            'force = "N"',
            'force = "kN"',
            "wrench: ",
            "if the log is in N or kN, state it in units.force",
        ),
    ],
)
def test_a_robot_that_finds_no_balance_names_the_number_in_another_unit(
    file: str, old: str, new: str, place: str, mend: str, tmp_path: Path
) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=2)
    text = (folder / file).read_text(encoding="utf-8")
    (folder / file).write_text(changed(text, (old, new)), encoding="utf-8")
    # soft drives, so that the balance is lost whatever the fit makes of it
    soft = ", ".join(f'"joint-compliance.j{k}.c" = {{ value = 2e-5, fixed = true }}' for k in range(1, 7))
    model = (folder / "model.toml").read_text(encoding="utf-8")
    (folder / "model.toml").write_text(model + f"parameters = {{ {soft} }}\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        identify_campaign(folder)
    line = str(caught.value.faults[0])
    assert line.startswith(f"{file}: {place}"), line
    assert mend in line
    if "no equilibrium" in line:
        assert re.search(r"the pose \([-\d., °]+; positions of the model\), under ", line), line
        assert "it rotates " in line


def test_a_load_on_the_command_line_that_is_too_large_is_named_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=2)
    with pytest.raises(SystemExit) as end:
        main(["predict", str(folder), "--load-path", "0,0,0;0,0,1e12", "--at", "0,-70,20,0,30,0"])
    assert end.value.code == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("command line: --load-path 0,0,0;0,0,1e12: no equilibrium of the robot exists in the pose (")
    assert line.endswith("; give smaller loads [no-balance]")


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["simulate", "{}/twin", "--from", "{}", "--seed", "-1"], "command line: --seed: -1 is negative; give a whole"),
        (["map", "{}", "--mass", "inf"], "command line: --mass: inf kg is no mass; give a mass in kg"),
    ],
)
def test_options_out_of_range_are_one_line(
    words: list[str], line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=2)
    model = (folder / "model.toml").read_text(encoding="utf-8")
    values = ", ".join(f'"joint-compliance.j{k}.c" = {{ value = 2e-6 }}' for k in range(1, 7))
    (folder / "model.toml").write_text(model + f"parameters = {{ {values} }}\n", encoding="utf-8")
    (folder / "simulate.toml").write_text(
        'schema = "stiffcal/simulate/1"\n[[runs]]\nid = "a"\njoints_deg = [0, -70, 20, 0, 30, 0]\n', encoding="utf-8"
    )
    with pytest.raises(SystemExit) as end:
        main([word.format(folder) for word in words])
    assert end.value.code == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(line)


def test_a_number_in_a_log_that_nobody_measures_is_named_by_row_and_column(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=1)
    table = folder / "raw" / "states.csv"
    lines = table.read_text(encoding="utf-8").splitlines()
    lines[3] = lines[3].rpartition(",")[0] + ",1e200"
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        identify_campaign(folder)
    assert str(caught.value).startswith("raw/states.csv: row 3, column rz: 1e+200 is larger than any plausible value")


def test_readings_that_are_all_below_what_anything_measures_are_one_line(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=1)
    table = folder / "raw" / "states.csv"
    lines = table.read_text(encoding="utf-8").splitlines()
    lines[1:] = [line.rpartition(",")[0] + ",1e-200" for line in lines[1:]]
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        identify_campaign(folder)
    assert str(caught.value).startswith("raw/states.csv: row 1, column rz: 1e-200, the column's largest number here")


@pytest.mark.parametrize("joint", [5000 * "9", "²"])
def test_a_joint_s_number_that_python_does_not_read_is_one_line(
    tmp_path: Path, joint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=1)
    with pytest.raises(SystemExit) as end:
        main(["add", str(folder), "bearing-tilt", "--joints", joint])
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith("command line: --joints: unknown joint")


def test_a_table_with_a_cell_without_end_is_one_line(tmp_path: Path) -> None:
    table = tmp_path / "poses.csv"
    table.write_text("A1,Fx\n" + "1" * 200_000 + ",2\n")
    for read in (sniff_table, lambda path: read_load_table(path, ("A1",), joints_needed=True)):
        with pytest.raises(InputError, match="not a table: field larger than field limit"):
            read(table)


def test_a_robot_whose_axes_all_meet_the_force_is_checked(tmp_path: Path) -> None:
    joints = "".join(
        f'[[joints]]\nname = "A{k}"\na_m = 0.0\nalpha_deg = {90.0 * (k % 2)}\nd_m = 0.0\n' for k in range(1, 7)
    )
    folder = write_campaign(tmp_path / "c", DEFLECTIONS, 'schema = "stiffcal/robot/1"\nconvention = "dh"\n' + joints)
    rows = "".join(f"{k},{-k},0,10,{2 * k},5,{100 + k},{-k},{50 * k},{k / 10},{-k / 20},0.1\n" for k in range(1, 9))
    (folder / "raw" / "table.csv").write_text("A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz\n" + rows)
    document = document_of(check_campaign(folder))
    assert {joint["says"].partition(":")[0] for joint in document["joints"]} == {"carries no torque in these poses"}


def test_campaigns_whose_models_hold_nothing_free_are_compared(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=2)
    values = ", ".join(f'"joint-compliance.j{k}.c" = {{ value = 2e-6, fixed = true }}' for k in range(1, 7))
    model = (folder / "model.toml").read_text(encoding="utf-8")
    (folder / "model.toml").write_text(model + f"parameters = {{ {values} }}\n", encoding="utf-8")
    assert compare_campaigns(folder, folder).p_value_all is None


@pytest.mark.parametrize("value", [5e-324, -5e-324, 2.5e-310, 1e-300, 1.7e308, 1e25])
def test_tiny_and_huge_numbers_are_written(value: float) -> None:
    from stiffcal.wording import estimate, significant

    assert re.fullmatch(r"−?\d\.\d\d·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", significant(value))
    assert estimate(value, (value * 0.5, value * 1.5))


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (
            ["map", "{}", "--load", "1e308,0,0"],
            "command line: --load: 1e+308 is larger than any plausible ",
        ),
        (["map", "{}", "--load", "0,0,-100", "--at", "nan"], "command line: --at: nan m is beyond the reach"),
        (["map", "{}", "--load", "0,0,-100", "--at", "400"], "command line: --at: 400 m is beyond the reach"),
        (["map", "{}", "--mass", "1e9"], "command line: --mass: 1e+09 kg is more than any"),
        (["predict", "{}", "--poses", "{}/p.csv"], "{}/p.csv: line 2, column Fx: 1e+200 is larger than any "),
    ],
)
def test_loads_and_places_that_no_robot_has_are_one_line(
    words: list[str], line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_small_campaign(tmp_path / "c", poses=2)
    (folder / "p.csv").write_text("A1,A2,A3,A4,A5,A6,Fx\n0,-70,20,0,30,0,1e200\n", encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main([word.format(folder) for word in words])
    assert end.value.code == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(line.format(folder))


@pytest.mark.parametrize("fixed", ["true", "false"])
@pytest.mark.parametrize("value", ["-2e-6", "1.0"])
def test_a_value_in_the_model_that_no_parameter_has_is_named_with_its_range(
    value: str, fixed: str, tmp_path: Path
) -> None:
    write_small_campaign(tmp_path / "c")
    text = (tmp_path / "c" / "model.toml").read_text()
    setting = f'parameters = {{ "joint-compliance.j2.c" = {{ value = {value}, fixed = {fixed} }} }}\n'
    (tmp_path / "c" / "model.toml").write_text(text + setting)
    with pytest.raises(InputError, match=r"possible from 0 to .*; write a value in this range") as refused:
        identify_campaign(tmp_path / "c")
    (fault,) = refused.value.faults
    assert (fault.file, fault.place) == ("model.toml", "parameters.joint-compliance.j2.c")


@pytest.mark.parametrize("row", ["10,-70,30,1,2,3,0,0,100,0,0.1,-0.2", "10,-70,30,1,2,3,0,0,100,0.012,-0.7,-0.066"])
def test_one_reading_written_ten_times_says_nothing_of_signs_or_columns(
    row: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_small_campaign(tmp_path / "c")
    (tmp_path / "c" / "campaign.toml").write_text(DEFLECTIONS)
    header = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz\n"
    (tmp_path / "c" / "raw" / "table.csv").write_text(header + f"{row}\n" * 10)
    with pytest.raises(SystemExit) as ended:
        main(["check", str(tmp_path / "c")])
    assert ended.value.code == 1, capsys.readouterr().err
    assert "not ready" in capsys.readouterr().out
