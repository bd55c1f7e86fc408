"""What campaign.toml states and nothing reads is named, a line each; what something reads never is."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stiffcal.campaign.checks.unused_settings import unused_settings
from stiffcal.campaign.loading import load_campaign
from stiffcal.ingest.checks.loaded import check_campaign
from tests.laboratory.small_campaign import write_small_campaign

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    return write_small_campaign(tmp_path / "c")


def edited(folder: Path, *changes: tuple[str, str]) -> list[str]:
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return unused_settings(load_campaign(folder, check_files=False).manifest)


def test_what_is_read_is_not_named(campaign: Path) -> None:
    assert edited(campaign) == []


FRAMES = """
[frames.stand]
parent = "base"
xyz_m = [1.0, 0.0, 0.0]
[frames.tracker]
parent = "stand"
[frames.old_hook]
parent = "flange"
xyz_m = [0.0, 0.0, 0.2]
[frames.target]"""
ROD = """
[ids.ids9]
link = "LINK"
start_m = [0.0, 0.1, 0.0]
end_m = [0.5, 0.1, 0.0]

[sources.table]"""


def test_a_frame_without_a_reader_is_named_and_one_that_carries_another_is_not(campaign: Path) -> None:
    (line,) = edited(campaign, ("[frames.target]", FRAMES), ('frame = "base"', 'frame = "tracker"'))
    assert "frames.old_hook is not used" in line


def test_a_rod_without_a_column_is_named(campaign: Path) -> None:
    chain = load_campaign(campaign, check_files=False).chain
    (line,) = edited(campaign, ("[sources.table]", ROD.replace("LINK", chain.link_names[1])))
    assert "ids.ids9 is not used" in line


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ('units = { force = "N" }', 'units = { force = "N", moment = "N*m" }', "sources.table.wrench.units.moment"),
        (
            'units = { force = "N" }',
            'units = { force = "N" }, sigma = { force = 1.0, moment = 1.0 }',
            "sources.table.wrench.sigma.moment",
        ),
        (
            'units = { position = "deg" }',
            'units = { position = "deg", current = "A" }',
            "sources.table.joints.units.current",
        ),
        (
            'units = { position = "deg" }',
            'units = { position = "deg" }, torque_constant = 1.5',
            "sources.table.joints.torque_constant",
        ),
        ('rotvec = ["rx", "ry", "rz"]\n', "", "sources.table.pose.units.rotation"),
        ('file = "raw/states.csv"', 'file = "raw/states.csv"\nhdf5 = { group = "/a" }', "sources.table.hdf5"),
        (
            "[sources.table]",
            '[[runs]]\nid = "pose1"\nmoved_joint = 2\n\n[sources.table]',
            "runs[1] (pose1).moved_joint",
        ),
    ],
)
def test_a_setting_of_what_is_not_read_is_named(campaign: Path, old: str, new: str, place: str) -> None:
    (line,) = edited(campaign, (old, new))
    assert f" {place} is not used: " in line


def test_check_says_so_and_knows_what_a_simulation_reads(campaign: Path) -> None:
    edited(campaign, ("[frames.target]", '[frames.hook]\nparent = "flange"\n[frames.target]'))
    assert any("frames.hook is not used" in line for line in check_campaign(campaign).warnings)
    shutil.copy(CAMPAIGNS / "kr240" / "simulate.toml", campaign)
    assert not any("is not used" in line for line in check_campaign(campaign).warnings)


@pytest.mark.parametrize("name", ["demo", "irb4400", "kr125", "max100", "ipa-ur10", "fanuc-r2000ic"])
def test_bundled_campaigns_state_nothing_without_a_reader(name: str) -> None:
    assert unused_settings(load_campaign(CAMPAIGNS / name, check_files=False).manifest) == []
