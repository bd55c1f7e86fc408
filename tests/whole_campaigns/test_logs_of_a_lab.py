"""The bundled example with its logs as other programs write them gives its right stiffnesses."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

import h5py
import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.cli.app import main

pytestmark = pytest.mark.long
# N·m/rad, of campaigns/demo without the effect that is hidden in it
RIGHT = {1: 4.578e5, 2: 4.635e5, 3: 4.337e5}


def run(*words: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(list(words))
    assert ended.value.code == 0


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lab") / "demo"
    run("simulate", str(folder), "--from", str(Path(__file__).parents[2] / "campaigns" / "demo"))
    return folder


def readings(demo: Path, run_number: int) -> tuple[Floats, Floats, Floats]:
    """Return places (n, 4) s and mm, forces (n, 4) ms and N, joints (n, 7) s and degrees."""
    raw = demo / "raw"
    text = (raw / f"pose{run_number}_digitizer.csv").read_text("latin-1").replace(",", ".").splitlines()[4:]
    places = np.array([line.split(";")[:4] for line in text], dtype=np.float64)
    text = (raw / f"pose{run_number}_force.csv").read_text("utf-8").splitlines()[7:]
    forces = np.array([line.split(";")[:4] for line in text], dtype=np.float64)
    with h5py.File(raw / f"pose{run_number}_joints.h5") as file:
        group = file["irc5"]
        joints = np.column_stack([group[name][:] for name in ("t", "A1", "A2", "A3", "A4", "A5", "A6")])
    return places, forces, joints


def lines(rows: Floats, form: str, delimiter: str, decimal: str = ".") -> str:
    return "".join(delimiter.join(format(x, form) for x in row).replace(".", decimal) + "\n" for row in rows.tolist())


def camera_utf16_radians(places: Floats, forces: Floats, joints: Floats) -> dict[str, tuple[str, str]]:
    """Motion capture with several rows of names, a German log in UTF-16, blanks and radians under Japanese names."""
    camera = "Trajectories\n2.5\n,,Robo:probe,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n"
    numbered = np.column_stack([np.arange(1, len(places) + 1), np.zeros(len(places)), places[:, 1:]])
    force = "Messung\tKraft\n\nZeit\tKraft x\tKraft y\tKraft z\n[ms]\t[N]\t[N]\t[N]\n"
    names = "# 時間 " + " ".join(f"joint_{k}[rad]" for k in range(1, 7)) + "\n"
    angles = np.column_stack([joints[:, 0], np.radians(joints[:, 1:])])
    return {
        "vicon.csv": (camera + lines(numbered, ".6g", ","), "utf-8"),
        "Kraft.txt": (force + lines(forces, ".6g", "\t", ","), "utf-16"),
        "achsen.dat": (names + lines(angles, ".9g", " "), "utf-8"),
    }


def key_lines_and_two_heads(places: Floats, forces: Floats, joints: Floats) -> dict[str, tuple[str, str]]:
    """Key lines with a marker's name and no header, a LabVIEW file with two heads, a recorder's uptime in seconds."""
    markers = f"NO_OF_FRAMES\t{len(places)}\nNO_OF_MARKERS\t1\nFREQUENCY\t2.5\nMARKER_NAMES\tprobe\n"
    head = (
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nTime_Pref\tRelative\n***End_of_Header***\t\n\t\n"
    )
    head += "Channels\t3\t\t\t\nY_Unit_Label\tNewton\tNewton\tNewton\t\nDelta_X\t0,02\t0,02\t0,02\t\n"
    head += "***End_of_Header***\t\t\t\t\n"
    seconds = np.column_stack([1e-3 * forces[:, 0], forces[:, 1:]])
    recorder = "timestamp " + " ".join(f"actual_q_{k}" for k in range(6)) + "\n"
    angles = np.column_stack([31002.118 + joints[:, 0], np.radians(joints[:, 1:])])
    return {
        "take.tsv": (markers + lines(places[:, 1:], ".6g", "\t"), "utf-8"),
        "ft.lvm": (head + "X_Value\tFx\tFy\tFz\tComment\n" + lines(seconds, ".6g", "\t", ","), "utf-8"),
        "rtde.csv": (recorder + lines(angles, ".9f", " "), "utf-8"),
    }


def union_of_times_and_doubled_names(places: Floats, forces: Floats, joints: Floats) -> dict[str, tuple[str, str]]:
    """Force and places in one table by the union of their times, and a log in which a name stands twice."""
    head = "__time," + ",".join(f"/ft/force/{axis}" for axis in "xyz")
    head += "," + ",".join(f"/probe/point/{axis}" for axis in "xyz") + "\n"
    rows = [(1e-3 * row[0], *(f"{value:.4f}" for value in row[1:]), "", "", "") for row in forces]
    rows += [(row[0] + 0.0031, "", "", "", *(f"{value:.4f}" for value in row[1:])) for row in places]
    table = "".join(",".join((f"{row[0]:.6f}", *row[1:])) + "\n" for row in sorted(rows))
    angles = np.radians(joints[:, 1:])
    names = [f"{stem}[{k}]" for stem in ("q", "q_d", "q_d") for k in range(6)]
    log = ", ".join(("time", *names)) + "\n"
    log += lines(np.column_stack([joints[:, 0], angles, angles, angles]), ".9f", ", ")
    return {"merged.csv": (head + table, "utf-8"), "franka.csv": (log, "utf-8")}


def dates_lost_targets_and_xml(places: Floats, forces: Floats, joints: Floats) -> dict[str, tuple[str, str]]:
    """Dates with the day first and a decimal comma, a target that is MISSING at times, frames of RSI."""
    begin = datetime(2026, 11, 20, 10, 15, 30, tzinfo=UTC)
    moments = [begin + timedelta(milliseconds=time) for time in forces[:, 0].tolist()]
    words = [f"{moment:%d.%m.%Y %H:%M:%S},{moment.microsecond // 1000:03d}" for moment in moments]
    scope = "Name;PLC force cell\nSampleTime[ms];20\nUnit;ms / N\n\nZeitstempel;Fx;Fy;Fz\n"
    scope += "".join(
        f"{word};{line}" for word, line in zip(words, lines(forces[:, 1:], ".4f", ";").splitlines(True), strict=True)
    )
    camera = "Tools,Time [s],State,Q0,Qx,Qy,Qz,Tx,Ty,Tz\n"
    for k, line in enumerate(lines(places[:, 1:], ".4f", ",").splitlines()):
        camera += f"1,{places[k, 0]:.3f},OK,1,0,0,0,{line}\n"
        camera += f"1,{places[k, 0] + 0.2:.3f},MISSING,,,,,,,\n" if k % 17 == 5 else ""
    frames = ""
    for row in joints.tolist():
        angles = " ".join(f'A{k}="{angle:.6f}"' for k, angle in enumerate(row[1:], start=1))
        frames += f'<Rob TYPE="KUKA"><AIPos {angles}/><IPOC>{round(123645634 + 1000 * row[0])}</IPOC></Rob>\n'
    return {"scope.csv": (scope, "utf-8"), "ndi.csv": (camera, "utf-8"), "rsi.xml": (frames, "utf-8")}


def document_utf32_and_names(places: Floats, forces: Floats, joints: Floats) -> dict[str, tuple[str, str]]:
    """Columns of JSON, UTF-32 with Fortran's exponents below two rows of names, joints by name and by the alphabet."""
    x, y, z = places[:, 1:].T.tolist()
    camera = json.dumps({"stamp": places[:, 0].tolist(), "probe": {"x": x, "y": y, "z": z}})
    seconds = np.column_stack([1e-3 * forces[:, 0], forces[:, 1:]])
    force = "t,force,force,force\n,x,y,z\n" + lines(seconds, ".10E", ",").replace("E", "D")
    names = ("elbow", "shoulder_lift", "shoulder_pan", "wrist_1", "wrist_2", "wrist_3")
    head = ",".join(("time", *(f"position.{name}_joint" for name in names))) + "\n"
    angles = np.column_stack([joints[:, 0], np.radians(joints[:, [3, 2, 1, 4, 5, 6]])])
    return {
        "probe.json": (camera, "utf-8"),
        "ft.txt": (force, "utf-32"),
        "joints.csv": (head + lines(angles, ".9g", ","), "utf-8"),
    }


