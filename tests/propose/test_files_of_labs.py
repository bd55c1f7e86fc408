"""Files as laboratories have them: what is proposed for each of them reads every value, with no edit."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.manifest_type import source_type
from stiffcal.propose.from_table import draft_campaign
from stiffcal.propose.lines import FrameNames
from stiffcal.propose.log_kind import LogKind, log_kind
from stiffcal.reduction.logs.log_rows import read_rows
from tests.laboratory.workbooks import write_xlsx

FILES = Path(__file__).parents[1] / "laboratory" / "data" / "files"
DEG = np.pi / 180.0
# of a signal: its first column in the file (those of a signal stand next to each other), and their size in SI
JOINTS_DEG, JOINTS_RAD = ("joints", DEG), ("joints", 1.0)
FORCE, PLACE, MOVED = ("wrench", 1.0), ("position.tool", 1e-3), ("translation", 1e-3)
EXCEL = {0: JOINTS_DEG, 6: FORCE, 9: MOVED}
Columns = dict[int, tuple[str, float]]
COMMA, TAB, BLANKS = ",", "\t", None
SHOWN: tuple[tuple[str, str | None, int, Columns], ...] = (
    ("01-optitrack-motive/take.csv", COMMA, 49, {6: PLACE}),
    ("02-rtde-recorder/robot_data.csv", BLANKS, 29, {7: JOINTS_RAD}),
    ("02b-aligned-columns/axes.dat", BLANKS, 29, {1: JOINTS_DEG}),
    ("03-labview-lvm/force.lvm", TAB, 37, {1: FORCE}),
    ("03-labview-lvm/force_no_x.lvm", TAB, 37, {1: FORCE}),
    ("04-excel/ghost_columns.csv", COMMA, 24, EXCEL),
    ("04-excel/table_german.csv", ";", 24, EXCEL),
    ("04-excel/trailing_comma_in_rows.csv", COMMA, 24, EXCEL),
    ("04-excel/unicode_text.txt", TAB, 24, EXCEL),
    ("05-qualisys-tsv/take.tsv", TAB, 46, {0: PLACE}),
    ("06-libfranka-log/log.csv", COMMA, 29, {1: JOINTS_RAD}),
    ("08-fanuc-j2j3/table_minus.csv", COMMA, 24, EXCEL),
    ("10-autoid-and-savetxt/savetxt.txt", BLANKS, 80, {0: JOINTS_DEG, 6: PLACE}),
    ("11-lift-and-seven-joints/poses.csv", COMMA, 60, {0: ("position.tool", 1.0)}),
    ("12-union-of-times/union.csv", COMMA, 56, {1: FORCE}),
    ("12-union-of-times/union.csv", COMMA, 3, {4: PLACE}),
    ("13-clocks/german_dates.csv", ";", 33, {1: FORCE}),
    ("13-clocks/low_resolution.csv", ";", 33, {1: FORCE}),
    ("16-ndi/fx_and_tx.csv", COMMA, 30, {2: FORCE, 5: PLACE}),
    ("16-ndi/participant.csv", COMMA, 29, {3: PLACE}),
    ("16-ndi/polaris.csv", COMMA, 39, {8: PLACE}),
    ("17-force-drift/force_head.csv", ";", 23, {1: FORCE}),
    ("18-force-rezeroed/pose3_force_head.csv", ";", 23, {1: FORCE}),
    ("19-leica-tracker-pilot/leica.csv", COMMA, 80, {0: PLACE}),
    ("19-leica-tracker-pilot/theta.csv", COMMA, 80, {0: JOINTS_DEG}),
)  # fmt: skip
STEPS = {  # of the time, s
    "01-optitrack-motive/take.csv": 0.4, "02-rtde-recorder/robot_data.csv": 0.024, "05-qualisys-tsv/take.tsv": 0.4,
    "02b-aligned-columns/axes.dat": 0.024, "03-labview-lvm/force.lvm": 0.02, "03-labview-lvm/force_no_x.lvm": 0.02,
    "06-libfranka-log/log.csv": 0.024, "13-clocks/german_dates.csv": 0.02, "13-clocks/low_resolution.csv": 0.02,
    "16-ndi/participant.csv": 0.4, "20-rsi-xml/rsi.xml": 0.024,
}  # fmt: skip


def written(file: str, delimiter: str | None, first: int, count: int) -> Floats:
    """Return the numbers in a file's columns, (n, count), split in the simplest way, but for lost readings."""
    data = (FILES / file).read_bytes()
    text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "cp1252")
    rows = []
    for line in text.splitlines():
        cells = [cell.strip().replace(",", "." if delimiter != "," else ",") for cell in line.split(delimiter)]
        own = cells[first : first + count]
        if re.match(r"[A-Za-z#_]", cells[0]) is None and len(own) == count and all(map(is_number, own)):
            rows.append([float(cell) for cell in own])
    return np.array([row for row in rows if any(row)])


