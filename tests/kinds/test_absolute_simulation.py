"""Simulated runs of absolute places: random poses of a robot with drawn geometry errors."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.errors import InputError
from stiffcal.mechanics.rotations import rotation_from_rpy
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign

PRACTICE = Path(__file__).resolve().parents[2] / "campaigns" / "absolute" / "02"
STIFFNESS = (2.0e6, 2.0e6, 1.6e6, 3.5e5, 2.5e5, 1.7e5)
TRACKER, TURN_DEG, TARGET = (3.4, -1.1, 0.35), (0.3, -0.5, 120.0), (0.083, 0.004, 0.118)
SIMULATE = f"""
schema = "stiffcal/simulate/1"
seed = 3

[absolute]
poses = 120
payloads_kg = [0.0, 80.0, 150.0]
point = "payload"

[robot]
geometry_error_m = 2.5e-4
geometry_error_rad = 5e-4
hidden = ["joint-eccentricity"]

[frames.tracker]
xyz_m = {list(TRACKER)}
rpy_deg = {list(TURN_DEG)}

[frames.target1]
xyz_m = {list(TARGET)}

[sensors.table.white]
translation_m = 2e-5

[[runs]]
id = "poses"
joints_deg = [0, -70, 20, 0, 0, 0]
"""


def model_text(compliance: float = 1.0) -> str:
    springs = "\n".join(
        f'"joint-compliance.j{k + 1}.c" = {{ value = {compliance / stiffness} }}'
        for k, stiffness in enumerate(STIFFNESS)
    )
    return f"""
schema = "stiffcal/model/1"
[[effects]]
type = "joint-compliance"
joints = "all"
[effects.parameters]
{springs}

[[effects]]
type = "link-geometry"
joints = "all"

