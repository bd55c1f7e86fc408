"""An angle that a controller counts together with the one before it is named, in displacements and in places."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reducing import reduce_campaign
from stiffcal.reduction.angle_conventions import coupled_angles
from stiffcal.reduction.consistency import check_kinematics
from tests.laboratory.displacement_table import displacement_columns, write_displacement_campaign
from tests.laboratory.hidden_campaigns import folder_of, reduced
from tests.laboratory.robots import six_axes

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"
SIGNS = {1: "logged = { A2 = 1, A3 = 1 }", -1: "logged = { A2 = -1, A3 = 1 }"}


def test_parallel_axes_alone_are_counted_together() -> None:
    assert {coupled.place for coupled in coupled_angles(np.zeros((1, 6)), six_axes())} == {"joints A2 and A3"}


@pytest.mark.parametrize("rows", [8, 24])
@pytest.mark.parametrize("sign", SIGNS)
def test_in_a_table_of_displacements(sign: int, rows: int, tmp_path: Path) -> None:
    columns = displacement_columns(rows)
    columns["A3"] -= sign * columns["A2"]
    folder = write_displacement_campaign(tmp_path / "cell", columns)
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(folder), no_progress)
    (fault,) = refused.value.faults
    assert fault.code is FaultCode.KINEMATICS_MISMATCH
    assert SIGNS[sign] in fault.mend
    # what is to be written there mends it
    robot = folder / "robot.toml"
    robot.write_text(robot.read_text().replace('name = "A3"', f'name = "A3"\n{SIGNS[sign]}'))
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == rows


def test_a_sound_table_is_let_pass(tmp_path: Path) -> None:
    folder = write_displacement_campaign(tmp_path / "cell", displacement_columns(8))
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == 8


@pytest.mark.parametrize("sign", SIGNS)
def test_in_places_under_load(sign: int) -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    joints = states.joints.copy()
    joints[:, 2] -= sign * joints[:, 1]
    (fault,) = check_kinematics(replace(states, joints=joints), chain, estimated=False)
    assert SIGNS[sign] in fault.mend


@pytest.mark.parametrize("sign", SIGNS)
def test_in_a_table_of_absolute_places(sign: int, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(CAMPAIGN, tmp_path / "cell"))
    table = folder / "raw" / "poses.csv"
    header, *rows = [line.split(",") for line in table.read_text().splitlines()]
    second, third = header.index("A2"), header.index("A3")
    for row in rows:
        row[third] = repr(float(row[third]) - sign * float(row[second]))
    table.write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n")
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(folder), no_progress)
    (fault,) = refused.value.faults
    assert SIGNS[sign] in fault.mend
