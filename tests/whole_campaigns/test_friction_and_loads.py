"""Load states and friction runs in one campaign: both are reported, neither changes the other."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.laboratory.friction_campaigns import rehearsed
from tests.laboratory.small_campaign import MODEL, POSES_DEG, STIFFNESS, write_small_campaign
from tests.whole_campaigns.conftest import Command

FRICTION = """
[sources.controller]
time = { column = "t", unit = "s" }
[sources.controller.joints]
position = "A1..A6"
current = "I1..I6"
torque_constant = [120, 120, 110, 60, 60, 50]
units = { position = "deg", current = "A" }
"""
EFFECT = '\n[[effects]]\ntype = "joint-friction"\njoints = [1, 2]\n'


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Path:
    here = tmp_path_factory.mktemp("both")
    slow = {"friction.speeds_rad_s": [0.03, 0.15, 0.6, 1.2], "friction.longest_s": 1.5}
    made = rehearsed(here / "friction", simulate=slow)
    folder = write_small_campaign(here / "small")
    runs = "".join(f'\n[[runs]]\nid = "pose{k + 1}"\n' for k in range(len(POSES_DEG)))
    for joint in (1, 2):
        shutil.copyfile(made / "raw" / f"joint{joint}.csv", folder / "raw" / f"joint{joint}.csv")
        runs += f'\n[[runs]]\nid = "joint{joint}"\nexperiment = "friction"\n'
        runs += f'files = {{ controller = "raw/joint{joint}.csv" }}\n'
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text() + FRICTION + runs, encoding="utf-8")
    (folder / "model.toml").write_text(MODEL + EFFECT, encoding="utf-8")
    return folder


def test_both_are_reported(both: Path, command: Command) -> None:
    document = command("identify", both)
    found = {p["name"]: p for p in document["parameters"]}
    for joint, stiffness in enumerate(STIFFNESS[:3], start=1):
        assert found[f"joint-compliance.j{joint}.c"]["stiffness"] == pytest.approx(stiffness, rel=0.1)
    assert found["joint-friction.j1.viscous"]["value"] == pytest.approx(90.0, rel=0.03)
    assert found["joint-friction.j2.coulomb"]["value"] == pytest.approx(80.0, rel=0.05)
    assert [effect["type"] for effect in document["model"]["effects"]] == ["joint-compliance", "joint-friction"]
    assert len(document["free_parameters"]) == len(document["covariance"])
    assert document["n_states"] > 90
    assert document["rms"]["translation"] < 3e-5
    # means over bins of a pass, against the noise of such a mean
    assert document["rms"]["torque"] < 1.3 * document["noise"]["torque"]
    judged = command("validate", both)
    assert judged["rms"]["translation"] < 5e-5
    # four speeds: with one left out a line is drawn through the others
    assert judged["rms"]["torque"] < 2.0 * judged["noise"]["torque"]
    assert "friction" in judged["scheme"]
    assert {"pose1", "joint1"} <= {one["label"] for one in judged["by_run"]}


def test_springs_are_those_without_friction_runs(both: Path, command: Command, tmp_path: Path) -> None:
    alone = command("identify", write_small_campaign(tmp_path / "alone"))
    together = {p["name"]: p["value"] for p in command("identify", both)["parameters"]}
    for one in alone["parameters"]:
        assert together[one["name"]] == pytest.approx(one["value"], rel=1e-9)


def test_a_model_without_friction_says_that_runs_go_unused(both: Path, command: Command, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(both, tmp_path / "copy", ignore=shutil.ignore_patterns("store")))
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    document = command("identify", folder)
    assert any("friction runs are not used" in words for words in document["warnings"])
    assert not any(p["effect"] == "joint-friction" for p in document["parameters"])


def test_runs_held_out_judge_and_do_not_fit(both: Path, command: Command, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(both, tmp_path / "copy", ignore=shutil.ignore_patterns("store")))
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text().replace('id = "joint2"\n', 'id = "joint2"\nholdout = true\n'))
    document = command("identify", folder)
    found = {p["name"]: p for p in document["parameters"]}
    assert found["joint-friction.j1.coulomb"]["value"] is not None
    assert found["joint-friction.j2.coulomb"]["value"] is None
    assert any("held-out" in gap["reason"] for gap in document["not_identifiable"])
