"""Logs as instruments' programs write them: what `check` proposes for them reads every value, with no edit."""

from __future__ import annotations

import gzip
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.manifest_type import source_type
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.lines import FrameNames
from stiffcal.propose.log_kind import LogKind, log_kind
from stiffcal.reduction.logs.log_rows import read_rows

N = 40
RNG = np.random.default_rng(7)
TIME = np.arange(N) * 0.02
FORCE = np.round(RNG.normal(0.0, 300.0, (N, 3)), 4)
PLACE = np.round(np.array([862.0, 75.0, 391.0]) + RNG.normal(0.0, 20.0, (N, 3)), 4)  # mm
JOINTS = np.round(np.array([-45.8, 4.6, 38.8, -0.1, 51.8, -72.9]) + RNG.normal(0.0, 0.1, (N, 6)), 4)  # deg
TURN = RNG.normal(0.0, 1e-3, N)
Q = np.column_stack([np.cos(TURN / 2), np.sin(TURN / 2), np.zeros(N), np.zeros(N)])
R = np.array([[1, 0, 0, 0, np.cos(a), -np.sin(a), 0, np.sin(a), np.cos(a)] for a in TURN])


def lines_of(rows: Sequence[Sequence[float | str]], delimiter: str, decimal: str = ".") -> str:
    def cell(value: float | str) -> str:
        return value if isinstance(value, str) else repr(float(value)).replace(".", decimal)

    return "".join(delimiter.join(map(cell, row)) + "\n" for row in rows)


def next_to(*columns: object) -> list[list[float | str]]:
    table = np.column_stack([np.array(column, dtype=object) for column in columns])
    return [[cell if isinstance(cell, str) else float(cell) for cell in row] for row in table.tolist()]


def motive() -> str:
    body = ["Frame", "Time (Seconds)", *"XYZW", *"XYZ", "", *"XYZ"]
    what = ["", "", *["Rotation"] * 4, *["Position"] * 3, "Mean Marker Error", *["Position"] * 3]
    names = ["", "Name", *["plate"] * 8, *["plate:Marker 001"] * 3]
    kinds = ["", "Type", *["Rigid Body"] * 8, *["Marker"] * 3]
    ids = ["", "ID", *["1A2B"] * 8, *["33CC"] * 3]
    rows = next_to(np.arange(N), TIME, Q[:, [1, 2, 3, 0]], PLACE, np.full(N, 0.1), PLACE)
    head = (
        "Format Version,1.25,Take Name,t1,Export Frame Rate,50.000000,Rotation Type,Quaternion,Length Units,Millimeters"
    )
    return head + "\n\n" + lines_of([kinds, names, ids, what, body], ",") + lines_of(rows, ",")


def vicon(markers: Sequence[str] = ("arm:tool",)) -> str:
    rows = next_to(np.arange(N), np.zeros(N), PLACE, np.tile([10.0, 20.0, 30.0], (N, len(markers) - 1)))
    head = ["Trajectories\n50\n", *(f",,{name}" for name in markers), ",,\nFrame,Sub Frame", *[",X,Y,Z"] * len(markers)]
    return "".join([*head, "\n,", *[",mm,mm,mm"] * len(markers), "\n"]) + lines_of(rows, ",")


def motive_place() -> str:
    head = "Format Version,1.23,Take Name,t1,Export Frame Rate,50.000000,Length Units,Millimeters\n\n"
    head += ",Type,Rigid Body,Rigid Body,Rigid Body\n,Name,plate,plate,plate\n,ID,1,1,1\n"
    head += ",,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z\n"
    return head + lines_of(next_to(np.arange(N), TIME, PLACE), ",")


def trc(keys: int = 6) -> str:
    return f"{trc_keys(keys, 2)}Frame#\tTime\tprobe\t\t\tbase\t\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t\n\n" + lines_of(
        next_to(np.arange(1, N + 1), TIME, PLACE, np.tile([10.0, 20.0, 30.0], (N, 1))), "\t"
    )


def trc_keys(keys: int, markers: int) -> str:
    names = ("DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units", "OrigDataRate", "OrigDataStartFrame")
    values = ("50.00", "50.00", "40", str(markers), "mm", "50.00", "1")
    return "PathFileType\t4\t(X/Y/Z)\ttake.trc\n" + "\t".join(names[:keys]) + "\n" + "\t".join(values[:keys]) + "\n"


def trc_of_one(keys: int) -> str:
    head = f"{trc_keys(keys, 1)}Frame#\tTime\tprobe\t\t\n\t\tX1\tY1\tZ1\n\n"
    return head + lines_of(next_to(np.arange(1, N + 1), TIME, PLACE), "\t")


def qualisys() -> str:
    head = "NO_OF_FRAMES\t40\nNO_OF_MARKERS\t2\nFREQUENCY\t50\nMARKER_NAMES\tprobe\tbase\n"
    head += "TRAJECTORY_TYPES\tMeasured\tMeasured\n"
    return head + lines_of(next_to(PLACE, np.tile([10.0, 20.0, 30.0], (N, 1))), "\t")


def qualisys_of_one() -> str:
    head = "NO_OF_FRAMES\t40\nNO_OF_MARKERS\t1\nFREQUENCY\t50\nTIME_STAMP\t2026-11-20, 10:15:30.123\t1234.5\n"
    return head + "DATA_INCLUDED\t3D\nMARKER_NAMES\tprobe\n" + lines_of(next_to(PLACE), "\t")