[[effects]]
type = "joint-eccentricity"
joints = [3]
[effects.parameters]
"joint-eccentricity.j3.order" = {{ value = 1 }}
"joint-eccentricity.j3.a" = {{ value = {compliance * 2e-4} }}
"joint-eccentricity.j3.b" = {{ value = {compliance * -2e-4} }}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a campaign to simulate: the practice robot with values of our own."""
    source = tmp_path / "source"
    source.mkdir()
    for name in ("campaign.toml", "robot.toml"):
        shutil.copy(PRACTICE / name, source / name)
    (source / "model.toml").write_text(model_text())
    (source / "simulate.toml").write_text(SIMULATE)
    return source


def played(folder: Path, out: Path, seed: int | None = None) -> Path:
    simulate_campaign(load_campaign(folder, check_files=False), load_settings(folder), out, seed=seed)
    return out


def rows_of(folder: Path) -> dict[str, np.ndarray]:
    with (folder / "raw" / "poses.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def rigid_place(angles_deg: np.ndarray) -> np.ndarray:
    """Return (3,) mm of the target in the tracker's frame on the nominal robot, Craig's convention written out."""
    lengths = [(0.0, 0.0, 0.675, 0.0), (0.35, -90.0, 0.0, 0.0), (1.15, 0.0, 0.0, -90.0), (-0.041, -90.0, 1.0, 0.0),
               (0.0, 90.0, 0.0, 0.0), (0.0, -90.0, 0.0, 0.0)]  # fmt: skip
    frame = np.eye(4)
    for (a, alpha, d, theta), angle in zip(lengths, angles_deg, strict=True):
        ca, sa = np.cos(np.radians(alpha)), np.sin(np.radians(alpha))
        ct, st = np.cos(np.radians(angle + theta)), np.sin(np.radians(angle + theta))
        frame = frame @ np.array(
            [[ct, -st, 0, a], [st * ca, ct * ca, -sa, -d * sa], [st * sa, ct * sa, ca, d * ca], [0, 0, 0, 1]]
        )
    place = frame @ np.array([TARGET[0], TARGET[1], TARGET[2] + 0.24, 1.0])
    axes = rotation_from_rpy(np.deg2rad(np.array(TURN_DEG)))
    return np.asarray(1e3 * axes.T @ (place[:3] - np.array(TRACKER)))


def test_a_rigid_exact_robot_stands_where_its_chain_puts_it(folder: Path, tmp_path: Path) -> None:
    zeros = "".join(
        f'"link-geometry.j{k}.{s}" = {{ value = 0.0 }}\n' for k in range(1, 7) for s in ("x", "y", "rx", "ry")
    )
    geometry = f'type = "link-geometry"\njoints = "all"\n[effects.parameters]\n{zeros}'
    text = model_text(1e-9).replace('type = "link-geometry"\njoints = "all"\n', geometry)
    (folder / "model.toml").write_text(text)
    (folder / "simulate.toml").write_text(SIMULATE.replace("translation_m = 2e-5", "translation_m = 0.0"))
    rows = rows_of(played(folder, tmp_path / "out"))
    angles = np.stack([rows[f"A{k}"] for k in range(1, 7)], axis=1)
    measured = np.stack([rows[name] for name in ("X1", "Y1", "Z1")], axis=1)
    # the log has 1e-5 mm and angles of 1e-7 degrees: 5 nm on 3 m
    np.testing.assert_allclose(measured, [rigid_place(row) for row in angles], atol=3e-5)


def test_poses_and_payloads_are_drawn_as_asked(folder: Path, tmp_path: Path) -> None:
    rows = rows_of(played(folder, tmp_path / "out"))
    assert set(rows["payload_kg"]) == {0.0, 80.0, 150.0}
    assert len(rows["t"]) == 120
    np.testing.assert_allclose(np.diff(rows["t"]), 20.0, atol=1e-4)
    # joint 2: −70 ± 60 degrees, cut off by its limits
    assert rows["A2"].min() >= -114.59
    assert rows["A2"].max() <= -28.65
    assert np.ptp(rows["A1"]) > 100.0


def test_the_seed_draws_the_geometry(folder: Path, tmp_path: Path) -> None:
    texts, drawn = [], []
    for name, seed in (("one", 5), ("same", 5), ("other", 6)):
        out = played(folder, tmp_path / name, seed)
        texts.append((out / "raw" / "poses.csv").read_bytes())
        drawn.append(json.loads((out / "truth.json").read_text())["parameters"])
    assert texts[0] == texts[1] != texts[2]
    assert drawn[0] == drawn[1]
    tilts = [values[f"link-geometry.j{k}.rx"] for values in (drawn[0], drawn[2]) for k in range(1, 7)]
    assert len(set(tilts)) == 12
    # 12 values of a standard deviation of 0.5 mrad: 99.9 % of χ² with 12 lie between these
    assert 1.9 < float(np.sum(np.square(tilts))) / 5e-4**2 < 32.9 + 2.0
    assert "eccentricity" not in (tmp_path / "one" / "model.toml").read_text()


def test_geometry_without_a_value_needs_a_size(folder: Path, tmp_path: Path) -> None:
    (folder / "simulate.toml").write_text(SIMULATE.replace("geometry_error_m = 2.5e-4", ""))
    with pytest.raises(InputError) as caught:
        played(folder, tmp_path / "out")
    assert {fault.place.rsplit(".", 1)[1] for fault in caught.value.faults} == {"x", "y"}


def test_the_true_model_leaves_the_noise_and_has_the_true_springs(folder: Path, tmp_path: Path) -> None:
    settings = load_settings(folder)
    shown = settings.model_copy(update={"robot": settings.robot.model_copy(update={"hidden": []})})
    out = tmp_path / "out"
    truth = simulate_campaign(load_campaign(folder, check_files=False), shown, out)["truth"]["parameters"]
    result = identify_campaign(out)
    assert result.reduced_chi2 == pytest.approx(1.0, abs=0.25)  # 4 standard deviations of χ² with 325
    names = [f"joint-compliance.j{k}.c" for k in (2, 3, 4, 5)]
    chosen = [result.free_parameters.index(name) for name in names]
    away = np.array([result.parameter(name).value or np.nan for name in names]) - [truth[name] for name in names]
    covariance = np.array(result.covariance, dtype=float)[np.ix_(chosen, chosen)]
    assert float(away @ np.linalg.solve(covariance, away)) < 18.5  # 99.9 % of χ² with 4
