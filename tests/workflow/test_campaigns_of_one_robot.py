"""Absolute campaigns of one robot, measured by a tracker that stands elsewhere: compared, and judged by each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.workflow.compare import compare_campaigns
from stiffcal.workflow.validate import validate_campaign
from tests.laboratory.absolute_and_loads import N_PLACES, TRACKER_M, write_campaign
from tests.laboratory.robots import six_axis_joints


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return a campaign of places and loads, and one of places alone after the tracker was moved."""
    first, second = tmp_path_factory.mktemp("robot") / "both", tmp_path_factory.mktemp("robot") / "places"
    truth = write_campaign(first, 6)
    write_campaign(second, 6)
    manifest = (second / "campaign.toml").read_text(encoding="utf-8")
    start, end = manifest.index("[sources.loads]"), manifest.index("[[runs]]")
    runs = manifest[end : manifest.index('[[runs]]\nid = "pull1"')]
    (second / "campaign.toml").write_text(manifest[:start] + runs, encoding="utf-8")
    rng = np.random.default_rng(9)
    joints = six_axis_joints(rng, N_PLACES)
    places = truth.places(load_campaign(first, check_files=False).chain, joints, np.zeros((N_PLACES, 6)))
    places = places @ rotation_from_vector(np.array([0.3, -0.1, 1.2])).T + [0.4, 2.0, -0.7]
    places = places + TRACKER_M * rng.normal(size=places.shape)
    rows = np.column_stack([20.0 * np.arange(N_PLACES), np.degrees(joints), 1e3 * places])
    lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
    text = "\n".join(["t,A1,A2,A3,A4,A5,A6,X,Y,Z", *lines]) + "\n"
    (second / "raw" / "places.csv").write_text(text, encoding="utf-8")
    return first, second


def test_nothing_has_changed_but_where_the_tracker_stands(campaigns: tuple[Path, Path]) -> None:
    compared = compare_campaigns(*campaigns)
    assert compared.changed == []
    assert (compared.p_value_all or 0.0) > 1e-3
    names = [parameter.name for parameter in compared.parameters]
    # where registration puts the tracker decides of the links next to it
    assert names == [f"joint-compliance.j{joint}.c" for joint in range(1, 7)]
    assert compared.only_before == compared.only_after == []
    assert len(compared.warnings) == 1


def test_the_model_of_one_holds_in_the_other(campaigns: tuple[Path, Path]) -> None:
    judged = validate_campaign(campaigns[1], model=campaigns[0])
    # 35 µm are the noise of sixty places; the model and the frames are known to some 15 µm
    assert judged.rms.translation == pytest.approx(np.hypot(np.sqrt(3.0) * TRACKER_M, 15e-6), rel=0.2)
    back = validate_campaign(campaigns[0], model=campaigns[1])
    errors = {part.label: part.rms.translation or np.nan for part in back.by_experiment or []}
    assert errors["absolute"] == pytest.approx(np.hypot(np.sqrt(3.0) * TRACKER_M, 15e-6), rel=0.25)
