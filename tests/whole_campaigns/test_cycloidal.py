"""campaigns/cycloidal-joint: real measurements of three printed reducers, output locked."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.improve import improve_campaign
from stiffcal.documents import document_of
from tests.laboratory.practice_marks import with_practice

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data" / "cycloidal-joint"
# Published means over three output positions: compliance °/(N·m), Coulomb friction N·m.
PUBLISHED = {"base": (0.083, 1.87), "conic": (0.094, 9.57), "split": (0.090, 8.07)}


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """What identify says of each reducer."""
    if not DATA.is_dir():
        pytest.skip("the real measurements (../shared/data) are not here")
    found = {}
    for name in PUBLISHED:
        folder = copied(name, tmp_path_factory.mktemp("cycloidal") / name)
        found[name] = document_of(identify_campaign(folder))
    return found


def joint(document: dict[str, Any]) -> dict[str, Any]:
    (only,) = document["clamped"]["joints"]
    assert isinstance(only, dict)
    return only


def test_play_falls_in_the_published_order(reported: dict[str, dict[str, Any]]) -> None:
    base, conic, split = (joint(reported[name]) for name in PUBLISHED)
    assert np.rad2deg(base["low_slope"]) == pytest.approx(2.0, abs=0.3)
    assert base["low_slope"] > 5.0 * conic["low_slope"] > 10.0 * split["low_slope"]
    # intervals stand apart
    assert base["low_slope_interval"][0] > conic["low_slope_interval"][1]
    assert conic["low_slope_interval"][0] > split["low_slope_interval"][1]


def test_the_raw_width_in_the_play_test_is_what_was_published(reported: dict[str, dict[str, Any]]) -> None:
    """Published 2.501°, 0.481° and 0.121°; in the preloaded ones that is friction over stiffness, not play."""
    widths = []
    for name in PUBLISHED:
        run = next(run for run in reported[name]["clamped"]["runs"] if run["run"] == "play")
        widths.append(float(np.rad2deg(run["reversal_error"])))
    assert widths == pytest.approx([1.91, 0.510, 0.169], rel=0.05)


@pytest.mark.parametrize("name", PUBLISHED)
def test_compliance_and_friction(reported: dict[str, dict[str, Any]], name: str) -> None:
    compliance, friction = PUBLISHED[name]
    # The description: in the fit the friction, which is in the motor's torque, goes into whatever the model holds.
    seen = float(np.rad2deg(1.0 / joint(reported[name])["chord_stiffness"]))
    # base: ours is of the spring alone, 33 % above; with friction in the torque, as published, 6 % (README)
    assert seen == pytest.approx(compliance, rel=0.35 if name == "base" else 0.2)
    assert joint(reported[name])["friction"] == pytest.approx(friction, rel=0.3)
    assert joint(reported[name])["torque_from"] == "motor torque"
    assert any("it includes friction" in words for words in reported[name]["warnings"])


def test_the_torque_that_saturates_is_named(reported: dict[str, dict[str, Any]]) -> None:
    limits = [run["saturated"] for name in PUBLISHED for run in reported[name]["clamped"]["runs"] if run["saturated"]]
    assert len(limits) == 1
    assert "stays at its limit of 25.2" in limits[0]
    assert any("run ramp" in words and "25.2" in words for words in reported["base"]["warnings"])


def test_base_with_friction_in_the_torque_is_as_published(reported: dict[str, dict[str, Any]]) -> None:
    run = next(run for run in reported["base"]["clamped"]["runs"] if run["run"] == "ramp")
    one = joint(reported["base"])
    ends = [one["friction"] + (1.0 + run["law"]["drag"]) * abs(torque) for torque in one["curve"]["torque"]]
    seen = np.rad2deg(run["motion"] - one["low_slope"]) / sum(ends)
    assert seen == pytest.approx(PUBLISHED["base"][0], rel=0.1)


# Friction between motor and spring, and lost motion, in one fit: rms with compliance alone, and with both, mrad.
LADDER = {"base": (15.8, 6.9), "conic": (10.6, 4.2), "split": (12.1, 3.0)}


@pytest.mark.parametrize("name", with_practice(PUBLISHED, "base"))
def test_friction_before_the_spring_is_the_published_coulomb_friction(name: str, tmp_path: Path) -> None:
    if not DATA.is_dir():
        pytest.skip("the real measurements (../shared/data) are not here")
    folder = copied(name, tmp_path / name)
    head = 'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [1]\n'
    (folder / "model.toml").write_text(head, "utf-8")
    alone, with_both = LADDER[name]
    assert rms_mrad(folder) == pytest.approx(alone, rel=0.05)
    friction = (
        '[[effects]]\ntype = "friction-hysteresis"\njoints = [1]\n[effects.parameters]\n'
        '"friction-hysteresis.j1.coulomb" = { value = 5.0 }\n"friction-hysteresis.j1.per_Nm" = { value = 0.0 }\n'
    )
    (folder / "model.toml").write_text(head + friction + '[[effects]]\ntype = "backlash"\njoints = [1]\n', "utf-8")
    assert rms_mrad(folder) < with_both
    values = {entry["name"]: entry["value"] for entry in document_of(identify_campaign(folder))["parameters"]}
    # published are means over three output positions, of which the file here holds the first; of `base`, whose fit
    # leaves twenty times the noise and does not settle, compliance and friction lie up to a third above them (README)
    assert values["friction-hysteresis.j1.coulomb"] == pytest.approx(PUBLISHED[name][1], rel=1.0 / 3.0)


@pytest.mark.practice
@pytest.mark.parametrize(("name", "falls"), [("base", (1.3, 1.4)), ("split", (2.0, 1.6))])
def test_improve_takes_the_friction_before_the_spring_and_goes_on(
    name: str, falls: tuple[float, float], tmp_path: Path
) -> None:
    """Of base both are named together; once friction is in, what is outside the catalogue outweighs the lost motion."""
    if not DATA.is_dir():
        pytest.skip("the real measurements (../shared/data) are not here")
    folder = copied(name, tmp_path / name)
    (folder / "model.toml").write_text(
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [1]\n', "utf-8"
    )
    improved = improve_campaign(folder)
    assert [step.effect for step in improved.steps] == [None, "friction-hysteresis", "backlash"]
    assert improved.unexplained
    errors = [step.heldout_rms.motor_angle or 0.0 for step in improved.steps if step.heldout_rms is not None]
    assert errors[0] > falls[0] * errors[1]
    assert errors[1] > falls[1] * errors[2]
    assert '"friction-hysteresis.j1.coulomb"' in (folder / "model.toml").read_text("utf-8")


def copied(name: str, folder: Path) -> Path:
    """Copy the campaign of a reducer, with its log."""
    shutil.copytree(ROOT / "campaigns" / "cycloidal-joint" / name, folder, ignore=shutil.ignore_patterns("store"))
    (folder / "raw").mkdir(exist_ok=True)
    for file in DATA.glob(f"*_{name}_*.csv"):
        shutil.copyfile(file, folder / "raw" / file.name)
    return folder


def rms_mrad(folder: Path) -> float:
    """Return the fit's rms of the motor's angle."""
    rms = document_of(identify_campaign(folder))["rms"]
    return 1e3 * float(rms["motor_angle"])
