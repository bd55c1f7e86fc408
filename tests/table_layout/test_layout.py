"""The layout of tables as programs of measurement write them: rows of a header, units, numbers, what stands above."""

from __future__ import annotations

import pytest

from stiffcal.table_layout.cells import marks_of
from stiffcal.table_layout.layout import layout_of_rows
from stiffcal.table_layout.text import TextLayout, encoding_of, text_layout

MOTIVE = """Format Version,1.25,Capture Frame Rate,100.000000,Export Frame Rate,50.000000,Length Units,Millimeters

,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker
,Name,plate,plate,plate,plate,plate,plate,plate,plate,m 1,m 1,m 1
,ID,1A,1A,1A,1A,1A,1A,1A,1A,2B,2B,2B
,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,Position,Position
Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z
0,0.00,0,0,0,1,862.1,75.4,391.8,0.1,862.1,75.4,391.8
1,0.02,0,0,0,1,862.2,75.5,391.9,0.1,,,
2,0.04,0,0,0,1,862.2,75.5,391.9,0.1,862.1,75.4,391.8
"""
VICON = """Trajectories
100
,,arm:tool,,,arm:base,,
Frame,Sub Frame,X,Y,Z,X,Y,Z
,,mm,mm,mm,mm,mm,mm
1,0,1.5,2.5,3.5,4.5,5.5,6.5
2,0,1.5,2.5,3.5,4.5,5.5,6.5
"""
QUALISYS = """NO_OF_FRAMES\t2
FREQUENCY\t100
DESCRIPTION\t--
MARKER_NAMES\tprobe\tbase
TRAJECTORY_TYPES\tMeasured\tMeasured
1.5\t2.5\t3.5\t4.5\t5.5\t6.5
1.5\t2.5\t3.5\t0.000\t0.000\t0.000
"""
LABVIEW = """LabVIEW Measurement\t
Separator\tTab
Decimal_Separator\t,
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t3\t3\t
Date\t2026/11/20\t2026/11/20\t
Time\t10:15:30,123456\t10:15:30,123456\t
Y_Unit_Label\tNewton\tNewton\t
X_Dimension\tTime\tTime\t
X0\t0,0000000000000000E+0\t0,0000000000000000E+0\t
Delta_X\t0,020000\t0,020000\t
***End_of_Header***\t\t\t
X_Value\tFx\tFy\tComment
0,000000\t0,250000\t-1,250000
0,020000\t1,250000\t-1,750000\tnote
0,040000\t1,250000\t-1,750000
"""


def laid_out(text: str) -> TextLayout:
    return text_layout(text, "utf-8")


def test_names_of_a_body_what_is_measured_and_the_component_make_one_name() -> None:
    found = laid_out(MOTIVE).rows
    assert found.columns[:4] == ("Frame", "Time (Seconds)", "plate Rotation X", "plate Rotation Y")
    assert found.columns[6:] == (
        *("plate Position X", "plate Position Y", "plate Position Z", "plate Mean Marker Error"),
        *("m 1 Position X", "m 1 Position Y", "m 1 Position Z"),
    )
    assert found.rate_hz == 50.0
    assert {found.units[name] for name in found.columns if "Position" in name} == {"Millimeters"}
    assert not any("Rotation" in name for name in found.units)


def test_a_merged_cell_names_the_columns_to_its_right() -> None:
    found = laid_out(VICON).rows
    assert found.columns[2:] == (*(f"arm:tool {axis}" for axis in "XYZ"), *(f"arm:base {axis}" for axis in "XYZ"))
    assert found.units["arm:base Z"] == "mm"


def test_a_line_of_markers_names_columns_without_a_header() -> None:
    found = laid_out(QUALISYS)
    assert found.rows.columns == (*(f"probe {axis}" for axis in "XYZ"), *(f"base {axis}" for axis in "XYZ"))
    assert (found.rows.rate_hz, found.first_data_line, found.header_line) == (100.0, 6, 0)


def test_two_heads_a_comment_without_a_cell_and_a_decimal_comma() -> None:
    found = laid_out(LABVIEW)
    assert found.rows.columns == ("X_Value", "Fx", "Fy", "Comment")
    assert (found.delimiter, found.rows.decimal, found.rows.shortest, found.rows.rate_hz) == ("\t", ",", 3, 50.0)
    assert found.rows.units == {"Fx": "Newton", "Fy": "Newton"}
    assert found.first_data_line == 16