def qualisys_6d(others: Sequence[str], named: str, frames: bool) -> str:
    """Write rigid bodies of which the first moves; a line names the components of the first, of each or of none."""
    head = "\t".join(["NO_OF_FRAMES\t40\nFREQUENCY\t50\nDATA_INCLUDED\t6D\nBODY_NAMES\tprobe", *others]) + "\n"
    components = [" X", " Y", " Z", " Roll", " Pitch", " Yaw", " Residual", *(f" Rot[{k}]" for k in range(9))]
    names = components * {"none": 0, "first": 1, "each": 1 + len(others)}[named]
    if names:
        head += "\t".join([*(["Frame", "Time"] if frames else []), *names]) + "\n"
    probe = np.column_stack([PLACE, np.ones((N, 4)), R[:, [0, 3, 6, 1, 4, 7, 2, 5, 8]]])
    still = np.tile([10.0, 20.0, 30.0, *[1.0] * 4, *np.eye(3).ravel()], (N, len(others)))
    return head + lines_of(next_to(*([np.arange(N), TIME] if frames else []), probe, still), "\t")


def labview(first: object = TIME) -> str:
    head = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\n***End_of_Header***\t\n\t\nChannels\t3\t\t\t\n"
    head += (
        "Samples\t40\t40\t40\t\nDate\t2026/11/20\t2026/11/20\t2026/11/20\t\nY_Unit_Label\tNewton\tNewton\tNewton\t\n"
    )
    head += "X0\t0,0E+0\t0,0E+0\t0,0E+0\t\nDelta_X\t0,02\t0,02\t0,02\t\n***End_of_Header***\t\t\t\t\n"
    return head + "X_Value\tFx\tFy\tFz\tComment\n" + lines_of(next_to(first, FORCE), "\t", ",")


def rtde() -> str:
    names = ["timestamp", *(f"target_q_{k}" for k in range(6)), *(f"actual_q_{k}" for k in range(6))]
    angles = np.radians(JOINTS)
    return " ".join(names) + "\n" + lines_of(next_to(31002.118 + TIME, angles + 0.5, angles), " ")


def aligned() -> str:
    head = "".join(f"{name:>16}" for name in ("t", *(f"A{k}" for k in range(1, 7))))
    rows = ("".join(f"{value:16.6f}" for value in row) for row in np.column_stack([TIME, JOINTS]))
    return "\n".join([head, *rows, ""])


def franka() -> str:
    names = ["time", *(f"q[{k}]" for k in range(6)), *(f"q_d[{k}]" for k in range(6)), *(f"q_d[{k}]" for k in range(6))]
    angles = np.radians(JOINTS)
    return ", ".join(names) + "\n" + lines_of(next_to(TIME, angles, angles, angles), ", ")


def union() -> str:
    rows: list[tuple[float, list[float | str]]] = []
    for k in range(N):
        rows.append((TIME[k], [*FORCE[k], "", "", ""]))
        rows.append((TIME[k] + 0.003, ["", "", "", *PLACE[k]]))
    head = "__time," + ",".join(f"/ft/wrench/force/{axis}" for axis in "xyz")
    head += "," + ",".join(f"/probe/point/{axis}" for axis in "xyz")
    return head + "\n" + lines_of([[time, *cells] for time, cells in rows], ",")


def dated(form: str) -> str:
    words = [form.format(seconds=f"{30 + time:06.3f}", comma=f"{30 + time:06.3f}".replace(".", ",")) for time in TIME]
    return "Zeitstempel;Kraft X [N];Kraft Y [N];Kraft Z [N]\n" + lines_of(next_to(words, FORCE), ";")


def joints_named(name: str) -> str:
    head = ",".join(["t", *(name.format(k) for k in range(1, 7))]) + "\n"
    return head + lines_of(next_to(TIME, JOINTS), ",")


def low_resolution() -> str:
    steps = np.floor(TIME / 0.05) * 50
    head = "Name;PLC force cell\nSampleTime[ms];20\nUnit;ms / N\n\nTime [ms];Fx;Fy;Fz\n"
    return head + lines_of(next_to(steps, FORCE), ";")


def ndi() -> str:
    names = ["Tool ID", "Timestamp", "Frame #", *("Tx", "Ty", "Tz"), *(f"R{i}{k}" for i in range(3) for k in range(3))]
    rows = next_to(np.ones(N), 1785175389.64 + TIME, np.arange(N), PLACE, R)
    return ",".join(names) + "\n" + lines_of(rows, ",")


def polaris() -> str:
    rows = next_to(np.ones(N), TIME, ["OK"] * N, Q, PLACE)
    rows.insert(5, ["1", "0.09", "MISSING", *[""] * 7])
    return "Tools,Time [s],State,Q0,Qx,Qy,Qz,Tx,Ty,Tz\n" + lines_of(rows, ",")


def thousands() -> str:
    cells = [[f"{time:.2f}", *(f'"{value:,.4f}"' for value in row)] for time, row in zip(TIME, 10 * FORCE, strict=True)]
    return "t [s],Fx [N],Fy [N],Fz [N]\n" + lines_of(cells, ",")


def commented() -> str:
    return "# operator: N. N.\n# t,Fx,Fy,Fz\n# s,N,N,N\n" + lines_of(next_to(TIME, FORCE), ",")


def of_words(time: str, x: str, y: str, z: str) -> str:
    return f"{time};{x};{y};{z}\n" + lines_of(next_to(TIME, FORCE), ";", ",")


def below(first: str, second: str) -> str:
    return f"{first}\n{second}\n" + lines_of(next_to(TIME, FORCE), ",")


