"""The friction runs of campaigns/kr125: 1 to 5 and 10 to 100 % of each joint's velocity, as paper 004 measured them."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import tomlkit

from stiffcal.campaign.loading import load_campaign
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from tests.whole_campaigns.conftest import CAMPAIGNS, Command


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The friction runs alone, which make no use of the clamped ones."""
    plan, out = tmp_path_factory.mktemp("kr125") / "plan", tmp_path_factory.mktemp("friction") / "kr125"
    shutil.copytree(CAMPAIGNS / "kr125", plan, ignore=shutil.ignore_patterns("raw", "store"))
    for name in ("campaign.toml", "simulate.toml"):
        document = tomlkit.parse((plan / name).read_text(encoding="utf-8"))
        runs = document["runs"]
        kept = [run for run in runs if str(run["id"]).startswith("friction")]
        document["runs"] = tomlkit.aot()
        for run in kept:
            document["runs"].append(run)
        for table in ("sources", "sensors"):
            held = document.get(table, {})
            for source in [key for key in held if key != "drives"]:
                held.remove(source)
        (plan / name).write_text(tomlkit.dumps(document), encoding="utf-8")
    simulate_campaign(load_campaign(plan, check_files=False), load_settings(plan), out)
    return out


def test_friction_of_six_drives(folder: Path, command: Command) -> None:
    document = command("identify", folder)
    true = load_campaign(CAMPAIGNS / "kr125", check_files=False).model.parameter_settings()
    found = {p["name"]: p for p in document["parameters"] if p["effect"] == "joint-friction"}
    assert len(found) == 12
    for joint in range(1, 7):
        for symbol in ("coulomb", "viscous"):
            name = f"joint-friction.j{joint}.{symbol}"
            assert abs(found[name]["value"] - true[name].value) < 3.5 * found[name]["std"], name
            assert found[name]["std"] < 0.02 * true[name].value


def test_a_drive_that_does_not_reach_what_is_stated(folder: Path, command: Command) -> None:
    """Joint 5 is programmed up to 3.3 rad/s and reaches 3.1: its last readings stand at what was logged."""
    document = command("identify", folder)
    fifth = document["friction"]["joints"][4]
    assert fifth["highest_speed"] == pytest.approx(3.1, rel=0.005)
    assert document["friction"]["joints"][3]["highest_speed"] == pytest.approx(3.7, rel=0.005)
    assert [round(one["lowest_speed"], 3) for one in document["friction"]["joints"][:3]] == [0.015] * 3


def test_the_stribeck_part_is_missing_where_only_joint_friction_is_modelled(folder: Path, command: Command) -> None:
    """Joint 2's alone has one; it is certain, and the simulated ripple of that joint, of unknown order, is not."""
    text = 'schema = "stiffcal/model/1"\n\n[[effects]]\ntype = "joint-friction"\njoints = [1, 2, 3, 4, 5, 6]\n'
    (folder / "model.toml").write_text(text, encoding="utf-8")
    command("identify", folder)
    document = command("diagnose", folder)
    missing = [(effect["effect"], effect["where"]["joints"], effect["firm"]) for effect in document["missing"]]
    assert missing == [("stribeck", [2], True), ("torque-ripple", [2], False)]
