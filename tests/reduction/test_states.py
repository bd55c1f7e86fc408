"""Tables and logs become load states: units, axes, signs, runs, references, exclusions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.tables import states_from_table, states_table
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.reduction.states.references import reference_states
from tests.laboratory.hidden_campaigns import reduced

ROBOT = """schema = "stiffcal/robot/1"
convention = "modified-dh"
[[joints]]
name = "A1"
d_m = 0.5
[[joints]]
name = "A2"
alpha_deg = -90
[[joints]]
name = "A3"
a_m = 0.6
[flange]
xyz_m = [0.4, 0, 0]
"""
MANIFEST = """schema = "stiffcal/campaign/1"
[sources.table]
file = "raw/table.csv"
run = { each = "row" }
joints = { position = "A1..A3", units = { position = "deg" } }
wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "kN" }, axes = "base", point = "tool" }
deflection = { translation = ["dx", "dy", "dz"], units = { translation = "mm" }, body = "tool", axes = "base" }
[frames.tool]
parent = "flange"
xyz_m = [0.0, 0.0, 0.2]
"""
TABLE = """A1,A2,A3,Fx,Fy,Fz,dx,dy,dz
90,0,0,0.1,0,0,0.3,0.01,0
0,-30,30,0,0.2,0,0,0.5,0
10,-60,80,0,0,0.3,0.01,0,0.7
"""


def folder_of(path: Path, manifest: str = MANIFEST, table: str = TABLE, robot: str = ROBOT) -> Path:
    """Write a campaign of three poses with deflections."""
    (path / "raw").mkdir(parents=True, exist_ok=True)
    (path / "campaign.toml").write_text(manifest, encoding="utf-8")
    (path / "robot.toml").write_text(robot, encoding="utf-8")
    (path / "raw" / "table.csv").write_text(table, encoding="utf-8")
    return path


def states_of(folder: Path) -> LoadStates:
    return reduce_campaign(load_campaign(folder), no_progress).states


def test_the_shortest_table(tmp_path: Path) -> None:
    states = states_of(folder_of(tmp_path))
    assert [run.name for run in states.runs] == ["1", "2", "3"]
    np.testing.assert_allclose(states.joints[0], [np.pi / 2, 0.0, 0.0])
    np.testing.assert_allclose(states.wrench[1], [0.0, 200.0, 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(states.deflection[2, 0, :3], [1e-5, 0.0, 7e-4])
    assert np.isnan(states.deflection[:, :, 3:]).all()
    assert states.deflection_given
    assert not states.reference.any()
    assert not states.setup.moments_measured


def test_the_reading_may_be_what_the_robot_does(tmp_path: Path) -> None:
    manifest = MANIFEST.replace('point = "tool" }', 'point = "tool", acts_on = "environment" }')
    table = TABLE.replace("0.1,0,0,", "-0.1,0,0,").replace("0,0.2,0,", "0,-0.2,0,").replace("0,0,0.3,", "0,0,-0.3,")
    np.testing.assert_allclose(states_of(folder_of(tmp_path, manifest, table)).wrench[0, 0], 100.0)


def test_columns_in_several_files(tmp_path: Path) -> None:
    manifest = MANIFEST.replace(
        'file = "raw/table.csv"', 'files = { joints = "raw/j.csv", wrench = "raw/f.csv", deflection = "raw/d.csv" }'
    )
    folder = folder_of(tmp_path, manifest)
    rows = [line.split(",") for line in TABLE.splitlines()]
    for file, columns in {"j": slice(0, 3), "f": slice(3, 6), "d": slice(6, 9)}.items():
        (folder / "raw" / f"{file}.csv").write_text("\n".join(",".join(row[columns]) for row in rows) + "\n")
    whole = states_of(folder_of(tmp_path / "whole"))
    np.testing.assert_array_equal(states_of(folder).deflection, whole.deflection)
    (folder / "raw" / "f.csv").write_text("Fx,Fy,Fz\n1,2,3\n")
    with pytest.raises(InputError, match="differ in length"):
        states_of(folder)


def test_rows_are_excluded_and_kept_with_the_reason(tmp_path: Path) -> None:
    manifest = MANIFEST + '\n[[exclude]]\nsource = "table"\nrows = [2]\nwhy = "cable slipped"\n'
    states = states_of(folder_of(tmp_path, manifest))
    assert states.set_aside.tolist() == ["", "excluded in the manifest: cable slipped", ""]
    beyond = manifest.replace("rows = [2]", "rows = [9]")
    with pytest.raises(InputError, match="no data row 9"):
        states_of(folder_of(tmp_path / "beyond", beyond))


def test_rows_are_kept_by_a_condition(tmp_path: Path) -> None:
    manifest = MANIFEST.replace('axes = "base", point = "tool" }', 'axes = "base", point = "tool", rows = "Fz < 0.2" }')
    states = states_of(folder_of(tmp_path, manifest))
    assert states.row.tolist() == [1, 2]


def test_a_known_mass_is_the_load(tmp_path: Path) -> None:
    manifest = MANIFEST.replace(
        'wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "kN" }, axes = "base", point = "tool" }',
        'dead_weight = { mass_column = "kg", point = "tool" }',
    )
    table = "A1,A2,A3,kg,dx,dy,dz\n90,0,0,10,0,0,-0.3\n0,-30,30,20,0,0,-0.5\n10,-60,80,30,0,0,-0.7\n"
    states = states_of(folder_of(tmp_path, manifest, table))
    np.testing.assert_allclose(states.wrench[:, 2], [-98.1, -196.2, -294.3], rtol=1e-3)


def test_references_are_the_first_unless_stated() -> None:
    run = np.array([0, 0, 0, 1, 1])
    usable = np.array([False, True, True, True, True])
    assert reference_states(run, ["a", "b"], {}, usable).tolist() == [False, True, False, True, False]
    assert reference_states(run, ["a", "b"], {"b": 2}, usable).tolist() == [False, True, False, False, True]
    with pytest.raises(InputError, match="the run has 2 states"):
        reference_states(run, ["a", "b"], {"b": 3}, usable)


def test_practice_meets_kinematics_in_base_axes() -> None:
    states = reduced("01").states
    assert len(states) == 1164
    assert states.reference.sum() == 12
    assert np.abs(np.linalg.det(states.rotation[:, 0]) - 1.0).max() < 1e-9


def test_raw_logs_and_table_give_the_same_states() -> None:
    raw, table = reduced("13-raw").states, reduced("13-table").states
    assert raw.run.tolist() == table.run.tolist()
    # 48 readings with 10 µm noise and 190 with 1.5 N and 0.5 N·m
    assert np.sqrt(np.mean((raw.position - table.position) ** 2)) < 2e-6
    assert np.sqrt(np.mean((raw.wrench - table.wrench)[:, :3] ** 2)) < 0.15
    assert np.sqrt(np.mean((raw.wrench - table.wrench)[:, 3:] ** 2)) < 0.05
    turn = vector_from_rotation(raw.rotation @ np.swapaxes(table.rotation, -1, -2))
    assert np.abs(turn).max() < 1e-8
    assert np.nanmedian(raw.wrench_scatter[:, :3]) == pytest.approx(1.5, rel=0.1)
    assert np.nanmedian(raw.position_scatter) == pytest.approx(1e-5, rel=0.1)
    assert raw.hold[5] == pytest.approx(1.0 + 0.5 * 0.8, abs=0.1)


@pytest.mark.parametrize("name", ["03", "11", "13-raw"])
def test_states_survive_the_table(name: str) -> None:
    states = reduced(name).states
    again = states_from_table(states_table(states, tuple("abcdefg"[: states.joints.shape[1]])))
    assert again.runs == states.runs
    for field in (
        "run",
        "time",
        "hold",
        "joints",
        "wrench",
        "position",
        "deflection",
        "reference",
        "row",
        "n_readings",
    ):
        np.testing.assert_array_equal(getattr(again, field), getattr(states, field))
    np.testing.assert_allclose(again.rotation, states.rotation, atol=1e-14)
    assert (again.set_aside == states.set_aside).all()
    assert (again.set_aside_code == states.set_aside_code).all()
    np.testing.assert_array_equal(again.setup.wrench_axes.transform, states.setup.wrench_axes.transform)
