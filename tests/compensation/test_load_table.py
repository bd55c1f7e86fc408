"""Tables that people write for a command: names of others, units, and what may not have been meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.compensation.load_table import LoadTable, load_table_of, read_load_table
from stiffcal.compensation.table_columns import ANGLES, AXES, POSITION, QUATERNION
from stiffcal.compensation.table_doubts import deflection_doubts
from stiffcal.compensation.written_table import read_table
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from tests.laboratory.offered_toml import offers_in

NAMES = ("A1", "A2", "A3", "A4", "A5", "A6")
JOINTS = ",".join(NAMES)
POSE = "10,-70,20,15,40,10"


def read(folder: Path, header: str, *rows: str, names: tuple[str, ...] = NAMES) -> LoadTable:
    file = folder / "poses.csv"
    file.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return read_load_table(file, names, joints_needed=True)


@pytest.mark.parametrize(
    "header",
    [
        "Fx,Fy,Fz,Mx,My,Mz",
        "fx,fy,fz,tx,ty,tz",
        "FX,FY,FZ,MX,MY,MZ",
        "F_x,F_y,F_z,M_x,M_y,M_z",
        "Force_x,Force_y,Force_z,Moment_x,Moment_y,Moment_z",
        "force.x,force.y,force.z,torque.x,torque.y,torque.z",
        "wrench.force.x,wrench.force.y,wrench.force.z,wrench.torque.x,wrench.torque.y,wrench.torque.z",
        "Kraft X,Kraft Y,Kraft Z,Drehmoment X,Drehmoment Y,Drehmoment Z",
        "X Force,Y Force,Z Force,X Torque,Y Torque,Z Torque",
        "TCP_Fx,TCP_Fy,TCP_Fz,TCP_Tx,TCP_Ty,TCP_Tz",
        "Fx [N],Fy [N],Fz [N],Mx [Nm],My [Nm],Mz [Nm]",
        "Fx (N),Fy (N),Fz (N),Mx (N m),My (N m),Mz (N m)",
        "Fx/kN,Fy/kN,Fz/kN,Mx/Nmm,My/Nmm,Mz/Nmm",
        "Fx_kN,Fy_kN,Fz_kN,Mx in Nmm,My in Nmm,Mz in Nmm",
    ],
)
def test_names_of_others_are_read(header: str, tmp_path: Path) -> None:
    force, moment = (0.001, 1000.0) if "kN" in header else (1.0, 1.0)
    numbers = [1.0 * force, 2.0 * force, -300.0 * force, 4.0 * moment, 50.0 * moment, 6.0 * moment]
    table = read(tmp_path, f"{JOINTS},{header}", f"{POSE},{','.join(map(str, numbers))}")
    np.testing.assert_allclose(table.wrench, [[1.0, 2.0, -300.0, 4.0, 50.0, 6.0]])
    assert table.doubts == ()
    shown = load_table_of(
        dict(
            zip(
                f"{JOINTS},{header}".split(","),
                map(np.atleast_1d, [*map(float, POSE.split(",")), *numbers]),
                strict=True,
            )
        ),
        NAMES,
    )
    np.testing.assert_allclose(shown.wrench, table.wrench)


def test_a_row_of_units_is_read(tmp_path: Path) -> None:
    units = ",".join(["rad"] * 6 + ["kN", "kN", "kN"])
    table = read(tmp_path, f"{JOINTS},Fx,Fy,Fz", units, "0.1,-1.2,0.3,0.2,0.7,0.1,0,0,-0.3")
    assert table.joints[0, 1] == -1.2
    assert table.wrench[0, 2] == pytest.approx(-300.0)
    assert table.doubts == ()


@pytest.mark.parametrize(
    "header",
    ["q1,q2,q3,q4,q5,q6", "J1,J2,J3,J4,J5,J6", "axis 0,axis 1,axis 2,axis 3,axis 4,axis 5", "a1,a2,a3,a4,a5,a6"],
)
def test_joints_by_other_names(header: str, tmp_path: Path) -> None:
    table = read(tmp_path, f"{header},Fz", f"{POSE},-300")
    np.testing.assert_allclose(np.degrees(table.joints), [[10, -70, 20, 15, 40, 10]])


@pytest.mark.parametrize("header", ["t,S,L,U,R,B,T,Fz", "S,L,U,R,B,T,Fz,t"])
def test_a_time_is_no_joint(header: str, tmp_path: Path) -> None:
    cells = dict(zip("SLURBT", POSE.split(","), strict=True)) | {"Fz": "-300", "t": "7.5"}
    table = read(tmp_path, header, ",".join(cells[name] for name in header.split(",")))
    np.testing.assert_allclose(np.degrees(table.joints), [[10, -70, 20, 15, 40, 10]])


def test_joints_called_like_axes_are_joints(tmp_path: Path) -> None:
    file = tmp_path / "poses.csv"
    file.write_text("X,Y,Z,Fz\n100,200,300,-10\n")
    table = read_load_table(file, ("X", "Y", "Z"), joints_needed=True, prismatic=("X", "Y", "Z"))
    np.testing.assert_allclose(table.joints, [[0.1, 0.2, 0.3]])


@pytest.mark.parametrize(
    ("header", "row", "code"),
    [
        (f"{JOINTS},Fz,Rx,Ry,Rz", f"{POSE},-300,0,50,0", FaultCode.COLUMN_AMBIGUOUS),
        (f"{JOINTS},Fz,Mx,Tx", f"{POSE},-300,0,0", FaultCode.COLUMN_DUPLICATE),
        (f"{JOINTS},Fz,fz", f"{POSE},-300,0", FaultCode.COLUMN_DUPLICATE),
        (f"{JOINTS},Fz [mm]", f"{POSE},-300", FaultCode.UNIT_UNKNOWN),
        ("A1,A2,A3,Fz", "1,2,3,4", FaultCode.COLUMN_MISSING),
        (f"{JOINTS},Fz", f"{POSE},x", FaultCode.NUMBER_INVALID),
    ],
)
def test_what_is_refused(header: str, row: str, code: FaultCode, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        read(tmp_path, header, row)
    (fault,) = refused.value.faults
    assert fault.code is code
    assert fault.place.startswith("line ")
    assert fault.mend


@pytest.mark.parametrize("name", ["note", "Fq", "Tx [mm]", "Rx [rad]", "X", "t", "dx", "reaction"])
def test_columns_that_are_not_read_are_named(name: str, tmp_path: Path) -> None:
    (doubt,) = read(tmp_path, f"{JOINTS},Fz,{name}", f"{POSE},-300,1").doubts
    assert name.split(" ")[0] in doubt
    assert "poses.csv" in doubt


def test_rx_next_to_moments_is_none(tmp_path: Path) -> None:
    (doubt,) = read(tmp_path, f"{JOINTS},Fz,Ty,Rx", f"{POSE},-300,5,1").doubts
    assert "Rx" in doubt


def test_a_delimiter_at_the_end_of_the_lines_is_no_column(tmp_path: Path) -> None:
    assert read(tmp_path, f"{JOINTS},Fz,", f"{POSE},-300,").doubts == ()
    assert len(read(tmp_path, f"{JOINTS},Fz,", f"{POSE},-300,5").doubts) == 1


def test_loads_that_are_missing_are_named(tmp_path: Path) -> None:
    assert len(read(tmp_path, JOINTS, POSE).doubts) == 1


RADIANS = "0.1745,-1.2217,0.3491,0.2618,0.6981,0.1745"


@pytest.mark.parametrize(
    ("header", "rows", "doubted"),
    [
        (JOINTS, [RADIANS], True),
        (JOINTS, [RADIANS, "3.1,-6.2,0,0,0,0"], True),
        (JOINTS, [POSE], False),
        (JOINTS, [RADIANS, POSE], False),
        (JOINTS, ["0,0,0,0,0,0"], False),
        (JOINTS, ["0,0,0,0,5,0"], False),
        (JOINTS.replace("A1", "A1 [rad]"), [RADIANS], False),
        (",".join(f"{name} [deg]" for name in NAMES), [RADIANS], False),
    ],
)
def test_radians_read_as_degrees_are_doubted(header: str, rows: list[str], doubted: bool, tmp_path: Path) -> None:
    doubts = read(tmp_path, f"{header},Fz", *(f"{row},-300" for row in rows)).doubts
    assert len(doubts) == doubted


def deflected(size: float) -> Floats:
    return np.array([[size, 0.0, 0.0, 0.0, 0.0, 0.0]])


def test_loads_in_another_unit_are_doubted() -> None:
    load = np.array([[0.0, 0.0, -0.3, 0.0, 0.0, 0.0]])
    assert len(deflection_doubts(deflected(1e-6), load, "poses.csv", "write it")) == 1
    assert deflection_doubts(deflected(1e-6), load, "poses.csv", "") == []  # stated: it is meant
    assert deflection_doubts(deflected(1e-3), 1e3 * load, "poses.csv", "write it") == []
    assert len(deflection_doubts(deflected(0.2), 1e6 * load, "poses.csv", "")) == 1
    assert deflection_doubts(deflected(0.0), 0.0 * load, "poses.csv", "write it") == []


def test_the_path_and_its_orientation_by_other_names(tmp_path: Path) -> None:
    file = tmp_path / "path.csv"
    file.write_text("time;pos_x;pos_y;pos_z;q0;qx;qy;qz;Segment\n0;1,5;2;3;1;0;0;0;a\n")
    table = read_table(file, NAMES, (*NAMES, *POSITION, *QUATERNION, *ANGLES, *AXES, "t"), ("segment",))
    assert table.block(POSITION).tolist() == [[1.5e-3, 2e-3, 3e-3]]
    assert table.has(QUATERNION)
    assert table.has(["t"])
    assert table.words["segment"] == ("a",)
    assert table.unused == ()


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize(("delimiter", "mark"), [(",", "."), (";", ","), ("\t", ","), (" ", ".")])
def test_text_is_read_however_it_is_written(encoding: str, delimiter: str, mark: str, tmp_path: Path) -> None:
    """As logs are: by one and the same reader. The last line need not end."""
    rows = [
        *([] if delimiter == " " else ["# gemessen in der Prüfhalle"]),
        delimiter.join([*NAMES, "Fz", "größe"]),
        delimiter.join([*POSE.split(","), f"-300{mark}5", f"1{mark}5"]),
        delimiter.join([*POSE.split(","), f"-301{mark}5", f"1{mark}25"]),
    ]
    file = tmp_path / "poses.csv"
    file.write_text("\n".join(rows), encoding=encoding)
    table = read_load_table(file, NAMES, joints_needed=True)
    np.testing.assert_allclose(table.wrench[:, 2], [-300.5, -301.5])
    assert any("größe" in doubt for doubt in table.doubts)


@pytest.mark.parametrize(
    ("row", "code"),
    [
        ("1e31,0,0,0,0,0,-300", FaultCode.NUMBER_INVALID),
        ("1e4,0,0,0,0,0,-300", FaultCode.READING_IMPLAUSIBLE),
        (f"{POSE},-4e5", FaultCode.READING_IMPLAUSIBLE),
        (f"{POSE},", FaultCode.NUMBER_INVALID),
        (f"{POSE},nan", FaultCode.NUMBER_INVALID),
        (f"{POSE},-300 N", FaultCode.NUMBER_INVALID),
        (f'{POSE},"-300,5"', FaultCode.NUMBER_INVALID),
        ("1,2", FaultCode.SHAPE_MISMATCH),
    ],
)
def test_faults_of_a_table_name_nothing_that_only_a_manifest_has(row: str, code: FaultCode, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        read(tmp_path, f"{JOINTS},Fz", f"{POSE},-300.5", row)
    (fault,) = refused.value.faults
    assert fault.code is code
    assert fault.place.startswith("line 3")
    assert not list(offers_in(fault.mend))
    assert "[[" not in fault.mend


def test_components_without_a_column_are_named(tmp_path: Path) -> None:
    (doubt,) = read(tmp_path, f"{JOINTS},Fx,Fz,Tx", f"{POSE},1,-300,5").doubts
    assert "Fy" in doubt