def force_of(time: Callable[[float], str], head: str = "Time,Fx,Fy,Fz") -> str:
    return f"{head}\n" + lines_of(next_to([time(float(own)) for own in TIME], FORCE), ",")


def two_columns_of_time(head: str, second: str, steps: float) -> str:
    rows = next_to([second] * N, [str(round(steps * own)) for own in TIME], FORCE)
    return f"{head},Fx,Fy,Fz\n" + lines_of(rows, ",")


def joint_states(head: str) -> str:
    """Write Universal Robots' joints by the alphabet, as messages of ROS list them."""
    names = ["elbow", "shoulder_lift", "shoulder_pan", "wrist_1", "wrist_2", "wrist_3"]
    angles = np.radians(JOINTS)[:, [2, 1, 0, 3, 4, 5]]
    return ",".join(["time", *(head.format(name) for name in names)]) + "\n" + lines_of(next_to(TIME, angles), ",")


def rostopic() -> str:
    head = ["%time", *(f"field.name{k}" for k in range(6)), *(f"field.position{k}" for k in range(6))]
    stamps = [str(1785175389640000000 + round(1e9 * own)) for own in TIME]
    rows = next_to(stamps, *[[f"joint_a{k}"] * N for k in range(6)], np.radians(JOINTS))
    return ",".join(head) + "\n" + lines_of(rows, ",")


def transforms(first: int, by_rows: bool = False, numbered: bool = False) -> str:
    whole = np.tile(np.eye(4), (N, 1, 1))
    whole[:, :3, :3], whole[:, :3, 3] = R.reshape(N, 3, 3), PLACE
    names = [f"T{row}{column}" for row in range(first, first + 4) for column in range(first, first + 4)]
    names = [f"M{k}" for k in range(first, first + 16)] if numbered else names
    cells = (whole.transpose(0, 2, 1) if by_rows else whole).reshape(N, 16)
    return ",".join(["t [s]", *names]) + "\n" + lines_of(next_to(TIME, cells), ",")


def catman() -> str:
    head = "HBM_CATMAN_DATAFILE_40\nSample rate = 50 Hz\nTime  1 - default sample rate\tMX840_CH1 Fx\tMX840_CH2 Fy\t"
    head += "MX840_CH3 Fz\ns\tN\tN\tN\n" + "\t".join(["Start: 0"] * 4) + "\n" + "\t".join(["SN: 1"] * 4) + "\n"
    return head + lines_of(next_to(TIME, FORCE), "\t", ",")


