"""Absolute places of four points on one plate whose places to each other are known: the plate's frame is estimated."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import ingest_campaign, stored_states
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign

PRACTICE = Path(__file__).resolve().parents[2] / "campaigns" / "absolute" / "02"
POINTS = ((0.08, 0.0, 0.12), (-0.07, 0.05, 0.10), (0.0, -0.09, 0.15), (0.05, 0.08, 0.05))
MARKERS = ", ".join(
    f'm{k} = {{ columns = ["X{k}", "Y{k}", "Z{k}"], at_m = {list(place)} }}' for k, place in enumerate(POINTS, start=1)
)
MANIFEST = f"""
schema = "stiffcal/campaign/1"
robot = "robot.toml"
[frames.tracker]
parent = "base"
estimate = true
[frames.plate]
parent = "flange"
estimate = true
[frames.payload]
parent = "flange"
xyz_m = [0.02, -0.01, 0.11]
[sources.table]
file = "raw/poses.csv"
sampling = "states"
time = {{ column = "t", unit = "s" }}
joints = {{ position = "A1..A6", units = {{ position = "deg" }} }}
dead_weight = {{ mass_column = "payload_kg", point = "payload" }}
[sources.table.poses.plate]
frame = "tracker"
units = {{ position = "mm" }}
sigma = {{ position = 0.02 }}
markers = {{ {MARKERS} }}
[[runs]]
id = "poses"
experiment = "absolute"
"""
STIFFNESS = (2.0e6, 2.0e6, 1.6e6, 3.5e5, 2.5e5, 1.7e5)
MODEL = """
schema = "stiffcal/model/1"
[[effects]]
type = "joint-compliance"
joints = "all"
[effects.parameters]
{}
[[effects]]
type = "link-geometry"
joints = "all"
""".format("\n".join(f'"joint-compliance.j{k}.c" = {{ value = {1 / s} }}' for k, s in enumerate(STIFFNESS, start=1)))
SIMULATE = """
schema = "stiffcal/simulate/1"
seed = 4
[absolute]
poses = 80
payloads_kg = [0.0, 80.0, 150.0]
point = "payload"
[robot]
geometry_error_m = 2.5e-4
geometry_error_rad = 5e-4
[frames.tracker]
xyz_m = [3.4, -1.1, 0.35]
rpy_deg = [0.3, -0.5, 120.0]
[frames.plate]
xyz_m = [0.004, -0.003, 0.002]
rpy_deg = [1.0, -0.6, 0.8]
[sensors.table]
hidden = 0.1
[sensors.table.white]
translation_m = 2e-5
[[runs]]
id = "poses"
joints_deg = [0, -70, 20, 0, 0, 0]
"""


def test_springs_are_found_with_the_noise_of_each_point(tmp_path: Path) -> None:
    source = tmp_path / "source"
    source.mkdir()
    shutil.copy(PRACTICE / "robot.toml", source)
    for name, text in (("campaign.toml", MANIFEST), ("model.toml", MODEL), ("simulate.toml", SIMULATE)):
        (source / name).write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    truth = simulate_campaign(load_campaign(source, check_files=False), load_settings(source), out)["truth"][
        "parameters"
    ]
    result = identify_campaign(out)
    assert result.noise_source == "manifest"
    # six rows of 80 poses less 38 numbers: four standard deviations of χ²
    assert result.reduced_chi2 == pytest.approx(1.0, abs=0.27)
    names = [f"joint-compliance.j{k}.c" for k in (2, 3, 4, 5, 6)]
    chosen = [result.free_parameters.index(name) for name in names]
    away = np.array([result.parameter(name).value or np.nan for name in names]) - [truth[name] for name in names]
    covariance = np.array(result.covariance, dtype=float)[np.ix_(chosen, chosen)]
    assert float(away @ np.linalg.solve(covariance, away)) < 20.5  # 99.9 % of χ² with 5


def test_each_body_has_the_noise_of_its_own_points(tmp_path: Path) -> None:
    """Three points close together give the turn of their body less precisely than four that are far apart."""
    places = [tuple(0.2 * value for value in place) for place in POINTS[:3]]
    markers = ", ".join(
        f'k{k} = {{ columns = ["U{k}", "V{k}", "W{k}"], at_m = {list(place)} }}' for k, place in enumerate(places, 1)
    )
    small = (
        '[sources.table.poses.small]\nframe = "tracker"\nunits = { position = "mm" }\n'
        f"sigma = {{ position = 0.02 }}\nmarkers = {{ {markers} }}\n[[runs]]"
    )
    manifest = MANIFEST.replace("[[runs]]", small)
    frame = '[frames.small]\nparent = "flange"\nestimate = true\n[frames.payload]'
    source = tmp_path / "source"
    source.mkdir()
    shutil.copy(PRACTICE / "robot.toml", source)
    texts = {
        "campaign.toml": manifest.replace("[frames.payload]", frame),
        "model.toml": MODEL,
        "simulate.toml": SIMULATE.replace("poses = 80", "poses = 12")
        + "[frames.small]\nxyz_m = [0.0, 0.0, 0.0]\nrpy_deg = [0.0, 0.0, 0.0]\n",
    }
    for name, text in texts.items():
        (source / name).write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    simulate_campaign(load_campaign(source, check_files=False), load_settings(source), out)
    ingest_campaign(out)
    states = stored_states(out)
    for b, name in enumerate(states.setup.target_names):
        points = np.array(POINTS if name == "plate" else places)
        away = points - points.mean(axis=0)
        turn = np.linalg.inv(np.sum(away**2) * np.eye(3) - away.T @ away)
        expected = [2e-5 / np.sqrt(len(points)), 2e-5 * np.sqrt(np.trace(turn) / 3.0)]
        np.testing.assert_allclose(states.sigma[:, b], np.broadcast_to(np.repeat(expected, 3), (12, 6)), rtol=1e-9)
