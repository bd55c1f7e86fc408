"""Check: what was understood, what is missing, every fault with its place."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.absolute import _joint
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.wording import significant
from tests.laboratory.hidden_campaigns import copied, edit, edit_table, first_run_alone
from tests.reduction.test_states import MANIFEST, folder_of

ABSOLUTE = Path(__file__).parents[2] / "campaigns" / "absolute" / "02"


def test_a_raw_run_is_understood(tmp_path: Path) -> None:
    document = document_of(check_campaign(first_run_alone(tmp_path)))
    reported = {source["source"]: source for source in document["sources"]}
    assert reported["ft"]["rate_hz"] == pytest.approx(100.0, rel=0.01)
    assert reported["tracker"]["rate_hz"] == pytest.approx(25.0, rel=0.01)
    assert reported["tracker"]["span_s"] == pytest.approx(140.08)
    assert reported["ft"]["rows"] == 13915
    column = next(entry for entry in reported["tracker"]["columns"] if entry["column"] == "X")
    assert column["unit"] == "mm"
    assert column["low_si"] == pytest.approx(1.805, abs=0.001)
    assert document["kinematics"]["median_m"] < 0.02
    assert document["runs"][0]["n_states"] == 49
    assert document["runs"][0]["clock_ahead_s"]["tracker"]["value"] == pytest.approx(1.3523, abs=0.01)


def test_a_whole_campaign_is_ready(tmp_path: Path) -> None:
    document = document_of(check_campaign(copied("01", tmp_path)))
    assert document["ready"] is True
    assert document["missing"] == []
    assert all(joint["expected_relative_std"] < 0.1 for joint in document["joints"])


def test_quick_reads_the_beginning(tmp_path: Path) -> None:
    document = document_of(check_campaign(copied("13-raw", tmp_path), quick=True))
    assert document["ready"] is True
    assert document["kinematics"]["median_m"] < 0.02


def test_runs_still_to_be_measured_are_missing_not_wrong(tmp_path: Path) -> None:
    folder = copied("13-raw", tmp_path)
    for path in (folder / "raw").glob("pose0[23]_*"):
        path.unlink()
    document = document_of(check_campaign(folder))
    assert document["ready"] is False
    assert any("pose02" in line for line in document["missing"])
    assert [run["id"] for run in document["runs"]] == ["pose01"]


def test_one_run_alone(tmp_path: Path) -> None:
    document = document_of(check_campaign(copied("13-table", tmp_path), run="pose03"))
    assert [run["id"] for run in document["runs"]] == ["pose03"]


def test_every_faulty_file_is_named(tmp_path: Path) -> None:
    folder = copied("13-raw", tmp_path)
    edit(folder / "raw/pose01_tracker.csv", ("\n400,0;", "\n300,0;"))
    edit(folder / "raw/pose02_ft.csv", ("Time,Fx,Fy", "Time,Fx,Fyy"))
    with pytest.raises(InputError) as raised:
        check_campaign(folder)
    assert {fault.file for fault in raised.value.faults} == {"raw/pose01_tracker.csv", "raw/pose02_ft.csv"}


def test_a_joint_that_sees_no_torque_is_named(tmp_path: Path) -> None:
    # forces in the plane of the arm through the first axis: joint 1 is never turned
    table = "A1,A2,A3,Fx,Fy,Fz,dx,dy,dz\n"
    table += "".join(
        f"0,{a},{b},0.1,0,{z},0.1,0,0.2\n" for a, b, z in [(-20, 40, 0.2), (-50, 70, -0.2), (-10, 90, 0.3)]
    )
    manifest = MANIFEST.replace("xyz_m = [0.0, 0.0, 0.2]", "xyz_m = [0.1, 0.0, 0.0]")
    document = document_of(check_campaign(folder_of(tmp_path, manifest, table)))
    assert document["ready"] is False
    assert any("A1" in line and "no torque" in line for line in document["missing"])


def test_sources_without_a_load_are_one_thing_that_is_missing(tmp_path: Path) -> None:
    """Not one for each joint: what the instruments log lies in files that nothing reads."""
    folder = first_run_alone(tmp_path)
    without = re.sub(
        r"(?ms)^\[sources\.ft\.wrench\].*?(?=^\[|\Z)", "", (folder / "campaign.toml").read_text(encoding="utf-8")
    )
    without = re.sub(r"(?ms)^\[sources\.ft\].*?(?=^\[)", "", without)
    (folder / "campaign.toml").write_text(re.sub(r'\bft = "[^"]*", ', "", without), encoding="utf-8")
    assert len(check_campaign(folder).missing) == 1


def test_a_fault_of_the_table_has_line_and_column(tmp_path: Path) -> None:
    folder = folder_of(tmp_path, MANIFEST)
    edit(folder / "raw/table.csv", ("0,-30,30,0,0.2", "0,-30,30,0,oops"))
    with pytest.raises(InputError, match=r"raw/table\.csv: line 3.*Fy"):
        check_campaign(folder)


def test_swapped_joints_are_named(tmp_path: Path) -> None:
    folder = copied("13-table", tmp_path)

    def swap(header: list[str], _: list[list[str]]) -> None:
        header[3], header[4] = header[4], header[3]

    edit_table(folder, swap)
    with pytest.raises(InputError, match="joint columns A1 and A2 interchanged"):
        check_campaign(folder)


def test_check_states_what_a_few_absolute_poses_lack(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(ABSOLUTE, tmp_path / "few", ignore=shutil.ignore_patterns("store")))
    table = folder / "raw" / "poses.csv"
    lines = table.read_text().splitlines()
    for n_poses in (1, 3):
        table.write_text("\n".join(lines[: n_poses + 1]) + "\n")
        result = check_campaign(folder)
        assert not result.ready
        assert result.n_states == n_poses
        assert [run.id for run in result.runs] == ["poses"]
        assert "measure 4 or more poses" in result.missing[0]
        # 6 compliances, 24 of geometry, 6 and 3 of frames: the frames take up 4 n + 3 of 4 n + 9
        assert "33 numbers of the model (6 more are conventions and not estimated)" in result.missing[1]
    table.write_text("\n".join([lines[0], *[lines[1]] * 6]) + "\n")
    with pytest.raises(InputError) as caught:  # rows enough, of one pose: a mistake, and no table half measured
        check_campaign(folder)
    assert caught.value.code is FaultCode.POSES_TOO_FEW


@pytest.mark.parametrize(
    ("rows", "stated", "source", "words"),
    [
        (40, True, "manifest", "sigma of campaign.toml, 0.0346 mm rms in distance"),
        (40, False, "none", "not known: campaign.toml states no sigma, and 0 pairs of rows that repeat each other are"),
        (28, False, "repeats", "estimated from 12 pairs of rows that repeat each other"),
    ],
)
def test_check_states_from_what_the_noise_is_known(
    rows: int, stated: bool, source: str, words: str, tmp_path: Path
) -> None:
    folder = Path(shutil.copytree(ABSOLUTE, tmp_path / "poses", ignore=shutil.ignore_patterns("store")))
    table, manifest = folder / "raw" / "poses.csv", folder / "campaign.toml"
    head, *lines = table.read_text().splitlines()
    again = [repeated(line, number) for number, line in enumerate(lines[: 40 - rows])]
    table.write_text("\n".join([head, *lines[:rows], *again]) + "\n")
    if not stated:
        manifest.write_text(re.sub(r"(?m)^sigma = .*$", "", manifest.read_text()))
    noise = check_campaign(folder).noise
    assert noise is not None
    assert noise.source == source
    assert words in noise.says
    assert noise.n_pairs == 40 - rows
    assert (noise.rms_m is None) == (source == "none")


def repeated(line: str, number: int) -> str:
    """Return a row of a table again, later, its places (the last three columns, mm) with 0.02 mm of noise."""
    cells = line.split(",")
    read = np.array(cells[-3:], dtype=float) + np.random.default_rng(number).normal(0.0, 0.02, 3)
    return ",".join([f"{5000 + number}", *cells[1:-3], *(f"{value:.5f}" for value in read)])


@pytest.mark.long
def test_check_states_what_more_poses_or_a_payload_would_bring(tmp_path: Path) -> None:
    """Of campaign 01 joint 4 carries 8 N·m at most; joint 1 is vertical, and no weight turns it."""
    folder = Path(shutil.copytree(ABSOLUTE.parent / "01", tmp_path / "poses", ignore=shutil.ignore_patterns("store")))
    joints = {joint.joint: joint for joint in check_campaign(folder).joints or []}
    found = re.search(
        r"about (\d+) such poses in all or (\d+) kg at the flange in half of the poses", joints["A4"].says
    )
    assert found is not None
    relative = joints["A4"].expected_relative_std
    assert relative is not None
    assert int(found[1]) == pytest.approx(80 * (relative / 0.2) ** 2, rel=0.05)
    assert 5 < int(found[2]) < 50
    identify_campaign(folder)
    elasticity = validate_campaign(folder).elasticity
    assert elasticity is not None
    payload = {joint.joint: joint.payload_kg for joint in elasticity.joints}[4]
    assert payload is not None
    assert significant(payload, 2) == found[2]  # one advice, whichever command gives it
    assert " kg" not in joints["A1"].says
    assert " kg" not in joints["A2"].says


@pytest.mark.parametrize(
    ("torque", "along", "words"),
    [
        (55.5, 5, "what its torque does cannot be distinguished from errors of geometry"),
        (5e-15, 5, "neither weight nor load produces torque on it"),
        (55.5, 2, "what its force does cannot be distinguished from errors of geometry"),
        (5e-15, 2, "neither weight nor load produces force on it"),
    ],
)
def test_check_states_why_a_stiffness_stays_open(torque: float, along: int, words: str) -> None:
    """A joint that carries 55 N·m (prismatic: 55 N) and whose spring the geometry takes up carries something."""
    place = SimpleNamespace(joints=(2,))
    open_one = SimpleNamespace(spec=SimpleNamespace(compliance=True, along=along), place=place, value=None)
    chain = SimpleNamespace(prismatic=[False, along == 2], drive_components=[5, along])
    # one place of a run of loads next to absolute ones: no payload is proposed then
    data = SimpleNamespace(absolute=np.array([True, False]))
    fit: Any = SimpleNamespace(parameters=[open_one], data=data, robot=SimpleNamespace(chain=chain))
    joint = _joint("A2", torque, fit, 2)
    assert words in joint.says
    assert joint.prismatic is (True if along == 2 else None)
