"""Rods on links and gauges along a line: from the manifest's signals into load states, and through the store."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from stiffcal.measurements.tables import states_from_table, states_table
from stiffcal.mistakes.displacements.springs import work_of_load
from stiffcal.reduction.loads.excitation import joint_excitation
from stiffcal.reduction.loads.motion import motion_of
from tests.reduction.test_states import ROBOT, folder_of, states_of

MANIFEST = """schema = "stiffcal/campaign/1"
[sources.y]
sampling = "states"
joints = { position = "A1..A3", units = { position = "deg" } }
wrench = { columns = ["F"], direction = [0, -2, 0], axes = "base", point = "tool", units = { force = "kN" } }
displacement = { column = "s", units = { length = "mm" }, body = "tool", direction = [0, -1, 0] }
lengths = { columns = ["r1", "r2"], units = { length = "um" } }
[sources.z]
sampling = "states"
joints = { position = "A1..A3", units = { position = "deg" } }
wrench = { columns = ["F"], direction = [0, 0, 1], axes = "base", point = "tool", units = { force = "kN" } }
displacement = { column = "s", units = { length = "mm" }, body = "tool", direction = [0, 0, 1] }
lengths = { columns = ["r1", "r2"], units = { length = "um" } }
[ids.r1]
link = "link2"
start_m = [0.1, 0.05, 0.0]
end_m = [0.5, 0.05, 0.0]
[ids.r2]
link = "link2"
start_m = [0.1, -0.05, 0.0]
end_m = [0.4, -0.05, 0.0]
[frames.tool]
parent = "flange"
xyz_m = [0.0, 0.0, 0.2]
[[runs]]
id = "across"
files = { y = "raw/table.csv" }
[[runs]]
id = "up"
files = { z = "raw/up.csv" }
"""
ACROSS = "A1,A2,A3,F,s,r1,r2\n0,-30,60,0,5,100,200\n0,-30,60,0.5,5.4,90,207\n0,-30,60,1,5.8,80,214\n"
UP = "A1,A2,A3,F,s,r1,r2\n30,-50,80,0,1,100,200\n30,-50,80,0.5,1.3,110,190\n30,-50,80,1,1.6,120,180\n"


def campaign_of(path: Path, manifest: str = MANIFEST) -> Path:
    folder = folder_of(path, manifest, ACROSS, ROBOT)
    (folder / "raw" / "up.csv").write_text(UP, encoding="utf-8")
    return folder


def test_each_run_reads_its_own_device(tmp_path: Path) -> None:
    states = states_of(campaign_of(tmp_path))
    assert states.setup.rod_names == ("r1", "r2")
    assert [(gauge.name, gauge.target) for gauge in states.setup.gauges] == [("y", 0), ("z", 0)]
    np.testing.assert_allclose(states.lengths[:2], [[100e-6, 200e-6], [90e-6, 207e-6]], rtol=1e-12)
    np.testing.assert_allclose(states.displacement[:, 0], [5e-3, 5.4e-3, 5.8e-3, np.nan, np.nan, np.nan])
    np.testing.assert_allclose(states.displacement[3:, 1], [1e-3, 1.3e-3, 1.6e-3])
    np.testing.assert_allclose(states.wrench[2], [0.0, -1000.0, 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(states.wrench[5], [0.0, 0.0, 1000.0, 0.0, 0.0, 0.0])
    assert not states.has_poses
    np.testing.assert_allclose(states.setup.rods[0].length, [0.4, 0.3])


def test_a_strain_counts_in_each_rods_length(tmp_path: Path) -> None:
    lengths = states_of(campaign_of(tmp_path / "lengths")).lengths
    written = MANIFEST.replace(
        '"r2"], units = { length = "um" }', '"r2"], units = { length = "µm/m" }, sigma = { length = 2.0 }'
    )
    states = states_of(campaign_of(tmp_path / "strains", written))
    (rods,) = states.setup.rods
    np.testing.assert_allclose(rods.length, [0.4, 0.3])
    np.testing.assert_allclose(states.lengths, lengths * rods.length, rtol=1e-12)
    np.testing.assert_allclose(rods.sigma, [0.8e-6, 0.6e-6])
    assert states.setup.sigma.length == pytest.approx(np.sqrt(0.5) * 1e-6)


def test_through_the_stores_table_and_back(tmp_path: Path) -> None:
    states = states_of(campaign_of(tmp_path))
    back = states_from_table(states_table(states))
    np.testing.assert_array_equal(back.lengths, states.lengths)
    np.testing.assert_array_equal(back.displacement, states.displacement)
    (rods,), (beam,) = back.setup.rods, back.setup.beams
    assert (rods.link, rods.names, beam) == ("link2", ("r1", "r2"), states.setup.beams[0])
    np.testing.assert_array_equal(rods.end, states.setup.rods[0].end)
    assert np.isnan(rods.sigma).all()
    assert np.isnan(rods.warping).all()
    assert back.setup.gauges[1].direction.tolist() == [0.0, 0.0, 1.0]
    picked = back.select(np.array([1, 4]))
    np.testing.assert_allclose(picked.lengths[:, 0], [90e-6, 110e-6])
    np.testing.assert_allclose(picked.displacement[1], [np.nan, 1.3e-3])


def test_campaigns_without_them_have_none(tmp_path: Path) -> None:
    states = states_of(folder_of(tmp_path))
    assert states.lengths.shape == states.displacement.shape == (3, 0)
    assert not [name for name in states_table(states).column_names if "length" in name or "displacement" in name]


def test_gauges_alone_show_work_and_what_joints_see(tmp_path: Path) -> None:
    folder = campaign_of(tmp_path)
    states, chain = states_of(folder), load_campaign(folder).chain
    # half of both steps: 500 N over 0.4 mm and 1000 N over 0.8 mm; 500 N over 0.3 mm and 1000 N over 0.6 mm
    np.testing.assert_allclose(work_of_load(states, chain).work, [1.0, 0.75])
    motion = motion_of(states, chain)
    assert motion.measured.shape == (6, 2)
    np.testing.assert_allclose(motion.axes[0, 0], [0.0, -1.0, 0.0])
    # two slopes are no three springs: only joint 1 turns under the force across
    entries = joint_excitation(states, chain)
    assert [entry.identifiable for entry in entries] == [True, False, False]
    assert entries[1].torque > 100.0


def test_a_device_that_pulls_the_other_way_is_reported(tmp_path: Path) -> None:
    manifest = MANIFEST.replace("direction = [0, -2, 0]", "direction = [0, 2, 0]").replace(
        'direction = [0, 0, 1], axes = "base"', 'direction = [0, 0, -1], axes = "base"'
    )
    with pytest.raises(InputError, match="force and deflection have opposite directions"):
        states_of(campaign_of(tmp_path, manifest))


def test_two_devices_in_one_run_are_one_too_many(tmp_path: Path) -> None:
    alone = MANIFEST.replace('[[runs]]\nid = "across"\nfiles = { y = "raw/table.csv" }\n', "")
    manifest = alone.replace('files = { z = "raw/up.csv" }', 'files = { z = "raw/up.csv", y = "raw/table.csv" }')
    with pytest.raises(InputError, match="measured twice"):
        states_of(campaign_of(tmp_path, manifest))


def test_a_rod_on_a_link_that_does_not_bend(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"ids\.r1\.link: \"link1\" is not a link that can bend"):
        states_of(campaign_of(tmp_path, MANIFEST.replace('link = "link2"', 'link = "link1"', 1)))
    with pytest.raises(InputError, match="start_m and end_m are the same point"):
        states_of(campaign_of(tmp_path / "b", MANIFEST.replace("end_m = [0.5, 0.05, 0.0]", "end_m = [0.1, 0.05, 0.0]")))