def minutes_signs_and_two_columns_of_time(places: Floats, forces: Floats, joints: Floats) -> dict[str, tuple[str, str]]:
    """Minutes and seconds with a typographic minus, names of double width, seconds next to nanoseconds."""
    camera = "Time;X [mm];Y [mm];Z [mm]\n"
    for time, line in zip(places[:, 0].tolist(), lines(places[:, 1:], ".5f", ";").splitlines(), strict=True):
        camera += f"{int(time // 60):02d}:{time % 60:06.3f};{line};\n".replace(".", ",").replace("-", "\u2212")
    seconds = np.column_stack([1e-3 * forces[:, 0], forces[:, 1:]])
    force = "HBM catman Easy\nDatum;20.11.2026\n\nZeit  1 - Standardrate [s];Ｆｘ［Ｎ］;Ｆｙ［Ｎ］;Ｆｚ［Ｎ］\n"
    head = ",".join(("sec", "nanosec", *(f"field.position{k}" for k in range(6)))) + "\n"
    moments = np.round(1e9 * joints[:, 0]).astype(np.int64).tolist()
    rows = zip(moments, lines(np.radians(joints[:, 1:]), ".9g", ",").splitlines(), strict=True)
    log = "".join(f"{1785175389 + ns // 10**9},{ns % 10**9},{line}\n" for ns, line in rows)
    return {
        "tracker.csv": (camera, "utf-8"),
        "ft.asc": (force + lines(seconds, ".4f", ";", ","), "utf-8"),
        "joints.csv": (head + log, "utf-8"),
    }