WRENCH, POSITION, ANGLES = "wrench", "position.tool", "joints"
LOGS: dict[str, tuple[Callable[[], str], str, str, str]] = {
    "OptiTrack Motive": (motive, "take.csv", "utf-8", POSITION),
    "Vicon Nexus": (vicon, "trial.csv", "utf-8", POSITION),
    "Vicon Nexus, several markers": (lambda: vicon(("arm:tool", ",arm:a", ",arm:b")), "trial.csv", "utf-8", POSITION),
    "OptiTrack Motive, one body's place": (motive_place, "take.csv", "utf-8", POSITION),
    "tracks by rows": (trc, "take.trc", "utf-8", POSITION),
    "tracks by rows, one marker": (lambda: trc_of_one(7), "take.trc", "utf-8", POSITION),
    "tracks by rows, one marker and five keys": (lambda: trc_of_one(5), "take.trc", "utf-8", POSITION),
    "Qualisys QTM": (qualisys, "take.tsv", "utf-8", POSITION),
    "Qualisys QTM, one marker": (qualisys_of_one, "take.tsv", "utf-8", POSITION),
    "a column named by a place": (
        lambda: "t [s],Tool,X [mm],Y [mm],Z [mm]\n" + lines_of(next_to(TIME, ["449"] * N, PLACE), ","),
        "tool.csv",
        "utf-8",
        POSITION,
    ),
    "LabVIEW measurement file": (labview, "force.lvm", "utf-8", WRENCH),
    "LabVIEW without times": (lambda: labview([""] * N), "force.lvm", "cp1252", WRENCH),
    "Universal Robots RTDE recorder": (rtde, "robot_data.csv", "utf-8", ANGLES),
    "several blanks": (aligned, "axes.dat", "utf-8", ANGLES),
    "an ending that says nothing": (aligned, "axes.trc", "utf-8", ANGLES),
    "libfranka": (franka, "log.csv", "utf-8", ANGLES),
    "day first": (lambda: dated("20.11.2026 10:15:{comma}"), "scope.csv", "utf-16", WRENCH),
    "month first": (lambda: dated("11/20/2026 10:15:{seconds} AM"), "scope.log", "utf-8", WRENCH),
    "dates of two words between tabs": (
        lambda: dated("20/11/2026 10:15:{comma}").replace(";", "\t"),
        "scope.txt",
        "utf-8",
        WRENCH,
    ),
    "joints in Spanish": (lambda: joints_named("Eje{} [grados]"), "j.csv", "utf-8", ANGLES),
    "joints in Chinese": (lambda: joints_named("关节{}(度)"), "j.csv", "utf-16", ANGLES),
    "joints in German": (lambda: joints_named("Gelenkwinkel {} (°)"), "j.csv", "cp1252", ANGLES),
    "joints in Portuguese": (lambda: joints_named("Junta {} [graus]"), "j.csv", "utf-8", ANGLES),
    "joints of Japanese Windows": (lambda: joints_named("関節{}[度]"), "j.csv", "cp932", ANGLES),
    "joints of Chinese Windows": (lambda: joints_named("轴{}（度）"), "j.csv", "gb18030", ANGLES),
    "joints in Greek letters": (lambda: joints_named("θ{} [°]"), "j.csv", "utf-8", ANGLES),
    "joints with a word behind the number": (lambda: joints_named("Joint {} angle [deg]"), "j.csv", "utf-8", ANGLES),
    "joints with a word behind, German": (lambda: joints_named("Achse {} Ist [°]"), "j.csv", "cp1252", ANGLES),
    "joints with a word before": (lambda: joints_named("Angolo giunto {} [°]"), "j.csv", "utf-8", ANGLES),
    "joints with a word behind, Chinese": (lambda: joints_named("关节{}角度[度]"), "j.csv", "utf-8", ANGLES),
    "joints counted in Japanese": (lambda: joints_named("第{}軸[度]"), "j.csv", "utf-8", ANGLES),
    "joints of a topic": (lambda: joints_named("/joint_states/joint_{}/position [deg]"), "j.csv", "utf-8", ANGLES),
    "a time of day": (lambda: dated("10:15:{comma}"), "scope.csv", "utf-8-sig", WRENCH),
    "C, Unix": (lambda: dated("Fri Nov 20 10:15:{seconds} 2026"), "scope.csv", "utf-8", WRENCH),
    "month in words": (lambda: dated("Nov 20, 2026 10:15:{seconds} AM"), "scope.csv", "utf-8", WRENCH),
    "a point after the day": (lambda: dated("20. Nov 2026 10:15:{comma}"), "scope.csv", "cp1252", WRENCH),
    "date of Japan": (lambda: dated("2026年11月20日 10:15:{seconds}"), "scope.csv", "utf-16", WRENCH),
    "date as in names of files": (lambda: dated("2026-11-20_10-15-{seconds}"), "scope.csv", "utf-8", WRENCH),
    "digits alone": (lambda: dated("20261120 10:15:{seconds}"), "scope.csv", "utf-8", WRENCH),
    "units behind the sign of a comment": (commented, "log.dat", "utf-8", WRENCH),
    "an axis before what is measured": (
        lambda: of_words("时间(s)", "X向力(N)", "Y向力(N)", "Z向力(N)"),
        "f.txt",
        "utf-8",
        WRENCH,
    ),
    "an axis behind what is measured": (
        lambda: of_words("Zeit (s)", "Kraft in X-Richtung (N)", "Kraft in Y-Richtung (N)", "Kraft in Z-Richtung (N)"),
        "f.txt",
        "utf-16-be",
        WRENCH,
    ),
    "an axis behind what is measured, Spanish": (
        lambda: of_words("Tiempo (s)", "Fuerza en X (N)", "Fuerza en Y (N)", "Fuerza en Z (N)"),
        "f.txt",
        "cp1252",
        WRENCH,
    ),
    "a force that is stated twice": (
        lambda: of_words("Tempo [s]", "Forza Fx [N]", "Forza Fy [N]", "Forza Fz [N]"),
        "f.txt",
        "utf-8",
        WRENCH,
    ),
    "elapsed time in Japanese": (
        lambda: of_words("経過時間[s]", "荷重X[N]", "荷重Y[N]", "荷重Z[N]"),
        "f.txt",
        "cp932",
        WRENCH,
    ),
    "joints of ABB": (lambda: joints_named("rax_{}"), "j.csv", "utf-8", ANGLES),
    "joints of Kawasaki, a unit in braces": (lambda: joints_named("JT{} {{deg}}"), "j.csv", "utf-8", ANGLES),
    "joints of Yaskawa": (
        lambda: "time - s;S - deg;L - deg;U - deg;R - deg;B - deg;T - deg\n" + lines_of(next_to(TIME, JOINTS), ";"),
        "j.csv",
        "utf-8",
        ANGLES,
    ),
    "joints of Yaskawa behind a small t": (
        lambda: "t;S - deg;L - deg;U - deg;R - deg;B - deg;T - deg\n" + lines_of(next_to(TIME, JOINTS), ";"),
        "j.csv",
        "utf-8",
        ANGLES,
    ),
    "joints of Yaskawa before a small t": (
        lambda: "S - deg;L - deg;U - deg;R - deg;B - deg;T - deg;t\n" + lines_of(next_to(JOINTS, TIME), ";"),
        "j.csv",
        "utf-8",
        ANGLES,
    ),
    "a force by its unit alone": (
        lambda: of_words("tiempo (s)", "síla X [N]", "síla Y [N]", "síla Z [N]"),
        "f.txt",
        "utf-8",
        WRENCH,
    ),
    "axes with units that are no place's": (
        lambda: "t;Fx;Fy;Fz;Dehnung X [V];Dehnung Y [V];Dehnung Z [V]\n" + lines_of(next_to(TIME, FORCE, FORCE), ";"),
        "f.csv",
        "utf-8",
        WRENCH,
    ),
    "the unit of time among the axes": (lambda: below("Zeit,Kraft [N],,", "s,x,y,z"), "log.csv", "utf-8", WRENCH),
    "a colon before milliseconds": (
        lambda: force_of(lambda t: f"2026-11-20 10:15:00:{round(1e3 * t):03d}"),
        "log.csv",
        "utf-8",
        WRENCH,
    ),
    "direction in words": (
        lambda: of_words("Uhrzeit", "X-Richtung Kraft", "Y-Richtung Kraft", "Z-Richtung Kraft"),
        "f.txt",
        "utf-8",
        WRENCH,
    ),
    "what is measured above its axes": (lambda: below("time,force,force,force", ",x,y,z"), "log.csv", "utf-8", WRENCH),
    "what is measured, merged, with its unit": (lambda: below("t,Force [N],,", ",x,y,z"), "log.csv", "utf-8", WRENCH),
    "an hour of one digit": (lambda: force_of(lambda t: f"0:00:{t:06.3f}"), "log.csv", "utf-8", WRENCH),
    "minutes and seconds": (lambda: force_of(lambda t: f"00:{t:06.3f}"), "log.csv", "utf-8", WRENCH),
    "digits alone and a zone": (
        lambda: force_of(lambda t: f"20261120T1015{30 + t:06.3f}Z"),
        "log.csv",
        "utf-8",
        WRENCH,
    ),
    "seconds and nanoseconds of messages": (
        lambda: two_columns_of_time("/ft/header/stamp/sec,/ft/header/stamp/nanosec", "1785175389", 1e9),
        "ft.csv",
        "utf-8",
        WRENCH,
    ),
    "seconds and nanoseconds": (
        lambda: two_columns_of_time("secs,nsecs", "1785175389", 1e9),
        "ft.csv",
        "utf-8",
        WRENCH,
    ),
    "a time of day and milliseconds": (
        lambda: two_columns_of_time("Time,Millitm", "10:15:30", 1e3),
        "plc.csv",
        "utf-8",
        WRENCH,
    ),
    "homogeneous transformations": (lambda: transforms(0), "log.csv", "utf-8", POSITION),
    "homogeneous transformations for rows": (lambda: transforms(1, by_rows=True), "log.csv", "utf-8", POSITION),
    "a vector of six": (
        lambda: (
            ",".join(["t", *(f"probe_pose_{k}" for k in range(6))])
            + "\n"
            + lines_of(next_to(TIME, PLACE / 1e3, R[:, :3]), ",")
        ),
        "log.csv",
        "utf-8",
        POSITION,
    ),
    "elements numbered to 15": (lambda: transforms(0, True, True), "log.csv", "utf-8", POSITION),
    "a quaternion from 1": (
        lambda: "t,x,y,z,q1,q2,q3,q4,cf1\n" + lines_of(next_to(TIME, PLACE, Q, np.zeros(N)), ","),
        "log.csv",
        "utf-8",
        POSITION,
    ),
    "HBM catman": (catman, "log.asc", "cp1252", WRENCH),
    "a label before the units": (
        lambda: below("Kanal,Zeit,Fx 9129AA,Fy 9129AA,Fz 9129AA", "Einheit,s,N,N,N").replace("\n0", "\n,0"),
        "log.csv",
        "utf-8",
        WRENCH,
    ),
    "a channel before the component": (
        lambda: of_words("Time (s)", "AI 1/Fx (N)", "AI 2/Fy (N)", "AI 3/Fz (N)"),
        "log.csv",
        "utf-8",
        WRENCH,
    ),
    "inches in a comment": (
        lambda: "# Units: Inches\nPoint, X, Y, Z, t\n" + lines_of(next_to(["p"] * N, PLACE / 25.4, TIME), ", "),
        "log.txt",
        "utf-8",
        POSITION,
    ),
    "pounds in the head": (
        lambda: (
            "Force Units:,lbf\nRDT Sample Rate:,50\nCounts per Unit Force:,1\nRDT Sequence,Fx,Fy,Fz\n"
            + lines_of(next_to(np.arange(N), FORCE / 4.4482216152605), ",")
        ),
        "log.csv",
        "utf-8",
        WRENCH,
    ),
    "Czech": (lambda: of_words("Čas", "Síla X", "Síla Y", "Síla Z"), "f.txt", "cp1250", WRENCH),
    "Russian": (lambda: of_words("Время, с", "Сила X, Н", "Сила Y, Н", "Сила Z, Н"), "f.txt", "cp1251", WRENCH),
    "a time by its unit": (lambda: of_words("ca. [s]", "Fx", "Fy", "Fz"), "f.txt", "cp1252", WRENCH),
    "joints of a Macintosh": (
        lambda: joints_named("Achse {} [°]").replace("\n", "\r"),
        "j.csv",
        "mac_roman",
        ANGLES,
    ),
    "a word next to the time": (
        lambda: of_words("Zeit  1 - Standardrate [s]", "Fx [N]", "Fy [N]", "Fz [N]"),
        "k.asc",
        "cp1252",
        WRENCH,
    ),
    "a clock in place of a unit": (
        lambda: force_of(lambda t: f"10:15:{30 + t:06.3f}", "Measurement time [hh:mm:ss],Fx [N],Fy [N],Fz [N]"),
        "k.asc",
        "utf-8",
        WRENCH,
    ),
    "minus sign of Sweden": (lambda: force_of(repr).replace("-", "\u2212"), "log.csv", "utf-8", WRENCH),
    "letters of double width": (
        lambda: force_of(repr, "時刻［ｓ］,Ｆｘ［Ｎ］,Ｆｙ［Ｎ］,Ｆｚ［Ｎ］"),
        "log.csv",
        "utf-8",
        WRENCH,
    ),
    "joints by names": (lambda: joint_states("{}_joint"), "log.csv", "utf-8", ANGLES),
    "joints by names of a message": (lambda: joint_states("position.{}_joint"), "log.csv", "utf-8", ANGLES),
    "messages by rostopic": (rostopic, "log.csv", "utf-8", ANGLES),
    "low resolution": (low_resolution, "plc.csv", "cp1252", WRENCH),
    "NDI capture": (ndi, "participant.csv", "utf-8", POSITION),
    "NDI Polaris": (polaris, "polaris.csv", "utf-8", POSITION),
    "thousands": (thousands, "force.csv", "utf-8", "ten times"),
    "German": (lambda: of_words("Zeit [s]", "Kraft X / N", "Kraft Y / N", "Kraft Z / N"), "f.txt", "cp1252", WRENCH),
    "French": (lambda: of_words("temps (s)", "force X", "force Y", "force Z"), "f.txt", "cp1252", WRENCH),
    "Spanish": (lambda: of_words("tiempo (s)", "fuerza X", "fuerza Y", "fuerza Z"), "f.txt", "utf-8", WRENCH),
    "Italian": (lambda: of_words("tempo (s)", "forza X", "forza Y", "forza Z"), "f.txt", "utf-8", WRENCH),
    "Japanese": (lambda: of_words("時間 [s]", "力X [N]", "力Y [N]", "力Z [N]"), "f.txt", "utf-8", WRENCH),
    "Chinese": (lambda: of_words("时间 (s)", "力 X (N)", "力 Y (N)", "力 Z (N)"), "f.txt", "utf-16", WRENCH),
}


