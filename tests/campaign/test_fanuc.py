"""The FANUC campaign folder describes the real measurements: the published stiffnesses come out of it.

Data: longton2001-pixel/breakthrough-surge-suppression-in-high-speed-robotic-drilling, data/stiffness_data, MIT. Skipped
where the files are missing. The fit here is plain least squares on first-order columns, on purpose apart from
stiffcal's own identification: it judges manifest and robot file.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import Campaign, load_campaign
from tests.laboratory.campaign_folders import changed

ROOT = Path(__file__).parents[2]
RAW = ROOT.parent / "shared" / "data" / "fanuc-r2000ic"
PUBLISHED = [8.6158e5, 2.8560e6, 1.8483e6, 2.7935e5, 4.1867e5, 2.7772e5]

pytestmark = pytest.mark.skipif(not RAW.is_dir(), reason="the FANUC measurements are not here")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    there = tmp_path / "fanuc-r2000ic"
    shutil.copytree(ROOT / "campaigns" / "fanuc-r2000ic", there, ignore=shutil.ignore_patterns("raw", "store"))
    (there / "raw").mkdir()
    for file in RAW.glob("*.csv"):
        shutil.copy(file, there / "raw" / file.name)
    return there


def stiffness_and_rms(campaign: Campaign, keep: NDArray[np.bool_]) -> tuple[NDArray[np.float64], float]:
    """Fit six compliances to the kept rows: (6,) N·m/rad and the rms of the residual's length, m."""
    chain = campaign.chain
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    files = campaign.manifest.files_of("table")
    tables = {name: np.loadtxt(campaign.folder / file, delimiter=",", skiprows=1) for name, file in files.items()}
    columns, seen = [], []
    for angles, force, moved in zip(
        chain.model_angles(tables["joints"][keep]), tables["wrench"][keep], tables["deflection"][keep], strict=True
    ):
        here, frames = np.eye(4), []
        for fixed, angle in zip(chain.fixed, angles, strict=True):
            turn = np.eye(4)
            turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
            here = here @ fixed @ turn
            frames.append(here)
        point = (here @ chain.flange @ setup.targets[0].transform)[:3, 3]
        jacobian = np.array([np.cross(frame[:3, 2], point - frame[:3, 3]) for frame in frames]).T
        columns.append(jacobian * (jacobian.T @ force))
        seen.append(moved)
    matrix, right = np.concatenate(columns), np.concatenate(seen)
    compliance = np.linalg.lstsq(matrix, right)[0]
    return 1.0 / compliance, float(np.sqrt(np.sum((right - matrix @ compliance) ** 2) / len(seen)))


def test_all_poses(folder: Path) -> None:
    campaign = load_campaign(folder)
    assert campaign.model.balance == "first-order"
    stiffness, rms = stiffness_and_rms(campaign, np.ones(43, dtype=bool))
    assert rms * 1e3 == pytest.approx(0.372, abs=5e-4)
    np.testing.assert_allclose(stiffness / 1e6, [0.861, 2.72, 1.96, 0.271, 0.425, 0.206], rtol=3e-3)


def test_published_stiffness_with_the_five_rows_excluded(folder: Path) -> None:
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    lines = [("# " + line, line) for line in text.split("# [[exclude]]")[1].replace("\n# ", "\n").splitlines() if line]
    manifest = changed(text, ("# [[exclude]]", "[[exclude]]"), *lines)
    (folder / "campaign.toml").write_text(manifest, encoding="utf-8")
    campaign = load_campaign(folder)
    keep = np.ones(43, dtype=bool)
    keep[np.array(campaign.manifest.exclude[0].rows) - 1] = False
    stiffness, _ = stiffness_and_rms(campaign, keep)
    assert [float(f"{value:.4e}") for value in stiffness] == PUBLISHED


def test_the_bundled_folder_names_only_missing_logs(tmp_path: Path) -> None:
    campaign = load_campaign(ROOT / "campaigns" / "fanuc-r2000ic", check_files=False)
    assert campaign.name == "fanuc-r2000ic"
    assert not campaign.chain.masses_known
