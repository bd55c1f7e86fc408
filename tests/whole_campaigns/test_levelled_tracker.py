"""`[frames.tracker] level = true`: the tracker's z axis is known, and poses determine the tilt of joint 1's axis."""

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
from stiffcal.reduction.registration.levelled import levelled

ABSOLUTE = Path(__file__).parents[2] / "campaigns" / "absolute"


@pytest.fixture
def levelled_campaign(tmp_path: Path) -> Path:
    """Return campaign 01 as a tracker would have measured it whose z axis points up."""
    folder = tmp_path / "levelled"
    shutil.copytree(ABSOLUTE / "01", folder)
    truth = next(entry for entry in _truths() if entry["folder"] == "01")
    base_from_tracker = np.array(truth["tracker_in_base"])
    upright = levelled(base_from_tracker, np.array([0.0, 0.0, -9.81]))
    turn = upright[:3, :3].T @ base_from_tracker[:3, :3]
    path = folder / "raw" / "poses.csv"
    header, *rows = csv.reader(path.read_text(encoding="utf-8").splitlines())
    first = header.index("X1")
    for row in rows:
        row[first : first + 3] = [f"{value:.6f}" for value in turn @ np.array(row[first : first + 3], dtype=float)]
    path.write_text("\n".join(map(",".join, [header, *rows])) + "\n", encoding="utf-8")
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(text.replace("estimate = true", "estimate = true\nlevel = true", 1), encoding="utf-8")
    return folder


def _truths() -> list[dict[str, object]]:
    document = json.loads((ABSOLUTE / "truth.json").read_text(encoding="utf-8"))
    return list(document.values()) if isinstance(document, dict) else document


def test_the_tilt_of_the_first_axis_is_identified(levelled_campaign: Path) -> None:
    result = identify_campaign(levelled_campaign)
    found = {parameter.name: parameter for parameter in result.parameters}
    assert {"frame.tracker.x", "frame.tracker.rz"} <= found.keys()
    assert not {"frame.tracker.rx", "frame.tracker.ry"} & found.keys()
    truth = next(entry for entry in _truths() if entry["folder"] == "01")
    rows = truth["geometry_errors_a_alpha_d_theta"]
    assert isinstance(rows, list)
    for symbol, true in (("rx", rows[0][1]), ("ry", 0.0)):
        tilt = found[f"link-geometry.j1.{symbol}"]
        assert tilt.value is not None
        assert tilt.std is not None
        assert abs(tilt.value - true) < 4.0 * tilt.std < 4e-5
    assert result.reduced_chi2 == pytest.approx(1.0, abs=0.2)


def test_level_requires_an_instrument_in_the_base_that_is_estimated(levelled_campaign: Path) -> None:
    manifest = levelled_campaign / "campaign.toml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(text.replace("estimate = true\nlevel = true", "level = true", 1), encoding="utf-8")
    with pytest.raises(InputError, match="level applies to the frame of an instrument that stands in base"):
        load_campaign(levelled_campaign)


def test_a_robot_on_a_wall_is_refused() -> None:
    with pytest.raises(InputError, match="level requires a base that stands or hangs upright"):
        levelled(np.eye(4), np.array([9.81, 0.0, 0.0]))


def test_of_a_hanging_robot_up_is_down_in_its_base() -> None:
    upright = levelled(np.eye(4), np.array([0.0, 0.0, 9.81]))
    np.testing.assert_array_equal(upright[:3, 2], [0.0, 0.0, -1.0])
    np.testing.assert_allclose(upright[:3, :3].T @ upright[:3, :3], np.eye(3), atol=1e-15)
    assert np.linalg.det(upright[:3, :3]) == pytest.approx(1.0)