def proposed(folder: Path, name: str, text: str, encoding: str = "utf-8") -> LogKind:
    (folder / name).write_bytes(text.encode(encoding))
    return log_kind(folder / name, name, FrameNames())


def readings(folder: Path, name: str, kind: LogKind) -> tuple[Floats, dict[str, Floats]]:
    source = source_type().model_validate(tomllib.loads("\n".join(map(str, kind.lines))))
    parts = list(read_rows(folder, "log", source, {"": name}))
    signals = {key: np.concatenate([part.signals[key] for part in parts], axis=1) for key in parts[0].signals}
    return np.concatenate([part.time for part in parts]), signals


@pytest.mark.parametrize("instrument", LOGS)
def test_what_is_proposed_reads_every_value(tmp_path: Path, instrument: str) -> None:
    write, name, encoding, signal = LOGS[instrument]
    kind = proposed(tmp_path, name, write(), encoding)
    time, signals = readings(tmp_path, name, kind)
    assert np.allclose(time - time[0], TIME, atol=1e-5)
    if signal == ANGLES:
        assert np.allclose(signals[ANGLES], np.radians(JOINTS).T, atol=1e-12)
    elif signal == POSITION:
        assert np.allclose(signals[POSITION], PLACE.T / 1e3, rtol=1e-12)
    else:
        assert np.allclose(signals[WRENCH][:3], FORCE.T * (10.0 if signal == "ten times" else 1.0), rtol=1e-12)


