"""Meshes of the URDF on the page: packed in few bytes, and done without where one is broken."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.view import view_campaign
from stiffcal.live.choice import ModelChoice
from stiffcal.live.models import LiveModels
from stiffcal.meshes.client import read_bodies
from stiffcal.stages.steps import RunContext
from stiffcal.view.gathering.bodies import MOST_TRIANGLES, view_bodies
from stiffcal.view.packing import unpacked
from tests.laboratory.mesh_robot import bodies_of
from tests.laboratory.small_campaign import write_small_campaign
from tests.laboratory.view_of_meshes import copy_with_meshes


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_with_meshes(tmp_path_factory.mktemp("meshes") / "arm")


def packed(folder: Path) -> tuple[dict[str, Any], dict[int, Any], int]:
    """Write a campaign's page; return what is packed into it, and its bytes."""
    view_campaign(folder)
    text = (folder / "view.html").read_text("utf-8")
    found = re.search(r'<script type="text/plain" id="data">([^<]*)</script>', text)
    assert found is not None
    return *unpacked(found[1]), len(text)


def test_the_page_holds_the_links_in_few_bytes(folder: Path, tmp_path: Path) -> None:
    document, arrays, size = packed(folder)
    assert [body["body"] for body in document["bodies"]] == [0, 1, 2, 3, 4, 5, 6]
    triangles = [arrays[body["triangles"]["$"]["at"]] for body in document["bodies"]]
    assert 0.5 * MOST_TRIANGLES < sum(map(len, triangles)) <= MOST_TRIANGLES
    for body, written in zip(document["bodies"], bodies_of(load_campaign(folder).chain), strict=True):
        points = arrays[body["points"]["$"]["at"]]
        ends, expected = (np.stack([one.min(axis=0), one.max(axis=0)]) for one in (points, written.reshape(-1, 3)))
        assert np.abs(ends - expected).max() < 0.005  # a cell of the grid is larger
    without = tmp_path / "without"
    shutil.copytree(folder, without, ignore=shutil.ignore_patterns("arm_description"))
    plain, _, plain_size = packed(without)
    assert plain["bodies"] == []
    assert plain["meshes_fault"] == ""
    assert size - plain_size < 70_000


def test_a_broken_mesh_is_one_line_and_the_robot_is_drawn_without(folder: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken"
    shutil.copytree(folder, broken)
    part = broken / "arm_description" / "meshes" / "part3.STL"
    part.write_bytes(part.read_bytes()[:-7])
    document, _, _ = packed(broken)
    assert document["bodies"] == []
    assert document["meshes_fault"].startswith("arm_description/meshes/part3.STL: ")
    (warning,) = view_campaign(broken).warnings
    assert "[file-damaged]" in warning
    assert "\n" not in warning
    assert view_campaign(folder).warnings == []


def test_a_robot_without_meshes_asks_no_child_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("asked")

    monkeypatch.setattr("stiffcal.view.gathering.bodies.read_bodies", refuse)
    assert view_bodies(load_campaign(write_small_campaign(tmp_path / "small", poses=2))) == ([], "")


def test_meshes_are_read_once_for_all_models_that_are_tried(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[int] = []

    def counted(*given: Any) -> Any:
        read.append(1)
        return read_bodies(*given)

    monkeypatch.setattr("stiffcal.view.gathering.bodies.read_bodies", counted)
    models = LiveModels(Path(shutil.copytree(folder, tmp_path / "arm")), RunContext())
    first = models.content(ModelChoice())
    second = models.content(ModelChoice(removed=["joint-compliance j6"]))
    assert len(read) == 1
    assert second.bodies is first.bodies
    assert len(first.bodies) == 7
