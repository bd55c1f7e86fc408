"""`init --from`: what is proposed for the uncertainty of places that state none, and what is known without it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from stiffcal.propose.from_table import draft_campaign

HEADER = "A1,A2,A3,A4,A5,A6,X,Y,Z"
SEVERAL = "A1,A2,A3,A4,A5,A6,X1,Y1,Z1,X2,Y2,Z2"


def drafted(folder: Path, header: str, n_repeated: int, stated: str = "", turned: float = 0.0) -> str:
    """Return the manifest drafted for 40 poses in degrees and mm, so many of them again, ``turned`` by degrees."""
    rng = np.random.default_rng(7)
    joints = rng.uniform(-60.0, 60.0, (40, 6))
    joints = np.concatenate([joints, joints[:n_repeated] + turned])
    n_places = len(header.split(",")) - 6 - len(stated.split(",")) + (not stated)
    places = rng.uniform(500.0, 2000.0, (len(joints), n_places))
    sigma = np.full((len(joints), len(header.split(",")) - 6 - n_places), 0.02)
    rows = [",".join(f"{value:.5f}" for value in row) for row in np.hstack([joints, places, sigma])]
    path = folder / "poses.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return draft_campaign([path], robot="kr125").manifest


@pytest.mark.parametrize(
    ("n_repeated", "turned", "words"),
    [
        (0, 0.0, "no row repeats another"),
        (4, 0.03, "only 4 pairs of rows that repeat each other (joints within 0.1°): the noise is poorly known"),
        (12, 0.03, "the noise is estimated from 12 pairs of rows that repeat each other"),
        (12, 0.2, "no row repeats another"),
    ],
)
def test_what_the_noise_would_be_estimated_from(tmp_path: Path, n_repeated: int, turned: float, words: str) -> None:
    manifest = drafted(tmp_path, HEADER, n_repeated, turned=turned)
    assert words in manifest
    assert "# add to the braces of pose: sigma = { position = 0.015, per_metre = 0.006 }" in manifest
    assert "in mm and mm per metre" in manifest


def test_the_line_of_a_target_is_valid_without_its_comment_mark(tmp_path: Path) -> None:
    manifest = drafted(tmp_path, SEVERAL, 0)
    assert manifest.count("no row repeats another") == 1
    read = tomllib.loads(manifest.replace("# sigma = ", "sigma = "))
    poses = read["sources"]["table"]["poses"]
    assert [poses[name]["sigma"] for name in sorted(poses)] == [{"position": 0.015, "per_metre": 0.006}] * 2


def test_columns_that_state_it_need_no_such_line(tmp_path: Path) -> None:
    manifest = drafted(tmp_path, f"{HEADER},sigma_x,sigma_y,sigma_z", 0, "sigma_x,sigma_y,sigma_z")
    assert 'sigma = { position = ["sigma_x", "sigma_y", "sigma_z"] }' in manifest
    assert "per_metre" not in manifest