def test_orientations_come_along(tmp_path: Path) -> None:
    numbered = (lambda: transforms(1, numbered=True), LOGS["elements numbered to 15"][0])
    for write in (motive, polaris, ndi, lambda: transforms(1), *numbered, LOGS["a quaternion from 1"][0]):
        _, signals = readings(tmp_path, "log.csv", proposed(tmp_path, "log.csv", write()))
        assert np.allclose(signals["quaternion.tool"], Q.T)


@pytest.mark.parametrize("named", ["none", "first", "each"])
@pytest.mark.parametrize("frames", [True, False])
@pytest.mark.parametrize("others", [(), ("base plate", "a")])
def test_place_and_orientation_are_of_the_same_rigid_body(
    tmp_path: Path, others: Sequence[str], named: str, frames: bool
) -> None:
    kind = proposed(tmp_path, "log.tsv", qualisys_6d(others, named, frames))
    time, signals = readings(tmp_path, "log.tsv", kind)
    assert np.allclose(time - time[0], TIME, atol=1e-5)
    assert np.allclose(signals[POSITION], PLACE.T / 1e3, rtol=1e-12)
    assert np.allclose(signals["quaternion.tool"], Q.T)


def test_an_orientation_that_never_changes_is_not_measured(tmp_path: Path) -> None:
    rows = next_to(TIME, PLACE, np.tile([1, 0, 0, 0], (N, 1)))
    kind = proposed(tmp_path, "log.csv", "t [s],X [mm],Y [mm],Z [mm],Q0,Q1,Q2,Q3\n" + lines_of(rows, ","))
    assert kind.roles.joints is None
    assert {entry.column for entry in kind.columns if not entry.taken_as} == {"Q0", "Q1", "Q2", "Q3"}
    assert "quaternion.tool" not in readings(tmp_path, "log.csv", kind)[1]


def test_each_signal_of_a_union_of_times_has_its_own_rows(tmp_path: Path) -> None:
    kind = proposed(tmp_path, "union.csv", union())
    (other,) = kind.further
    assert np.allclose(readings(tmp_path, "union.csv", kind)[1][WRENCH][:3], FORCE.T, rtol=1e-12)
    time, signals = readings(tmp_path, "union.csv", other)
    assert np.allclose(signals[POSITION], PLACE.T / 1e3, rtol=1e-12)
    assert np.allclose(time, TIME + 0.003)


@pytest.mark.parametrize("lost", ["", "MISSING", "nan"])
def test_a_lost_target_is_refused_with_a_condition_that_can_be_copied(tmp_path: Path, lost: str) -> None:
    text = "t [s],X [mm],Y [mm],Z [mm]\n" + lines_of(next_to(TIME, PLACE), ",")
    text += ",".join(["0.9", lost, lost, lost]) + "\n" + "1.0,1.5,2.5,3.5\n"
    (tmp_path / "log.csv").write_text(text)
    table = {
        "sampling": "time",
        "time": {"column": "t [s]", "unit": "s"},
        "pose": {"position": ["X [mm]", "Y [mm]", "Z [mm]"], "body": "tool", "units": {"position": "mm"}},
    }
    with pytest.raises(InputError) as caught:
        list(read_rows(tmp_path, "log", source_type().model_validate(table), {"": "log.csv"}))
    condition = "`X [mm]` != ''"
    assert f'rows = "{condition}"' in caught.value.faults[0].mend
    source = source_type().model_validate(table | {"rows": condition})
    assert sum(len(part) for part in read_rows(tmp_path, "log", source, {"": "log.csv"})) == N + 1