def several_heads_blanks_and_no_times(places: Floats, forces: Floats, joints: Floats) -> dict[str, tuple[str, str]]:
    """Motive with lost frames, columns that stand apart by blanks, a LabVIEW file whose column of times is empty."""
    camera = "Format Version,1.23,Take Name,t1,Export Frame Rate,2.500000,Length Units,Millimeters\n\n"
    camera += ",Type,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker\n,Name,plate,plate,plate,m:1,m:1,m:1\n"
    camera += ",ID,A,A,A,B,B,B\n,,Position,Position,Position,Position,Position,Position\n"
    camera += "Frame,Time (Seconds),X,Y,Z,X,Y,Z\n"
    for k, row in enumerate(places.tolist()):
        cells = ["", "", ""] if k % 17 == 5 else [f"{x:.4f}" for x in row[1:]]
        camera += ",".join([str(k), f"{row[0]:.6f}", *cells, *cells]) + "\n"
    head = "".join(f"{name:>16}" for name in ("t", *(f"A{k}" for k in range(1, 7)))) + "\n"
    axes = head + "".join("".join(f"{x:16.7f}" for x in row) + "\n" for row in joints.tolist())
    force = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tNo\n***End_of_Header***\t\n\t\n"
    force += "Channels\t3\t\t\t\nY_Unit_Label\tNewton\tNewton\tNewton\t\nDelta_X\t0,02\t0,02\t0,02\t\n"
    force += "***End_of_Header***\t\t\t\t\nX_Value\tFx\tFy\tFz\tComment\n"
    force += "".join("\t" + line for line in lines(forces[:, 1:], ".4f", "\t", ",").splitlines(True))
    return {"take.csv": (camera, "utf-8"), "axes.dat": (axes, "utf-8"), "ft.lvm": (force, "cp1252")}


def epoch_low_resolution_and_columns_of_a_matrix(
    places: Floats, forces: Floats, joints: Floats
) -> dict[str, tuple[str, str]]:
    """Seconds since 1970 next to a matrix that stands still, a clock of a lower resolution than its rows, libfranka."""
    names = ["Tool ID", "Timestamp", "Frame #", "Tx", "Ty", "Tz", *(f"R{i}{k}" for i in range(3) for k in range(3))]
    camera = ",".join(names) + "\n"
    for k, row in enumerate(places.tolist()):
        place = ",".join(f"{x:.4f}" for x in row[1:])
        camera += f"1,{1785175389.64 + row[0]:.7f},{k},{place},1,0,0,0,1,0,0,0,1\n"
    steps = np.column_stack([50.0 * np.floor(forces[:, 0] / 50.0), forces[:, 1:]])
    force = "Name;PLC force cell\nSampleTime[ms];20\nUnit;ms / N\n\nTime [ms];Fx;Fy;Fz\n" + lines(steps, ".4f", ";")
    head = ", ".join(["time", *(f"q[{k}]" for k in range(6)), *(f"tau_J[{k}]" for k in range(6))]) + "\n"
    torques = np.zeros((len(joints), 6))
    log = head + lines(np.column_stack([joints[:, 0], np.radians(joints[:, 1:]), torques]), ".9f", ", ")
    return {"ndi.csv": (camera, "utf-8"), "plc.csv": (force, "cp1252"), "franka.csv": (log, "utf-8")}


Writer = Callable[[Floats, Floats, Floats], dict[str, tuple[str, str]]]


@pytest.mark.parametrize(
    "written",
    [
        camera_utf16_radians,
        key_lines_and_two_heads,
        union_of_times_and_doubled_names,
        dates_lost_targets_and_xml,
        document_utf32_and_names,
        minutes_signs_and_two_columns_of_time,
        several_heads_blanks_and_no_times,
        epoch_low_resolution_and_columns_of_a_matrix,
    ],
)
def test_a_folder_of_other_programs_logs_gives_the_right_stiffnesses(
    demo: Path, tmp_path: Path, written: Writer, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "lab"
    (folder / "raw").mkdir(parents=True)
    for number in range(1, 7):
        for name, (text, encoding) in written(*readings(demo, number)).items():
            (folder / "raw" / f"P{number}_{name}").write_text(text, encoding)
    run("init", str(folder), "--from", str(folder / "raw"))
    fill_in(folder / "campaign.toml", ("0.13, 0.05, 0.24", "0.0, 0.0, 30.0"))
    shutil.copy(demo / "robot.toml", folder / "robot.toml")
    capsys.readouterr()
    run("identify", str(folder), "--json")
    parameters = json.loads(capsys.readouterr().out)["parameters"]
    found = {parameter["where"]["joints"][0]: parameter["stiffness"] for parameter in parameters}
    for joint, stiffness in RIGHT.items():
        # angles in radians and clocks of their own differ from the example's logs by a tenth of an uncertainty
        assert found[joint] == pytest.approx(stiffness, rel=0.005)


def fill_in(manifest: Path, numbers: Sequence[str]) -> None:
    """Write what no log states: where the force acts, how the force sensor is turned."""
    text = manifest.read_text("utf-8")
    for given in numbers:
        assert " = []" in text
        text = text.replace(" = []", f" = [{given}]", 1)
    assert " = []" not in text
    manifest.write_text(text, "utf-8")