@pytest.mark.parametrize(
    ("text", "columns", "units"),
    [
        ("t [s];Fx [N]\n0;1\n1;2\n", ("t [s]", "Fx [N]"), {}),
        ('t,"Fx\n[N]"\n0,1\n1,2\n', ("t", "Fx [N]"), {}),
        ("Test 7\n\nt;Fx\ns;N\n0;1\n1;2\n", ("t", "Fx"), {"t": "s", "Fx": "N"}),
        ("t  Fx\n[s]  [N]\n0  1.5\n1  2.5\n", ("t", "Fx"), {"t": "s", "Fx": "N"}),
        ("% t Fx\n0 1.5\n1 2.5\n", ("t", "Fx"), {}),
        ("# t,Fx\n0,1.5\n1,2.5\n", ("t", "Fx"), {}),
        ("t [s]   Fx [N]\n0   1.5\n1   2.5\n", ("t [s]", "Fx [N]"), {}),
        ("t [s] Fx [N] Fy [N]\n0 1.5 1\n1 2.5 2\n", ("t [s]", "Fx [N]", "Fy [N]"), {}),
        ("0 1.5\n1 2.5\n", ("column1", "column2"), {}),
        ("Force [N],,Moment [Nm],\nX,Y,X,Y\n1,2,3,4\n5,6,7,8\n", ("Force X", "Force Y", "Moment X", "Moment Y"), None),
        ("t,Fx,,\n0,1.5,,\n1,2.5,,\n", ("t", "Fx", "", ""), {}),
        ("t,Fx\n0,1.5,\n1,2.5,\n", ("t", "Fx", ""), {}),
        (",t,Fx\n0,0.1,1.5\n1,0.2,2.5\n", ("", "t", "Fx"), {}),
        ("t;Fx\nREAL64;REAL64\n0;1.5\n1;2.5\n", ("t", "Fx"), {}),
    ],
)
def test_headers(text: str, columns: tuple[str, ...], units: dict[str, str] | None) -> None:
    found = laid_out(text).rows
    assert found.columns == columns
    assert units is None or found.units == units


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
def test_encodings(encoding: str) -> None:
    content = "Zeit [s];Drehmoment [N·m];Prüfung\n0;1;2\n".encode(encoding)
    assert content.decode(encoding_of(content)).lstrip("\ufeff").startswith("Zeit [s];Drehmoment [N·m];Prüfung")


@pytest.mark.parametrize(
    ("header", "encoding"),
    [
        ("時間[秒],関節1[度],力X[N],変位X[mm]", "cp932"),
        ("时间(秒),关节1(度),载荷X(N),位移X(mm)", "gb18030"),
        ("시간,A1,Fx,Fy", "cp949"),
        ("Größe;Übergang;Kraft µm;Weg [°]", "cp1252"),
        ("Déplacement;Tête;Événement n°", "cp1252"),
    ],
)
def test_encodings_of_windows(header: str, encoding: str) -> None:
    assert encoding_of(f"{header}\n0,1,2,3\n".encode(encoding)) == encoding


@pytest.mark.parametrize(
    ("cells", "marks"),
    [
        (["1.5", "2,250"], (".", ",")),
        (["1,5", "2.250"], (",", ".")),
        (["1'234.5"], (".", "'")),
        (["1 234,5", "2,5"], (",", " ")),
        (["1,234,567"], (".", ",")),
        (["20.11.2026", "0,5"], (",", "")),
    ],
)
def test_decimal_marks_and_groups(cells: list[str], marks: tuple[str, str]) -> None:
    assert marks_of(cells) == marks


def test_a_header_that_is_known_counts_whatever_else_is_there() -> None:
    rows = [["A", "B"], ["t", "Fx"], ["0", "1"], ["1", "2"]]
    assert layout_of_rows(rows, header_row=0).first_data_row == 1
    assert layout_of_rows(rows, wanted=("t", "Fx")).header_row == 1


def test_a_row_of_units_is_one_for_columns_without_a_unit_too() -> None:
    rows = [["Zeit", "Fx", "Fy"], ["", "N", "N"], ["2026-11-20 10:15:30", "1", "2"], ["2026-11-20 10:15:31", "2", "2"]]
    for wanted in ((), ("Zeit",), ("Fx",)):
        assert layout_of_rows(rows, wanted=wanted).first_data_row == 2


def test_a_date_does_not_count_twice_where_blanks_would_cut_it() -> None:
    """With a column of words a tab cuts a smaller share of the cells into numbers than blanks do."""
    rows = [f"21.11.2026 10:15:0{k},000\t862,06{k}\t75,47\t391,83\tok" for k in range(9)]
    found = text_layout("\n".join(["Zeitpunkt\tX / mm\tY / mm\tZ / mm\tStatus", *rows, ""]), "utf-8")
    assert (found.delimiter, found.columns) == ("\t", ("Zeitpunkt", "X / mm", "Y / mm", "Z / mm", "Status"))


@pytest.mark.parametrize("time", ["0,0{k}", ""])
def test_numbers_behind_a_key_are_no_data_above_the_names(time: str) -> None:
    """LabVIEW, where lines leave the comment out: the step of each channel is as wide as a line of data."""
    head = [
        "LabVIEW Measurement",
        "***End_of_Header***",
        "Channels\t3",
        "Delta_X\t0,02\t0,02\t0,02",
        "***End_of_Header***",
    ]
    rows = [f"{time.format(k=k)}\t0,25\t-1,25\t0,2{k}" for k in range(9)]
    text = "\n".join([*head, "X_Value\tFx\tFy\tFz\tComment", *rows, ""])
    for wanted in ((), ("X_Value", "Fx", "Fy", "Fz")):
        found = text_layout(text, "utf-8", wanted=wanted)
        assert (found.columns[:4], found.first_data_line) == (("X_Value", "Fx", "Fy", "Fz"), 7)