def test_dates_that_can_be_read_in_two_ways_are_refused_and_both_are_named(tmp_path: Path) -> None:
    text = dated("05/11/2026 10:15:{seconds}")
    kind = proposed(tmp_path, "scope.csv", text)
    assert kind.time is not None
    assert kind.time.doubt is not None
    assert "day 5 of month 11" in kind.time.doubt
    assert "month-first" in kind.time.doubt
    lines = "\n".join(map(str, kind.lines)).replace("day-first", "iso8601")
    source = source_type().model_validate(tomllib.loads(lines))
    with pytest.raises(InputError) as caught:
        list(read_rows(tmp_path, "log", source, {"": "scope.csv"}))
    assert caught.value.faults[0].code is FaultCode.TIME_AMBIGUOUS


@pytest.mark.parametrize(("delimiter", "decimal"), [(",", "."), (" ", "."), ("\t", "."), (";", ","), ("   ", ".")])
def test_the_line_of_names_that_is_asked_for_can_be_written_as_it_is_printed(
    tmp_path: Path, delimiter: str, decimal: str
) -> None:
    text = lines_of(next_to(TIME, PLACE, FORCE), delimiter, decimal)
    why = proposed(tmp_path, "log.txt", text).why_not
    asked = why.split("at its top, ")[1].split(" ")[0]
    assert asked.count("?") == 6
    for name in ("X [mm]", "Y [mm]", "Z [mm]", "Fx", "Fy", "Fz"):
        asked = asked.replace("?", name, 1)
    _, signals = readings(tmp_path, "log.txt", proposed(tmp_path, "log.txt", f"{asked}\n{text}"))
    assert np.allclose(signals[POSITION], PLACE.T / 1e3, rtol=1e-12)
    assert np.allclose(signals[WRENCH][:3], FORCE.T, rtol=1e-12)


def test_an_expanded_uncertainty_is_taken_with_its_factor(tmp_path: Path) -> None:
    rows = lines_of(next_to(TIME, PLACE, np.full(N, 0.03)), ",")
    for name in ("Uxyz (k=2)", "U95 [mm]", "U (k=2) [mm]"):
        kind = proposed(tmp_path, "log.csv", f"t [s],X [mm],Y [mm],Z [mm],{name}\n{rows}")
        assert np.allclose(readings(tmp_path, "log.csv", kind)[1]["sigma.position.tool"], 1.5e-5)


def test_u_without_a_place_is_a_displacement(tmp_path: Path) -> None:
    rows = lines_of(next_to(FORCE, PLACE / 1e4), ",")
    kind = proposed(tmp_path, "log.csv", f"Fx,Fy,Fz,ux [mm],uy [mm],uz [mm]\n{rows}")
    assert kind.roles.deflection is not None
    assert len(kind.roles.deflection.columns) == 3


def test_no_reading_by_ndi_is_a_gap(tmp_path: Path) -> None:
    rows = lines_of([*next_to(TIME, PLACE), [0.9, *["-3.697314E+28"] * 3]], ",")
    kind = proposed(tmp_path, "log.csv", f"t [s],Tx [mm],Ty [mm],Tz [mm]\n{rows}")
    assert np.allclose(readings(tmp_path, "log.csv", kind)[1][POSITION], PLACE.T / 1e3)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("t,Fx,Fy,Fz\n" + "0.1,(1.5),(2.5),(3.5)\n" * 3, "(1.5)"),
        ("t,Fx,Fy,Fz\n" + '0.1,"1,23,456.7","1,23,456.7","1,23,456.7"\n' * 3, "1,23,456.7"),
        ("t,P 1,Tx,Ty,Tz,P 2,Tx,Ty,Tz\n" + "0.1,a,1,2,3,b,1,2,3\n" * 3, '"Tx"'),
        ("t,Stab 1 [µε],Stab 2 [µε]\n" + "0.1,1,2\n" * 3, "--kind ids"),
        ("t,Fx 1,Fy 1,Fz 1,Fx 2,Fy 2,Fz 2\n" + "0.1,1,2,3,1,2,3\n" * 3, "no signal"),
        ("Time [s];$AXIS_ACT\n" + "0.012;{E6AXIS: A1 1.0, A2 -90.0, A3 95.0}\n" * 3, "$AXIS_ACT.A1"),
        ("DEFDAT P\n" + "DECL E6AXIS XP1={A1 1.0,A2 -90.0,A3 95.0}\n" * 3, "$AXIS_ACT.A1"),
        ("Time (s),Azimuth (deg),Zenith (deg),Distance (mm)\n" + "0.1,10,20,1500\n" * 3, "write X, Y, Z"),
        ("Time (s),Hz (gon),V (gon),SD (m)\n" + "0.1,10,20,1.5\n" * 3, "write X, Y, Z"),
        ("Time (s),rate Hz,distance\n" + "0.1,10,1500\n" * 3, "no signal"),  # no direction is a rate
    ],
)
def test_what_cannot_be_read_is_quoted(tmp_path: Path, text: str, named: str) -> None:
    assert named in proposed(tmp_path, "log.csv", text).why_not