def is_number(cell: str) -> bool:
    return re.fullmatch(r"-?\d+(\.\d+)?([eE][+-]\d+)?", cell) is not None


def readings(file: str) -> list[tuple[LogKind, Floats, dict[str, Floats]]]:
    path, found = FILES / file, []
    kind = log_kind(path, path.name, FrameNames())
    assert not kind.why_not
    for part in (kind, *kind.further):
        lines = "\n".join(map(str, part.lines))
        if part.time is None:  # a table of states
            lines = lines.replace("time = {}", "").replace('"time"', '"states"')
        source = source_type().model_validate(tomllib.loads(lines))
        rows = list(read_rows(path.parent, "log", source, {"": path.name}))
        signals = {key: np.concatenate([own.signals[key] for own in rows], axis=1) for key in rows[0].signals}
        found.append((part, np.concatenate([own.time for own in rows]), signals))
    return found


@pytest.mark.parametrize(("file", "delimiter", "count", "columns"), SHOWN)
def test_what_is_proposed_reads_every_value(file: str, delimiter: str | None, count: int, columns: Columns) -> None:
    signal = next(iter(columns.values()))[0]
    _, time, signals = next(entry for entry in readings(file) if signal in entry[2])
    if file in STEPS:
        steps = np.round(np.diff(time) / STEPS[file], 4)
        assert np.all(steps == np.round(steps))  # more than one where a target was lost
        assert steps.min() == 1.0
    for first, (name, factor) in columns.items():
        wide = 6 if name == "joints" else 3
        expected = factor * written(file, delimiter, first, wide)
        assert len(expected) == count
        assert np.allclose(signals[name][:wide], expected.T, rtol=1e-12, atol=1e-15)


def test_angles_in_documents_of_rsi_and_cells_of_a_workbook() -> None:
    [(_, time, signals)] = readings("20-rsi-xml/rsi.xml")
    text = (FILES / "20-rsi-xml/rsi.xml").read_text()
    angles = np.array(re.findall(r'A\d="(-?[\d.]+)"', text), dtype=np.float64).reshape(-1, 6)
    assert np.allclose(signals["joints"], DEG * angles.T, rtol=1e-12)
    assert np.allclose(np.diff(time), STEPS["20-rsi-xml/rsi.xml"])
    [(_, _, signals)] = readings("04-excel/table.xlsx")
    [(_, _, of_text)] = readings("04-excel/table_german.csv")
    for name, values in of_text.items():
        assert np.allclose(signals[name], values, rtol=1e-12)


def test_each_column_has_its_unit_and_its_reason() -> None:
    def found(file: str) -> dict[str, tuple[str, str, str]]:
        return {entry.column: (entry.taken_as, entry.unit, entry.why) for entry in readings(file)[0][0].columns}

    franka, motive = found("06-libfranka-log/log.csv"), found("01-optitrack-motive/take.csv")
    union = found("12-union-of-times/union.csv")
    assert franka["q[0]"][:2] == ("joints", "rad")
    assert "by its values" in franka["q[0]"][2]
    assert motive["plate Position X"][:2] == ("position", "mm")
    assert {union[f"/{name}/x"][0] for name in ("ft/wrench/force", "probe/point")} == {"force", "position"}
    # each for a reason of its own
    reasons = [found("02-rtde-recorder/robot_data.csv")["target_q_0"], motive["Frame"], motive["plate Rotation W"]]
    assert "controller computes" in found("20-rsi-xml/rsi.xml")["RIst.X"][2]
    reasons += [franka["tau_J[0]"], found("05-qualisys-tsv/take.tsv")["b X"], franka["q_d[0]"]]
    assert all(not taken for taken, _, _ in reasons)
    assert len({why for _, _, why in reasons}) == 6


def test_rows_of_a_table_that_are_no_readings_are_excluded_in_the_draft(tmp_path: Path) -> None:
    lines = (FILES / "04-excel/mean_row_below.csv").read_text().splitlines()
    blank = "," * 11
    rows = [*lines[:15], blank, *lines[15:25], blank, *lines[25:]]
    (tmp_path / "t.csv").write_text("\n".join(rows) + "\n")
    cells = [[float(cell) if is_number(cell) else cell for cell in row.split(",")] for row in rows]
    write_xlsx(tmp_path / "t.xlsx", {"log": cells})
    for name, out in (("t.csv", [15, 26, 27, 28]), ("t.xlsx", [25, 26])):  # blank rows of a sheet are none
        [entry] = tomllib.loads(draft_campaign([tmp_path / name], robot="kr125").manifest)["exclude"]
        assert (entry["source"], entry["rows"]) == ("table", out)
