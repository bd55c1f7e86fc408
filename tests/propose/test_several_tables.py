"""Files that hold several tables: sheets, groups, topics, structs, and sections of a text below each other."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import xlsxwriter
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.manifest_type import source_type
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.from_folder import draft_from_folder
from stiffcal.propose.lines import FrameNames
from stiffcal.propose.log_kind import LogKind, log_kind
from stiffcal.propose.other_tables import table_of
from stiffcal.readers import WantedColumns, find_reader
from stiffcal.reduction.logs.log_rows import read_rows
from tests.laboratory.bags import joint_state, pose, wrench, write_bag
from tests.propose.test_instruments import readings

N = 20
RNG = np.random.default_rng(5)
TIME = np.linspace(0.0, 0.1 * (N - 1), N)
ANGLES = np.round(RNG.normal(40.0, 5.0, (N, 6)), 3)  # deg
FORCE = np.round(RNG.normal(0.0, 300.0, (N, 3)), 3)
PLACE = np.round(np.array([862.0, 75.0, 391.0]) + RNG.normal(0.0, 20.0, (N, 3)), 3)  # mm
MOMENTS = [1_795_248_930_000_000_000 + k * 100_000_000 for k in range(N)]  # ns
TABLES: dict[str, dict[str, Floats]] = {
    "axes": {"t": TIME, **{f"A{k + 1}": ANGLES[:, k] for k in range(6)}},
    "force": {"t": TIME, **{f"F{axis}": FORCE[:, k] for k, axis in enumerate("xyz")}},
    "arm": {"t": TIME, **{axis: PLACE[:, k] for k, axis in enumerate("XYZ")}},
    "remarks": {"humidity": TIME},
}


def workbook(path: Path) -> None:
    with xlsxwriter.Workbook(path) as book:
        for name, columns in TABLES.items():
            sheet = book.add_worksheet(name)
            for k, (head, values) in enumerate(columns.items()):
                sheet.write_column(0, k, [head, *values])


def hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        for name, columns in TABLES.items():
            for head, values in columns.items():
                file[f"{name}/{head}"] = values


def tdms(path: Path) -> None:
    with TdmsWriter(path) as file:
        for name, columns in TABLES.items():
            file.write_segment([ChannelObject(name, head, values) for head, values in columns.items()])


def bag(path: Path) -> None:
    names, straight = [f"A{k}" for k in range(1, 7)], np.array([1.0, 0.0, 0.0, 0.0])
    topics = {
        "/joint_states": [joint_state(m, names, np.radians(row)) for m, row in zip(MOMENTS, ANGLES, strict=True)],
        "/ft": [wrench(m, [*row, 0.0, 0.0, 0.0]) for m, row in zip(MOMENTS, FORCE, strict=True)],
        "/tool": [pose(m, row / 1e3, straight) for m, row in zip(MOMENTS, PLACE, strict=True)],
    }
    recorded = [moment + 7_000_000 * (k % 3) for k, moment in enumerate(MOMENTS)]
    write_bag(path, {name: list(zip(recorded, messages, strict=True)) for name, messages in topics.items()})


def sections(path: Path, gap: str = "", encoding: str = "utf-8") -> None:
    text = ""
    for title, rate, component, unit, values in (
        ("Devices", 20, "cell - Force", "N", FORCE),
        ("Joints", 10, "robot", "deg", ANGLES),
        ("Trajectories", 10, "probe", "mm", PLACE),
    ):
        names = {"N": ["Fx", "Fy", "Fz"], "mm": list("XYZ")}.get(unit, [f"A{k}" for k in range(1, 7)])
        text += f"{title}{gap}\n{rate}{gap}\n,,{component}{gap}\nFrame,Sub Frame,{','.join(names)}\n,,"
        text += ",".join([unit] * len(names)) + "\n"
        text += "".join(f"{k},0,{','.join(map(str, row))}\n" for k, row in enumerate(values)) + f"{gap}\n"
    path.write_bytes(text.encode(encoding))


FILES: dict[str, Callable[[Path], None]] = {
    "log.xlsx": workbook,
    "log.h5": hdf5,
    "log.tdms": tdms,
    "log.mat": lambda path: savemat(path, TABLES),
    "log.bag": bag,
    "log.mcap": bag,
    "log.csv": sections,
    "log.txt": lambda path: sections(path, ",,,", "utf-16"),
}


def sources(folder: Path, name: str) -> dict[str, LogKind]:
    kind = log_kind(folder / name, name, FrameNames())
    return {part.name: part for part in (kind, *kind.further)}


@pytest.mark.parametrize("name", FILES)
def test_each_table_of_a_file_is_a_source(tmp_path: Path, name: str) -> None:
    FILES[name](tmp_path / name)
    found = sources(tmp_path, name)
    assert set(found) == {"controller", "ft", "tracker"}
    rate = 20.0 if name in ("log.csv", "log.txt") else 10.0
    for source, signal, expected in (
        ("controller", "joints", np.radians(ANGLES).T),
        ("ft", "wrench", FORCE.T),
        ("tracker", "position.tool", PLACE.T / 1e3),
    ):
        time, signals = readings(tmp_path, name, found[source])
        assert np.allclose(signals[signal][: len(expected)], expected, rtol=1e-12, atol=1e-12)
        assert np.allclose(time - time[0], np.arange(N) / (rate if source == "ft" else 10.0), atol=1e-6)


def test_a_folder_of_such_files_is_a_campaign(tmp_path: Path) -> None:
    for k in range(1, 4):
        bag(tmp_path / f"pose{k}.bag")
    draft = draft_from_folder(tmp_path)
    assert draft.runs == ("pose1", "pose2", "pose3")
    assert draft.manifest.count('file = "raw/{run}.bag"') == 3
    assert draft.manifest.count("header.stamp") == 3
    assert draft.remarks == ()
    for k in range(1, 4):
        unclear = [(moment, joint_state(moment, ["alpha", "beta"], np.zeros(2))) for moment in MOMENTS]
        forces = [(moment, wrench(moment, [1.0] * 6)) for moment in MOMENTS]
        (tmp_path / f"pose{k}.bag").unlink()
        write_bag(tmp_path / f"pose{k}.bag", {"/arm": unclear, "/ft": forces})
    (remark,) = draft_from_folder(tmp_path).remarks
    assert "/arm (position.alpha, position.beta)" in remark


def test_a_run_without_one_of_the_tables_is_named(tmp_path: Path) -> None:
    for k in range(1, 4):
        bag(tmp_path / f"pose{k}.bag")
    write_bag(tmp_path / "pose4.bag", {"/ft": [(moment, wrench(moment, [1.0] * 6)) for moment in MOMENTS]})
    draft = draft_from_folder(tmp_path)
    assert draft.manifest.count('file = "raw/{run}.bag"') == 3
    assert any("pose4" in remark for remark in draft.remarks)


def test_a_table_of_states_is_the_one_sheet_with_signals(tmp_path: Path) -> None:
    with xlsxwriter.Workbook(tmp_path / "table.xlsx") as book:
        for name, columns in (("chart", {"n": TIME}), ("states", TABLES["axes"] | TABLES["force"])):
            sheet = book.add_worksheet(name)
            for k, (head, values) in enumerate(columns.items()):
                sheet.write_column(0, k, [head, *values])
    assert table_of(tmp_path / "table.xlsx").options["sheet"] == "states"


def test_which_table_of_a_text_is_meant_has_to_be_stated(tmp_path: Path) -> None:
    sections(tmp_path / "log.csv")
    pose_of = {"position": ["X", "Y", "Z"], "body": "tool", "units": {"position": "mm"}}
    source = {"time": {"rate_hz": 10}, "pose": pose_of}
    force = {"time": {"rate_hz": 10}, "wrench": {"columns": ["Fx", "Fy", "Fz"], "axes": "base", "point": "tool"}}

    def code(table: dict[str, object]) -> FaultCode:
        model = source_type().model_validate({"sampling": "time", **table})
        with pytest.raises(InputError) as caught:
            list(read_rows(tmp_path, "log", model, {"": "log.csv"}))
        return caught.value.faults[0].code

    assert code(force) is FaultCode.LOG_PART_AMBIGUOUS
    assert code(source | {"csv": {"section": "Trajectory"}}) is FaultCode.LOG_PART_MISSING
    assert code(force | {"csv": {"section": "Trajectories"}}) is FaultCode.COLUMN_MISSING


def test_places_in_a_table_are_lines_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    sections(path)
    reader = find_reader(path)
    row = path.read_text().splitlines().index("Trajectories") + 6
    assert reader.place_of_row(path, {"section": "Trajectories"}, 1) == f"line {row}"
    lines = path.read_text().split("\n")
    lines[row + 1] = lines[row + 1].replace(",0,", ",0,x", 1)
    path.write_text("\n".join(lines))
    with pytest.raises(InputError) as caught:
        list(reader.read_batches(path, {"section": "Trajectories"}, WantedColumns(("X",))))
    assert caught.value.faults[0].place.startswith(f"line {row + 2}")


def test_titles_and_remarks_are_no_tables(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = "".join(f"{k},1,2,{k}\n" for k in range(9))
    path.write_text(f"Hall 4\n\nOperator\n\nt,Fx,Fy,Fz\n{rows}\nmeans\n1,2\n")
    assert find_reader(path).tables(path) == ({},)


def test_a_workbook_in_place_of_a_text_is_a_log_of_the_same_device(tmp_path: Path) -> None:
    names = {"axes": "axes", "force": "force", "arm": "arm"}
    for k in range(1, 5):
        for table in names:
            columns = TABLES[table]
            head, rows = ",".join(columns), np.column_stack(list(columns.values()))
            if (k, table) != (3, "force"):
                lines = "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())
                (tmp_path / f"p{k}_{table}.csv").write_text(f"{head}\n{lines}")
                continue
            with xlsxwriter.Workbook(tmp_path / f"p{k}_{table}.xlsx") as book:
                sheet = book.add_worksheet("saved")
                for column, (name, values) in enumerate(columns.items()):
                    sheet.write_column(0, column, [name, *values])
    draft = draft_from_folder(tmp_path)
    assert draft.runs == ("p1", "p2", "p3", "p4")
    assert 'file = "raw/{run}_force.*"' in draft.manifest
    assert draft.remarks == ()


def test_columns_of_unequal_length_are_not_proposed_as_one_source(tmp_path: Path) -> None:
    fast = np.repeat(FORCE, 2, axis=0)
    np.savez(tmp_path / "log.npz", t=np.linspace(0.0, 1.9, 2 * N), force=fast, pos=PLACE)
    kind = log_kind(tmp_path / "log.npz", "log.npz", FrameNames())
    assert kind.why_not
