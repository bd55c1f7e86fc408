"""`init --from`: what is proposed from a table's header and values, and what is refused."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

import pytest

from stiffcal.campaign.columns.column_headers import header_parts
from stiffcal.campaign.columns.column_names import RAW, TRAVEL
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from stiffcal.propose.explained import unused_in_words
from stiffcal.propose.from_table import draft_campaign, propose_campaign
from stiffcal.propose.joint_columns import columns_of_joints
from stiffcal.propose.lines import GUESS
from stiffcal.propose.recognising import recognise
from stiffcal.propose.table_sniffing import SniffedColumn, sniff_table
from stiffcal.propose.time_lines import time_line
from tests.laboratory.campaign_folders import DATA

ROOT = Path(__file__).parents[2]
FANUC = ROOT.parent / "shared" / "data" / "fanuc-r2000ic"

PLAIN = (
    "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz\n10,-80,95,0,30,5,0,0,-500,0.01,0.0,-0.61\n12,-70,90,0,30,5,0,300,0,0,0.5,0\n"
)
GERMAN = """Messprotokoll;Halle 3
Einheit: siehe unten

Achse 1;Achse 2;Achse 3;Achse 4;Achse 5;Achse 6;Kraft X;Kraft Y;Kraft Z;dx;dy;dz;Lauf
rad;rad;rad;rad;rad;rad;kN;kN;kN;µm;µm;µm;
0,10;-1,20;1,10;0,00;0,50;0,10;0,00;0,00;-0,50;10,5;0,1;-610,2;pose1
0,10;-1,20;1,10;0,00;0,50;0,10;0,00;0,30;0,00;0,5;500,1;-0,2;pose1
"""
TOOL = (0.0, 0.0, 0.2)
JOINTS_OF_SEVEN = tuple(f"q{number}" for number in range(1, 8))
BRACKETS = (
    "run,J1 [deg],J2 [deg],J3 [deg],J4 [deg],J5 [deg],J6 [deg],Fx (N),Fy (N),Fz (N),Tx (Nm),Ty (Nm),Tz (Nm),"
    "X [mm],Y [mm],Z [mm]\n"
    "a,1,2,3,4,5,6,0,0,0,0,0,0,1800,900,1200\na,1,2,3,4,5,6,7,8,9,1,2,3,1800,900,1199\n"
)


def table(folder: Path, text: str, name: str = "table.csv", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def deflection_of(text: str) -> tuple[list[str], str]:
    """Return the columns that are taken as a displacement, and what is open about them."""
    role = recognise(sniffed_columns(text)).deflection
    return ([], "") if role is None else ([column.header for column in role.columns], role.doubt)


def sniffed_columns(text: str) -> list[SniffedColumn]:
    names, *rows = (line.split(",") for line in text.splitlines())
    return [
        SniffedColumn(name, header_parts(name).name, header_parts(name).unit, tuple(map(float, cells)))
        for name, *cells in zip(names, *rows, strict=True)
    ]


@pytest.mark.parametrize("word", ["Weg", "Déplacement", "Spostamento", "Desplazamiento", "位移"])
def test_travels_of_axes_are_no_displacements(word: str) -> None:
    travels = [f"{word} {axis}" for axis in "XYZ"]
    held = ",".join(travels)
    assert deflection_of(f"{held}\n0.1,0.2,0.3\n0.4,0.1,0.2") == (travels, TRAVEL)
    assert deflection_of(f"{held}\n100,200,300\n400,100,200") == ([], "")
    assert deflection_of(f"{held},dx,dy,dz\n1,2,3,1,2,3\n4,1,2,4,1,2") == (["dx", "dy", "dz"], "")


@pytest.mark.parametrize("word", ["Verformung", "Déformation", "Deformación", "Deformazione", "変形", "变形"])
def test_a_deformation_is_a_displacement_and_with_a_unit_of_strain_none(word: str) -> None:
    for unit, taken in (("mm", True), ("µm/m", False)):
        names = [f"{word} {axis} [{unit}]" for axis in "XYZ"]
        found, _ = deflection_of(f"{','.join(names)}\n0.1,0.2,0.3\n0.4,0.1,0.2")
        assert found == (names if taken else [])


@pytest.mark.parametrize(
    ("name", "first", "step", "unit"),
    [
        ("Datum", 46356.4271875, 2.3e-7, "day"), ("Datum", 46356.427, 0.001, "day"), ("Datum", 0.0, 1e-5, "s"),
        ("t", 46356.427, 1.2e-5, "day"), ("t", 46356.427, 0.001, "s"),
    ],
)  # fmt: skip
def test_times_as_spreadsheets_count_days(name: str, first: float, step: float, unit: str) -> None:
    column = SniffedColumn(name, name, None, tuple(first + step * k for k in range(9)))
    line = time_line(recognise([column]).time, None)
    assert line is not None
    assert f'unit = "{unit}"' in str(line)


def test_raw_forces_are_taken_where_there_are_no_others() -> None:
    raw = "Fx_raw,Fy_raw,Fz_raw"
    for text, held, doubt in (
        (f"{raw}\n1,2,3\n2,1,3", raw, RAW),
        (f"{raw},Fx,Fy,Fz\n1,2,3,1,2,3\n2,1,3,2,1,3", "Fx,Fy,Fz", ""),
    ):
        force = recognise(sniffed_columns(text)).force
        assert force is not None
        assert (",".join(column.header for column in force.columns), force.doubt) == (held, doubt)
    assert recognise(sniffed_columns("raw_x,raw_y,raw_z\n1,2,3\n2,1,3")).position is None


def test_simple_spreadsheet_in_at_most_fifteen_lines(tmp_path: Path) -> None:
    proposal = propose_campaign(tmp_path / "cell", [table(tmp_path, PLAIN)], robot="irb4400", tool=TOOL)
    lines = [line for line in proposal.manifest.splitlines() if line.strip()]
    assert len(lines) <= 15
    assert "# serial_number" in (tmp_path / "cell" / "campaign.toml").read_text(encoding="utf-8")
    assert {path.name for path in proposal.files} == {"campaign.toml", "robot.toml", "table.csv"}
    campaign = load_campaign(tmp_path / "cell")
    held = campaign.manifest.sources["table"]
    assert held.joints is not None
    assert held.joints.position == ("A1", "A2", "A3", "A4", "A5", "A6")
    assert held.joints.units.position == "deg"
    assert held.deflection is not None
    assert held.deflection.units.translation == "mm"
    assert held.run is not None
    assert held.run.each == "row"
    assert campaign.chain.name == "ABB IRB 4400/60"
    marked = [line for line in lines if GUESS in line]
    assert [line.split(" ", 1)[0] for line in marked] == ["joints", "wrench", "deflection"]
    assert len(proposal.guessed) == 3


def test_units_from_sizes(tmp_path: Path) -> None:
    radians = "q1,q2,q3,fx,fy,fz,dx,dy,dz\n0.1,-1.2,3.1,0,0,9,0,0,{}\n"
    for size, expected in (("-0.0006", "m"), ("-0.6", "mm"), ("-610", "um")):
        text = draft_campaign([table(tmp_path, radians.format(size))]).manifest
        assert f'units = {{ translation = "{expected}" }}' in text
        assert 'units = { position = "rad" }' in text


def test_german_table_with_unit_row(tmp_path: Path) -> None:
    path = table(tmp_path, GERMAN, encoding="latin-1")
    sniffed = sniff_table(path)
    assert sniffed.options == {}  # what one reads, all read
    proposal = draft_campaign([path])
    assert 'joints = { position = "Achse 1..Achse 6", units = { position = "rad" } }\n' in proposal.manifest
    assert 'units = { force = "kN" }' in proposal.manifest
    assert 'units = { translation = "um" }' in proposal.manifest
    assert 'run = { column = "Lauf" }\n' in proposal.manifest
    assert "csv =" not in proposal.manifest
    propose_campaign(tmp_path / "cell", [path], robot="kr125", tool=TOOL)
    assert load_campaign(tmp_path / "cell").manifest.sources["table"].options_of("csv") == {}


def test_units_in_brackets_are_no_guess(tmp_path: Path) -> None:
    proposal = draft_campaign([table(tmp_path, BRACKETS)])
    joints = next(line for line in proposal.manifest.splitlines() if line.startswith("joints"))
    assert joints.startswith('joints = { position = ["J1 [deg]", "J2 [deg]"')
    assert GUESS not in joints
    assert "estimate = true" in proposal.manifest  # positions, not displacements: the tracker's place is to be found
    assert 'moment = "N*m"' in proposal.manifest


def test_dead_weights(tmp_path: Path) -> None:
    text = "run,A1,A2,A3,mass_kg,dx,dy,dz\na,1,2,93,10,0,0,0.1\n"
    proposal = draft_campaign([table(tmp_path, text)])
    assert 'dead_weight = { mass_column = "mass_kg", point = "tool", units = { mass = "kg" } }' in proposal.manifest


def test_urdf_is_copied_next_to_the_robot_file(tmp_path: Path) -> None:
    proposal = propose_campaign(tmp_path / "cell", [table(tmp_path, PLAIN)], urdf=DATA / "six.urdf", tool=TOOL)
    assert tmp_path / "cell" / "six.urdf" in proposal.files
    assert load_campaign(tmp_path / "cell").chain.joint_names[0] == "J1"


def test_a_robot_file_is_taken_as_it_is_and_its_names_find_the_columns(tmp_path: Path) -> None:
    joints = "".join(
        f'[[joints]]\nname = "{name}"\na_m = 0.2\nalpha_deg = 90\n' for name in ("shoulder", "elbow", "wrist")
    )
    text = f'schema = "stiffcal/robot/1"\nconvention = "dh"\n{joints}'
    (tmp_path / "arm.toml").write_text(text, encoding="utf-8")
    rows = "wrist;elbow_std;elbow;shoulder;x;y;z\n0,1;0;0,2;0,3;1;2;3\n0,2;0;0,3;0,4;1;2;4\n"
    proposal = draft_campaign([table(tmp_path, rows)], robot=str(tmp_path / "arm.toml"))
    assert proposal.robot == text
    assert 'position = ["shoulder", "elbow", "wrist"]' in proposal.manifest
    assert 'experiment = "absolute"' in proposal.manifest
    with pytest.raises(InputError, match="no such file"):
        draft_campaign([table(tmp_path, rows)], robot=str(tmp_path / "leg.toml"))


def test_without_a_robot_the_rows_are_to_be_filled_in(tmp_path: Path) -> None:
    proposal = propose_campaign(tmp_path / "cell", [table(tmp_path, PLAIN)], tool=TOOL)
    assert load_campaign(tmp_path / "cell").chain.n_joints == 6
    assert [line.split(":")[0] for line in proposal.to_write] == ["robot.toml"]


@pytest.mark.skipif(not FANUC.is_dir(), reason="the FANUC measurements are not here")
def test_three_files_that_belong_together(tmp_path: Path) -> None:
    files = [FANUC / name for name in ("joint_angles.csv", "forces.csv", "deltaX.csv")]
    proposal = propose_campaign(tmp_path / "fanuc", files, robot="r2000ic", tool=TOOL)
    assert not proposal.unused
    ours = load_campaign(tmp_path / "fanuc")
    bundled = load_campaign(ROOT / "campaigns" / "fanuc-r2000ic", check_files=False)
    assert ours.manifest.sources == bundled.manifest.sources  # column for column, unit for unit, all from the tables
    assert (ours.chain.fixed == bundled.chain.fixed).all()
    assert (ours.chain.coupling == bundled.chain.coupling).all()


def test_table_already_in_raw_is_left_where_it_is(tmp_path: Path) -> None:
    (tmp_path / "cell" / "raw").mkdir(parents=True)
    path = table(tmp_path / "cell" / "raw", PLAIN)
    proposal = propose_campaign(tmp_path / "cell", [path], robot="irb4400", tool=TOOL)
    assert path not in proposal.files
    load_campaign(tmp_path / "cell")


def test_quaternion_is_not_taken_for_joints() -> None:
    names = ["A1", "A2", "A3", "q0", "qx", "qy", "qz", "X", "Y", "Z", "Fx", "Fy", "Fz"]
    roles = recognise(SniffedColumn(name, name, None, (1.0,)) for name in names)
    assert roles.joints is not None
    assert [column.name for column in roles.joints.columns] == ["A1", "A2", "A3"]
    assert roles.quaternion is not None
    assert [column.name for column in roles.quaternion.columns] == ["q0", "qx", "qy", "qz"]
    assert roles.position is not None
    assert not roles.unused


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file is empty"),
        ("a\n1\n", "no columns found"),
        ("1,2,3\n4,5,6\n", "no header"),
        ("a,b,c\nx,y,z\n", "no line of numbers"),
        ("A1,A1,A2\n1,2,3\n", 'two columns have the name "A1"'),
        ("x1,x2,x3\n1,2,3\n", "no joint columns recognised"),
        ("A1,A2,A3,dx,dy,dz\n1,2,3,4,5,6\n", "no force columns recognised.*cannot be used"),
        ("A1,A2,A3,Fx,Fy,Fz\n1,2,3,4,5,6\n", "no displacement or position columns"),
        ("A1 [mm],A2 [mm],A3 [mm],Fx,Fy,Fz,dx,dy,dz\n1,2,3,4,5,6,7,8,9\n", "unit of length"),
        ("A1 [deg],A2 [rad],A3 [deg],Fx,Fy,Fz,dx,dy,dz\n1,2,3,4,5,6,7,8,9\n", "units differ: deg, rad"),
        ("A1\0,A2\n", "not a text file"),
    ],
)
def test_what_cannot_be_understood(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        propose_campaign(tmp_path / "cell", [table(tmp_path, text)])
    assert not (tmp_path / "cell").exists()


def test_robot_that_does_not_fit(tmp_path: Path) -> None:
    five = PLAIN.replace(",A6", "").replace(",5,", ",")
    with pytest.raises(InputError, match="5 joint columns, but the robot has 6 joints"):
        propose_campaign(tmp_path / "cell", [table(tmp_path, five)], robot="irb4400")
    with pytest.raises(InputError, match="no such file"):
        propose_campaign(tmp_path / "cell", [table(tmp_path, PLAIN)], urdf=tmp_path / "no.urdf")
    with pytest.raises(InputError, match="no such file"):
        propose_campaign(tmp_path / "cell", [tmp_path / "no.csv"], robot="irb4400")
    assert not (tmp_path / "cell").exists()


def test_tables_of_unequal_length(tmp_path: Path) -> None:
    one = table(tmp_path, "A1,A2,A3\n1,2,3\n4,5,6\n", "joints.csv")
    two = table(tmp_path, "Fx,Fy,Fz,dx,dy,dz\n1,2,3,4,5,6\n", "rest.csv")
    with pytest.raises(InputError, match=r"1 rows, but 2 in joints.csv"):
        draft_campaign([one, two])


def test_a_campaign_is_not_overwritten(tmp_path: Path) -> None:
    propose_campaign(tmp_path / "cell", [table(tmp_path, PLAIN)], robot="irb4400")
    with pytest.raises(InputError, match="already exists"):
        propose_campaign(tmp_path / "cell", [table(tmp_path, PLAIN)], robot="irb4400")


UR = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")


def urdf(folder: Path, kinds: dict[str, str] | None = None, names: Sequence[str] = UR) -> Path:
    """Write a URDF of a chain of joints, revolute where `kinds` says nothing else."""
    parts = ["<robot name='ur'><link name='base'/>"]
    for k, name in enumerate(names):
        parent = f"l{k - 1}" if k else "base"
        parts.append(
            f"<link name='l{k}'/><joint name='{name}' type='{(kinds or {}).get(name, 'revolute')}'>"
            f"<parent link='{parent}'/><child link='l{k}'/><origin xyz='0 0 0.3'/><axis xyz='0 {k % 2} {1 - k % 2}'/>"
            "</joint>"
        )
    path = folder / "ur.urdf"
    path.write_text("".join([*parts, "</robot>"]), encoding="utf-8")
    return path


def named_table(folder: Path, names: Sequence[str] = UR) -> Path:
    """Write a table whose joint columns stand in another order than in the robot."""
    header = [*reversed(names), "Fx", "Fy", "Fz", "dx", "dy", "dz"]
    rows = [[0.1 * k + 0.3 * row for k in range(len(names))] + [0, 0, -100, 0, 0, -0.0004] for row in range(2)]
    text = "\n".join([",".join(header), *(",".join(map(str, row)) for row in rows)])
    return table(folder, text + "\n")


@pytest.mark.parametrize("names", [UR, tuple(f"joint_a{k}" for k in range(1, 7))])
def test_columns_are_matched_to_the_joints_of_the_urdf(tmp_path: Path, names: tuple[str, ...]) -> None:
    propose_campaign(tmp_path / "cell", [named_table(tmp_path, names)], urdf=urdf(tmp_path, names=names), tool=TOOL)
    campaign = load_campaign(tmp_path / "cell")
    joints = campaign.manifest.sources["table"].joints
    assert joints is not None
    assert joints.position == names
    assert campaign.chain.joint_names == names


@pytest.mark.parametrize(
    ("written", "joint"),
    [
        ("Shoulder_Pan_Joint", "shoulder_pan_joint"),
        ("shoulder_pan", "shoulder_pan_joint"),
        ("position.shoulder_pan_joint", "shoulder_pan_joint"),
        ("A1", "joint_a1"),
    ],
)
def test_spellings_of_a_joint(written: str, joint: str) -> None:
    other = ("velocity.shoulder_pan_joint", "torque shoulder_pan_joint", "A11")
    columns = [SniffedColumn(name, name, None, (1.0,)) for name in (*other, written)]
    assert columns_of_joints(columns, [joint])[joint].header == written


def test_a_rail_and_fingers_without_columns_are_left_out_and_named(tmp_path: Path) -> None:
    robot = urdf(tmp_path, {"rail": "prismatic"}, names=("rail", *UR, "finger"))
    proposal = propose_campaign(tmp_path / "cell", [named_table(tmp_path)], urdf=robot, tool=TOOL)
    assert load_campaign(tmp_path / "cell").chain.joint_names == UR
    marked = [line for line in proposal.guessed if line.startswith("robot.toml")]
    assert [line.split("#")[0].strip() for line in marked] == [
        'robot.toml: base_link = "l0"', 'robot.toml: tip_link = "l6"',
    ]  # fmt: skip
    assert "rail (prismatic)" in marked[0]
    assert "finger (revolute)" in marked[1]


@pytest.mark.parametrize(
    ("kinds", "without", "words"),
    [
        ({"elbow_joint": "planar"}, (), 'joint elbow_joint: the stiffness of a planar .* type "fixed"'),
        ({"elbow_joint": "prismatic"}, (), "elbow_joint.*two ends, and none are given; add <limit"),
        ({}, ("elbow_joint",), "joint elbow_joint: no column .* add the column elbow_joint"),
    ],
)
def test_a_joint_in_the_middle_that_cannot_do_is_named_with_the_cure(
    tmp_path: Path, kinds: dict[str, str], without: tuple[str, ...], words: str
) -> None:
    path = named_table(tmp_path, [name for name in UR if name not in without])
    with pytest.raises(InputError, match=words):
        propose_campaign(tmp_path / "cell", [path], urdf=urdf(tmp_path, kinds))


def test_the_tool_point_is_asked_for_and_not_guessed(tmp_path: Path) -> None:
    proposal = propose_campaign(tmp_path / "cell", [table(tmp_path, PLAIN)], robot="irb4400")
    assert [line.split(" = ")[0] for line in proposal.to_write] == ["campaign.toml [frames.tool] xyz_m"]
    with pytest.raises(InputError, match="frames.tool.xyz_m: not filled in yet"):
        load_campaign(tmp_path / "cell")


@pytest.mark.parametrize(
    ("header", "row", "words"),
    [
        ("Fx,Fy,Fz,X,Y,Z", "0,0,{},1500,20,900", "every row is a different pose: .*unloaded and loaded"),
        ("Fx,Fy,Fz", "0,0,{}", "--kind clamped"),
        ("note1,note2,note3", "0,0,{}", "--kind friction"),
    ],
)
def test_which_experiment_a_table_can_serve(tmp_path: Path, header: str, row: str, words: str) -> None:
    rows = "\n".join(f"{10 * k},{5 * k - 60},{20 + k},{row.format(k)}" for k in range(4))
    with pytest.raises(InputError, match=words):
        propose_campaign(tmp_path / "cell", [table(tmp_path, f"A1,A2,A3,{header}\n{rows}\n")])
    assert not (tmp_path / "cell").exists()


@pytest.mark.parametrize(
    "names", ["X,Y,Z", "measurement_x,measurement_y,measurement_z", "X1,Y1,Z1", "smr1_x,smr1_y,smr1_z"]
)
def test_places_without_loads_are_absolute(tmp_path: Path, names: str) -> None:
    rows = "\n".join(f"{10 * k},{5 * k - 60},{20 + k},{k},{k},{k},1500,20,{900 + k}" for k in range(4))
    path = table(tmp_path, f"A1,A2,A3,A4,A5,A6,{names}\n{rows}\n")
    proposal = propose_campaign(tmp_path / "cell", [path], robot="irb4400")
    assert not proposal.to_write
    campaign = load_campaign(tmp_path / "cell")
    assert [(run.id, run.experiment) for run in campaign.manifest.runs] == [("poses", "absolute")]
    assert campaign.manifest.frames["tool"].estimate
    assert campaign.manifest.frames["tracker"].estimate


def test_a_payload_in_poses_without_unloaded_twins_hangs_at_a_point_of_its_own(tmp_path: Path) -> None:
    rows = "\n".join(f"{10 * k},{5 * k - 60},{20 + k},{k},{k},{k},1500,20,{900 + k},{5 * (k % 2)}" for k in range(4))
    path = table(tmp_path, f"A1,A2,A3,A4,A5,A6,X,Y,Z,kg\n{rows}\n")
    proposal = propose_campaign(tmp_path / "cell", [path], robot="irb4400", tool=(0.0, 0.0, 0.1))
    assert 'experiment = "absolute"' in proposal.manifest
    assert 'dead_weight = { mass_column = "kg", point = "payload"' in proposal.manifest
    with pytest.raises(InputError, match="frames.payload.xyz_m: not filled in yet"):
        load_campaign(tmp_path / "cell")


def test_a_payload_of_zero_in_every_row_asks_for_no_place(tmp_path: Path) -> None:
    rows = "\n".join(f"{10 * k},{5 * k - 60},{20 + k},{k},{k},{k},1500,20,{900 + k},0" for k in range(4))
    path = table(tmp_path, f"A1,A2,A3,A4,A5,A6,X,Y,Z,kg\n{rows}\n")
    proposal = propose_campaign(tmp_path / "cell", [path], robot="irb4400", tool=(0.0, 0.0, 0.1))
    assert "dead_weight" not in proposal.manifest
    assert '# ? "kg" is 0 in the rows that were looked at: no payload' in proposal.manifest
    assert "payload" not in load_campaign(tmp_path / "cell").manifest.frames


@pytest.mark.parametrize(("masses", "is_absolute"), [((0, 5, 0, 5, 0, 5), True), ((0, 5, 0, 0, 5, 5), False)])
def test_a_pose_that_repeats_under_the_same_payload_is_no_unloaded_twin(
    tmp_path: Path, masses: Sequence[int], is_absolute: bool
) -> None:
    # four poses of which two repeat as they were, or three poses without and with the payload
    order = [0, 1, 2, 3, 0, 1] if is_absolute else [0, 1, 2, 1, 0, 2]
    rows = "\n".join(
        f"{10 * k},{5 * k - 60},{20 + k},{k},{k},{k},1500,20,{900 + k},{mass}"
        for k, mass in zip(order, masses, strict=True)
    )
    path = table(tmp_path, f"A1,A2,A3,A4,A5,A6,X1,Y1,Z1,kg\n{rows}\n")
    proposal = propose_campaign(tmp_path / "cell", [path], robot="irb4400", tool=(0.0, 0.0, 0.1))
    assert ('experiment = "absolute"' in proposal.manifest) == is_absolute


def test_a_time_that_does_not_advance_is_no_order_of_rows(tmp_path: Path) -> None:
    rows = "\n".join(f"2.02e13,{10 * k},{5 * k - 60},{20 + k},{k},{k},{k},1500,20,{900 + k}" for k in range(4))
    path = table(tmp_path, f"Timestamp,A1,A2,A3,A4,A5,A6,X,Y,Z\n{rows}\n")
    assert "time =" not in propose_campaign(tmp_path / "cell", [path], robot="irb4400").manifest


def _places(names: Sequence[str], values: Sequence[Sequence[float]], folder: Path) -> Path:
    """Write joint angles in rad and the given columns, a row each."""
    lines = [",".join([*JOINTS_OF_SEVEN, *names])]
    lines += [
        ",".join(str(0.1 * row + 0.2 * k) for k in range(7)) + "," + ",".join(map(str, own))
        for row, own in enumerate(values)
    ]
    return table(folder, "\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("names", "written"),
    [
        (
            ("measurement_std_x", "measurement_std_y", "measurement_std_z"),
            '["measurement_std_x", "measurement_std_y", "me',
        ),
        (("sigma_x", "sigma_y", "sigma_z"), '["sigma_x", "sigma_y", "sigma_z"]'),
        (("std_marker_x", "std_marker_y", "std_marker_z"), '["std_marker_x", "std_marker_y", "std_marker_z"]'),
        (("sx", "sy", "sz"), '["sx", "sy", "sz"]'),
        (("uncertainty_mm",), '"uncertainty_mm"'),
    ],
)
def test_columns_of_uncertainty_become_sigma(tmp_path: Path, names: Sequence[str], written: str) -> None:
    rows = [[700.0 + row, 200.0, 300.0 - row, *([0.2 + 0.05 * row] * len(names))] for row in range(4)]
    proposal = draft_campaign([_places(("marker_x", "marker_y", "marker_z", *names), rows, tmp_path)])
    assert f"sigma = {{ position = {written}" in proposal.manifest
    assert not proposal.unused


@pytest.mark.parametrize(
    ("names", "scale", "why"),
    [
        (("std_x", "std_y", "std_z"), (0.002, 0.01, 0.05), "varies as the scatter within single readings does"),
        (("sigma_x", "sigma_y", "sigma_z"), (20.0, 20.0, 20.0), "would be 20.0 mm"),
        (("sigma_x [um]", "sigma_y [um]", "sigma_z [um]"), (20.0, 20.0, 20.0), "is in um, the readings in mm"),
        (("sigma_x", "sigma_y", "sigma_z"), (0.1, 0.0, 0.1), "is 0 in"),
    ],
)
def test_uncertainties_that_are_none_of_the_places_are_left_out(
    tmp_path: Path, names: Sequence[str], scale: Sequence[float], why: str
) -> None:
    rows = [[700.0 + row, 200.0, 300.0 - row, *([value] * 3)] for row, value in enumerate(scale)]
    proposal = draft_campaign([_places(("x", "y", "z", *names), rows, tmp_path)])
    lines = [line for line in proposal.manifest.splitlines() if "left out" in line]
    assert all(line.startswith(GUESS) for line in lines)
    assert [why in line for line in lines] == [True]


@pytest.mark.parametrize("form", ["smr{}_{}", "{1}{0}", "{1}_{0}"])
def test_each_of_several_targets_is_a_frame_and_may_be_hidden(tmp_path: Path, form: str) -> None:
    names = [form.format(number, axis) for number in (1, 2, 3) for axis in "xyz"]
    seen = [
        [float("nan") if (row + column // 3) % 3 else 0.1 * column + row for column in range(9)] for row in range(6)
    ]
    proposal = draft_campaign([_places(names, seen, tmp_path)])
    assert not proposal.unused
    document = tomllib.loads(proposal.manifest)
    poses, frames = document["sources"]["table"]["poses"], document["frames"]
    assert [pose["position"] for pose in poses.values()] == [names[k : k + 3] for k in (0, 3, 6)]
    assert all(pose["units"] == {"position": "m"} for pose in poses.values())
    assert all(frames[name] == {"parent": "flange", "estimate": True, "xyz_m": [0.0, 0.0, 0.0]} for name in poses)


JOINT_NAMES = "A1,A2,A3,A4,A5,A6"


@pytest.mark.parametrize(
    "moments", ["Mx,My,Mz", "Tx,Ty,Tz", "Moment_x,Moment_y,Moment_z", "torque.x,torque.y,torque.z", "M_x,M_y,M_z"]
)
def test_moments_by_the_names_of_others(moments: str, tmp_path: Path) -> None:
    text = f"{JOINT_NAMES},Fx,Fy,Fz,{moments},dx,dy,dz\n1,-72,93,4,55,6,0,0,-500,1,2,3,0.1,0,-0.6\n"
    proposal = draft_campaign([table(tmp_path, text)])
    wrench = tomllib.loads(proposal.manifest)["sources"]["table"]["wrench"]
    assert wrench["columns"][3:] == moments.split(",")
    assert proposal.unused == ()


def test_tx_in_millimetres_is_a_translation(tmp_path: Path) -> None:
    text = f"{JOINT_NAMES},Fx,Fy,Fz,Tx [mm],Ty [mm],Tz [mm]\n1,-72,93,4,55,6,0,0,-500,0.1,0,-0.6\n"
    source = tomllib.loads(draft_campaign([table(tmp_path, text)]).manifest)["sources"]["table"]
    assert source["deflection"]["translation"] == ["Tx [mm]", "Ty [mm]", "Tz [mm]"]
    assert len(source["wrench"]["columns"]) == 3


def test_rx_without_a_unit_is_a_question(tmp_path: Path) -> None:
    displaced = f"{JOINT_NAMES},Fx,Fy,Fz,dx,dy,dz,{{}}\n1,-72,93,4,55,6,0,0,-500,0.1,0,-0.6,0.001,0.002,0.003\n"
    (line,) = [line for line in draft_campaign([table(tmp_path, displaced.format("Rx,Ry,Rz"))]).guessed if "Rx" in line]
    assert "not moments" in line.split(GUESS)[1]
    with_units = displaced.format("Rx [rad],Ry [rad],Rz [rad]")
    assert not any("not moments" in line for line in draft_campaign([table(tmp_path, with_units)]).guessed)
    # next to places nothing takes a rotation: the columns are named, and may be moments
    rows = "a,1,-72,93,4,55,6,0,0,{},1800,900,1200,1,2,3\n"
    placed = f"run,{JOINT_NAMES},Fx,Fy,Fz,X,Y,Z,Rx,Ry,Rz\n" + rows.format(0) + rows.format(-500)
    proposal = draft_campaign([table(tmp_path, placed)])
    assert [column.column for column in proposal.unused] == ["Rx", "Ry", "Rz"]
    (line,) = [line for line in proposal.guessed if "Rx" in line]
    assert "moments" in line.split(GUESS)[1]


def test_a_strain_is_not_used_for_a_reason_of_its_own(tmp_path: Path) -> None:
    head = f"{JOINT_NAMES},Fx,Fy,Fz,dx,dy,dz,eps1 [µm/m],room"
    proposal = draft_campaign([table(tmp_path, f"{head}\n1,-72,93,4,55,6,0,0,-500,0.1,0,-0.6,12.5,3\n")])
    # each of the two in a sentence of its own
    assert ["eps1" in words for words in unused_in_words(proposal.unused)] == [True, False]
    reasons = {column.column: column.why for column in proposal.columns if not column.taken_as}
    assert len(set(reasons.values())) == 2