@pytest.mark.parametrize(
    ("name", "n"), [("actual_TCP_pose_{}", 6), ("actual_TCP_pose_{}", 3), ("O_T_EE[{}]", 16), ("F_T_NE[{}]", 16)]
)
def test_what_a_controller_computes_of_its_angles_is_no_place(tmp_path: Path, name: str, n: int) -> None:
    names = ["t", *(f"actual_q_{k}" for k in range(6)), *(name.format(k) for k in range(n))]
    cells = np.tile(np.eye(4).ravel(), (N, 1)) + 0.1 if n == 16 else np.hstack([PLACE / 1e3, PLACE / 1e3])[:, :n]
    kind = proposed(tmp_path, "log.csv", ",".join(names) + "\n" + lines_of(next_to(TIME, JOINTS / 60.0, cells), ","))
    assert kind.roles.position is None
    assert {c.column for c in kind.columns if "controller computes" in c.why} == set(names[7:])


def test_a_force_is_nothing_that_a_controller_computes(tmp_path: Path) -> None:
    kind = proposed(tmp_path, "log.csv", "t,F_T_Fx,F_T_Fy,F_T_Fz\n" + lines_of(next_to(TIME, FORCE), ","))
    assert not any("controller computes" in column.why for column in kind.columns)


def test_makers_whose_names_do_not_stand_in_the_export(tmp_path: Path) -> None:
    angles = " ".join(f'A{k}="1.5"' for k in range(1, 7))
    assert proposed(tmp_path, "l.xml", f'<Rob TYPE="KUKA"><AIPos {angles}/></Rob>\n' * 3).device.startswith("KUKA")
    pilot = "X  [mm],Y  [mm],Z  [mm],Time Stamp,OTG Applied\n" + "1.5,2.5,3.5,11.10.2026 15:00:00.043,FALSE\n" * 3
    assert proposed(tmp_path, "l.csv", pilot).device.startswith("Leica")


def test_markup_is_no_table(tmp_path: Path) -> None:
    kind = proposed(tmp_path, "robot.urdf", "<robot>\n" + '<origin xyz="0 0 1" rpy="0 0 0"/> <axis xyz="0 1 0"/>\n' * 9)
    assert "line of names" not in kind.why_not


def test_units_in_cells_are_named(tmp_path: Path) -> None:
    text = "t,Fx,Fy,Fz\n" + "".join(f"{t},{x} N,{y} N,{z} N\n" for t, (x, y, z) in zip(TIME, FORCE, strict=True))
    kind = proposed(tmp_path, "log.csv", text)
    assert "column Fx" in kind.why_not
    assert "N'" in kind.why_not


def test_large_t_beside_forces_is_no_moment(tmp_path: Path) -> None:
    rows = next_to(TIME, np.tile([1.0, 2.0, 3.0], (N, 1)), np.tile([-100.1, 20.0, -1500.0], (N, 1)))
    kind = proposed(tmp_path, "both.csv", "Time,Fx,Fy,Fz,Tx,Ty,Tz\n" + lines_of(rows, ","))
    assert kind.roles.moment is None
    assert kind.roles.position is not None


@pytest.mark.parametrize(("written", "size"), [("N-m", 1.0), ("mm.N", 1e-3), ("N*mm", 1e-3), ("Nm", 1.0)])
def test_moments_have_the_unit_that_stands_there(tmp_path: Path, written: str, size: float) -> None:
    head = "t," + ",".join(f"F{axis} [N]" for axis in "xyz") + "," + ",".join(f"M{axis} [{written}]" for axis in "xyz")
    kind = proposed(tmp_path, "log.csv", head + "\n" + lines_of(next_to(TIME, FORCE, FORCE), ","))
    assert np.allclose(readings(tmp_path, "log.csv", kind)[1][WRENCH][3:], size * FORCE.T, rtol=1e-12)


@pytest.mark.parametrize("name", ["log.csv.gz", "log.csv"])
def test_the_head_of_a_packed_log_or_one_of_two_bytes_a_letter_states_the_unit(tmp_path: Path, name: str) -> None:
    text = LOGS["pounds in the head"][0]()
    (tmp_path / name).write_bytes(gzip.compress(text.encode()) if name.endswith("gz") else text.encode("utf-16"))
    kind = log_kind(tmp_path / name, name, FrameNames())
    assert kind.device.startswith("ATI")
    assert np.allclose(readings(tmp_path, name, kind)[1][WRENCH][:3], FORCE.T, rtol=1e-12)


def test_a_body_is_no_moment_by_its_first_letter(tmp_path: Path) -> None:
    text = qualisys().replace("probe", "tool")
    doubt = proposed(tmp_path, "take.tsv", text).roles.position
    assert doubt is not None
    assert not doubt.doubt


def test_a_unit_that_nobody_knows_hides_no_other_log(tmp_path: Path) -> None:
    head = "t,Fx [N],Fy [N],Fz [N],Mx [kipft],My [kipft],Mz [kipft]\n"
    kind = proposed(tmp_path, "log.csv", head + lines_of(next_to(TIME, FORCE, FORCE), ","))
    assert "kipft" in kind.why_not


def test_every_column_is_explained(tmp_path: Path) -> None:
    found = {entry.column: entry for entry in proposed(tmp_path, "log.csv", franka()).columns}
    assert (found["q[0]"].taken_as, found["time"].taken_as) == ("joints", "time")
    assert found["q_d[0]"].taken_as == ""
    assert "two columns" in found["q_d[0]"].why
