"""A Stäubli TX40 in quick motion: published friction against ours, weight and inertia modelled.

Data: repository thanhndv212/figaroh-examples, Apache-2.0. Published: viscous and Coulomb terms of a full rigid-body
identification.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.whole_campaigns.conftest import Command

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data" / "staubli-tx40-friction"
VISCOUS = (8.05, 5.53, 1.97, 1.11, 1.86, 0.65)
COULOMB = (7.14, 8.26, 6.34, 2.48, 3.03, 0.282)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not DATA.is_dir():
        pytest.skip(f"the measurements are not here: {DATA}")
    folder = tmp_path_factory.mktemp("staubli") / "tx40"
    shutil.copytree(ROOT / "campaigns" / "staubli-tx40-friction", folder, ignore=shutil.ignore_patterns("raw", "store"))
    (folder / "raw").mkdir()
    for file in DATA.glob("*.csv"):
        shutil.copyfile(file, folder / "raw" / file.name)
    return folder


def values(document: dict[str, Any], symbol: str) -> list[float]:
    return [p["value"] for p in document["parameters"] if p["name"].endswith(f".{symbol}")]


def test_published_friction(folder: Path, command: Command) -> None:
    document = command("identify", folder)
    coulomb, viscous = values(document, "coulomb"), values(document, "viscous")
    assert coulomb[:4] == pytest.approx(COULOMB[:4], rel=0.12)
    assert viscous[:4] == pytest.approx(VISCOUS[:4], rel=0.07)
    # the wrist: motor 6 turns with joints 5 and 6, joint 6's own bearing apart
    (bearing,) = document["friction"]["bearings"]
    assert bearing["joint"] == 6
    assert viscous[4] + viscous[5] == pytest.approx(VISCOUS[4], rel=0.1)
    assert viscous[5] + bearing["viscous"] == pytest.approx(VISCOUS[5], rel=0.1)
    assert coulomb[4] == pytest.approx(COULOMB[4], rel=0.12)
    assert abs(bearing["coulomb"] - COULOMB[5]) < 2.0 * bearing["coulomb_std"] < 0.5
    assert document["rms"]["torque"] == pytest.approx(1.02, abs=0.02)
    assert any("several joints move at the same time" in words for words in command("ingest", folder)["warnings"])


def test_seconds_that_the_fit_has_not_seen(folder: Path, command: Command) -> None:
    document = command("validate", folder)
    assert document["rms"]["torque"] < 1.4
    assert document["zero_model"]["torque"] > 16.0
    assert [one["label"] for one in document["by_joint"]] == ["J1", "J2", "J3", "J4", "J5", "J6"]
    assert document["noise"] is None


@pytest.mark.practice
def test_friction_grows_less_than_the_speed_and_something_of_no_catalogue_is_left(
    folder: Path, command: Command
) -> None:
    """Slow panels lie below the law; no noise is known, and nothing is certain next to what is left."""
    document = command("diagnose", folder)
    named = {(effect["effect"], *effect["where"]["joints"]) for effect in document["missing"]}
    assert {("viscous-power", joint) for joint in (1, 2, 3, 4)} <= named
    assert {effect for effect, _ in named} == {"viscous-power"}
    assert not any(effect["firm"] for effect in document["missing"])
    assert document["unexplained"]
    assert document["adequate"] is None
    assert document["p_unknown"] > 0.99
    assert document["heldout_rms_with_missing"]["torque"] < 0.9 * document["rms"]["torque"]
    assert any("resampling them as blocks" in words for words in document["warnings"])
