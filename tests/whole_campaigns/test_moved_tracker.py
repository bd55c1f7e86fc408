"""A tracker that is moved between two days: each place has its frame, its own sources, and a registration."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import ingest_campaign, stored_states
from stiffcal.mechanics.rotations import inverse_transform, rotation_from_vector, transform, vector_from_rotation
from tests.laboratory.small_campaign import STIFFNESS
from tests.long_campaigns.campaign import write_head, write_runs

ABSOLUTE = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"
N_RUNS = 12
PLACES = {
    "first": transform(rotation_from_vector(np.array([0.02, -0.03, 1.9])), np.array([3.1, -1.2, 0.4])),
    "second": transform(rotation_from_vector(np.array([-0.01, 0.02, -0.7])), np.array([-2.6, 2.2, 0.5])),
}
"""base_from_tracker on each day, m."""
OUTBOARD = ("j3", "j4", "j5", "j6")
"""Joints whose geometry does not depend on the convention by which the tracker's frame is separated from joint 2's."""


def _moved(rows: list[list[str]], first: int, motion: Floats) -> list[list[str]]:
    """Return rows whose columns from `first`, X, Y and Z in mm, are seen from elsewhere."""
    places = np.array([row[first : first + 3] for row in rows], dtype=np.float64) / 1e3
    places = 1e3 * (places @ motion[:3, :3].T + motion[:3, 3])
    cells = [[f"{value:.4f}" for value in place] for place in places]
    return [[*row[:first], *own, *row[first + 3 :]] for row, own in zip(rows, cells, strict=True)]


def _write(path: Path, rows: list[list[str]]) -> None:
    path.write_text("\n".join(map(",".join, rows)) + "\n", encoding="utf-8")


def _campaign_of_loads(folder: Path, frames: dict[str, str]) -> Path:
    """Write runs of which the second half was measured from the tracker's second place.

    Parameters
    ----------
    frames : day to what its frame states in TOML.
    """
    write_head(folder)
    write_runs(folder, 1, N_RUNS + 1)
    for number in range(1, N_RUNS + 1):
        day = "first" if number <= N_RUNS // 2 else "second"
        log = folder / f"raw/run{number}_tracker.csv"
        header, *rows = csv.reader(log.read_text(encoding="utf-8").splitlines())
        _write(folder / f"raw/run{number}_{day}.csv", [header, *_moved(rows, 1, inverse_transform(PLACES[day]))])
        log.unlink()
    manifest = folder / "campaign.toml"
    head, source = manifest.read_text(encoding="utf-8").split("[sources.tracker]")
    for day, stated in frames.items():
        own = source.replace("_tracker.csv", f"_{day}.csv").replace('frame = "base"', f'frame = "{day}"')
        head += f'[sources.{day}]{own}\n[frames.{day}]\nparent = "base"\n{stated}\n\n'
    manifest.write_text(head, encoding="utf-8")
    return folder


def test_given_places_bring_all_runs_to_the_same_axes(tmp_path: Path) -> None:
    given = {
        day: f"xyz_m = {place[:3, 3].tolist()}\nmatrix = {place[:3, :3].tolist()}" for day, place in PLACES.items()
    }
    write_head(tmp_path / "still")
    write_runs(tmp_path / "still", 1, N_RUNS + 1)
    moved = _campaign_of_loads(tmp_path / "moved", given)
    ingest_campaign(tmp_path / "still")
    ingest_campaign(moved)
    still, states = stored_states(tmp_path / "still"), stored_states(moved)
    assert [run.tracker for run in states.runs] == [0] * 6 + [1] * 6
    rounding = 1e-7  # of the logs, 0.0001 mm
    np.testing.assert_allclose(states.position, still.position, atol=rounding)
    np.testing.assert_allclose(states.base_from_tracker[[0, -1]], list(PLACES.values()), atol=1e-12)


def test_each_place_of_the_tracker_is_registered(tmp_path: Path) -> None:
    folder = _campaign_of_loads(tmp_path / "moved", dict.fromkeys(PLACES, "estimate = true"))
    result = identify_campaign(folder)
    assert result.registration is not None
    for day, place in PLACES.items():
        found = result.registration.frames[day]
        off = inverse_transform(place) @ found.parent_from_frame
        # the sag of the robot under its weight is what the places miss by, and no noise
        assert (np.abs([*off[:3, 3], *vector_from_rotation(off[:3, :3])]) < 5.0 * np.array(found.std)).all()
        assert max(found.std[3:]) < 5e-3
    springs = [parameter for parameter in result.parameters if parameter.effect == "joint-compliance"]
    for parameter, stiffness in zip(springs, STIFFNESS, strict=True):
        assert parameter.value is not None
        assert parameter.std is not None
        assert abs(parameter.value - 1.0 / stiffness) < 3.0 * parameter.std


@pytest.mark.long
def test_places_of_a_moved_tracker_give_the_geometry_and_springs_of_one_that_stood_still(tmp_path: Path) -> None:
    """A second place costs six numbers of 240, and changes the rest by a part of its uncertainty."""
    folders = [shutil.copytree(ABSOLUTE, tmp_path / name) for name in ("still", "moved")]
    header, *rows = csv.reader((ABSOLUTE / "raw/poses.csv").read_text(encoding="utf-8").splitlines())
    half = len(rows) // 2
    first, second = rows[:half], _moved(rows[half:], header.index("X1"), PLACES["second"])
    for day, own in (("first", first), ("second", second)):
        _write(folders[1] / f"raw/{day}.csv", [header, *own])
    (folders[1] / "raw/poses.csv").unlink()
    (folders[1] / "campaign.toml").write_text(_absolute_manifest(), encoding="utf-8")
    still, moved = (identify_campaign(folder) for folder in folders)
    names = {parameter.name for parameter in moved.parameters if parameter.name.startswith("frame.")}
    assert {"frame.first.x", "frame.second.x", "frame.first.rz"} <= names
    assert moved.reduced_chi2 == pytest.approx(1.0, abs=0.25)
    others = {parameter.name: parameter for parameter in moved.parameters}
    compared = [entry for entry in still.parameters if entry.identifiable and entry.name.split(".")[1] in OUTBOARD]
    assert len(compared) > 15
    for parameter in compared:
        value = others[parameter.name].value
        assert value is not None
        assert parameter.value is not None
        assert parameter.std is not None
        assert abs(value - parameter.value) < 2.0 * parameter.std, parameter.name


def _absolute_manifest() -> str:
    """Return campaign.toml with a frame, a table and a run for each place of the tracker."""
    text = (ABSOLUTE / "campaign.toml").read_text(encoding="utf-8")
    head, rest = text.split("[frames.tracker]")
    frame, rest = rest.split("[frames.target1]")
    target, rest = rest.split("[sources.table]")
    source = rest.split("[[runs]]")[0].replace('file = "raw/poses.csv"\n', "")
    source = source.replace('frame = "tracker"', 'frame = "{day}"').replace("sources.table", "sources.{day}")
    run = '[[runs]]\nid = "{day}"\nexperiment = "absolute"\nfiles = {{ {day} = "raw/{day}.csv" }}\n'
    for day in PLACES:
        head += f"[frames.{day}]{frame}"
    head += f"[frames.target1]{target}"
    for day in PLACES:
        head += f"[sources.{day}]" + source.replace("{day}", day)
    return head + "".join(run.format(day=day) for day in PLACES)
