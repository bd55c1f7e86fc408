"""The FANUC R-2000iC measurements: published numbers, and a plain six-compliance fit of all poses.

Data: repository longton2001-pixel/breakthrough-surge-suppression-in-high-speed-robotic-drilling, MIT licence.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pypdf import PdfReader

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.mistakes.displacements.table import TablePlaces, check_other_readings
from stiffcal.mistakes.displacements.unit_slips import angles_like_radians, check_displacement_unit
from stiffcal.mistakes.stated_units import stated_units
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.whole_campaigns.conftest import Command

PUBLISHED = (8.6158e5, 2.8560e6, 1.8483e6, 2.7935e5, 4.1867e5, 2.7772e5)  # N·m/rad, 38 of the 43 poses
PLAIN_FIT = (0.861e6, 2.72e6, 1.96e6, 0.271e6, 0.425e6, 0.206e6)  # all 43 poses
PLAIN_PERCENT = (4, 16, 12, 14, 17, 48)  # standard errors
EXCLUDE = """
[[exclude]]
source = "table"
rows = [1, 2, 11, 12, 13]
why = "left out by the authors"
"""


def test_all_poses(fanuc: Path, command: Command) -> None:
    document = command("identify", fanuc)
    found = [one["stiffness"] for one in document["parameters"]]
    assert np.allclose(found, PLAIN_FIT, rtol=0.003)
    percent = [100 * one["stiffness_std"] / one["stiffness"] for one in document["parameters"]]
    assert [round(value) for value in percent] == list(PLAIN_PERCENT)
    assert document["rms"]["translation"] == pytest.approx(0.372e-3, abs=0.5e-6)
    assert any("j6" in warning and "poorly determined" in warning for warning in document["warnings"])
    validation = command("validate", fanuc)
    assert validation["scheme"] == "leave-one-pose-out"
    assert validation["rms"]["translation"] == pytest.approx(0.405e-3, abs=0.5e-6)
    assert validation["zero_model"]["translation"] == pytest.approx(1.725e-3, abs=0.5e-6)


def test_the_report_of_single_states(fanuc: Path, command: Command) -> None:
    """43 poses with one state each, whose noise nothing tells: no curve against force, and the numbers all the same."""
    command("report", fanuc)
    reader = PdfReader(fanuc / "report.pdf")
    text = " ".join(" ".join(page.extract_text() for page in reader.pages).split())
    numbers = ("0.372 mm", "0.405 mm", "1.73 mm", "(8.61 ± 0.61)·10⁵", "2.72 (2.06 … 4.01)·10⁶")
    for number in (*numbers, "poorly determined", "noise cannot be judged"):
        assert number in text, number
    assert "no curve over the force can be drawn" in text
    assert len(reader.pages) <= 20


def test_published_values_without_the_five_poses(fanuc: Path, command: Command) -> None:
    manifest = fanuc / "campaign.toml"
    manifest.write_text(manifest.read_text() + EXCLUDE)
    document = command("identify", fanuc)
    assert document["n_states"] == 38
    for one, published in zip(document["parameters"], PUBLISHED, strict=True):
        # five printed digits
        assert float(f"{one['stiffness']:.4e}") == pytest.approx(published, rel=1e-12)


def test_balanced_on_the_deformed_robot(fanuc: Path, command: Command) -> None:
    first = command("identify", fanuc)
    model = fanuc / "model.toml"
    model.write_text(model.read_text().replace('balance = "first-order"', 'balance = "deformed"'))
    balanced = command("identify", fanuc)
    assert balanced["model"]["balance"] == "deformed"
    change = [
        b["stiffness"] / a["stiffness"] - 1 for a, b in zip(first["parameters"], balanced["parameters"], strict=True)
    ]
    # the load moves by millimetres on arms of metres: some tenths of a per cent, far below the uncertainty
    assert 0 < np.abs(change).max() < 0.05


def _scaled(file: Path, factor: float) -> None:
    """Multiply every number of a table."""
    header, *rows = file.read_text(encoding="utf-8-sig").splitlines()
    scaled = [",".join(repr(factor * float(cell)) for cell in row.split(",")) for row in rows if row.strip()]
    file.write_text("\n".join([header, *scaled]) + "\n")


def test_a_fault_names_the_file_of_its_own_column(fanuc: Path) -> None:
    _scaled(fanuc / "raw/deltaX.csv", 1000.0)
    with pytest.raises(InputError, match=r"^raw/deltaX\.csv: line 2: a displacement of -0\.\d+ m in column deltax"):
        ingest_campaign(fanuc)


SLIPS = {
    "metres as millimetres": ('translation = "m"', 'translation = "mm"', "0.00366 mm under up to 1170 N", "m"),
    "metres as micrometres": ('translation = "m"', 'translation = "um"', "3.19·10⁵ N/µm", "m"),
    "radians as degrees": ('position = "rad"', 'position = "deg"', "joint angles in radians", "rad"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_wrong_unit_that_passes_every_bound_is_reported(slip: str, fanuc: Path) -> None:
    old, new, words, mend = SLIPS[slip]
    manifest = fanuc / "campaign.toml"
    manifest.write_text(manifest.read_text().replace(old, new))
    with pytest.raises(InputError) as raised:
        ingest_campaign(fanuc)
    (fault,) = raised.value.faults
    assert fault.file == "campaign.toml"
    assert fault.place.startswith("sources.table.")
    assert words in fault.reason
    assert f'= "{mend}"' in fault.mend


def test_what_may_be_small_is_let_pass(fanuc: Path) -> None:
    campaign = load_campaign(fanuc)
    states = reduce_campaign(campaign, no_progress).states
    stiff = replace(states, deflection=1e-3 * states.deflection)
    assert check_displacement_unit(states, "m", "x") == []
    assert len(check_displacement_unit(stiff, "m", "x")) == 1
    # one row in another unit, which is a suspect
    largest = np.linalg.norm(states.wrench[:, :3], axis=1).argmax()
    factor = np.where(np.arange(len(states)) == largest, 1e3, 1.0)
    assert check_displacement_unit(replace(states, wrench=states.wrench * factor[:, None]), "m", "x") == []
    # a light load, and a body nearer the base than the load
    assert check_displacement_unit(replace(stiff, wrench=0.04 * stiff.wrench), "m", "x") == []
    inner = replace(stiff.setup, targets=(replace(stiff.setup.targets[0], body=2),))
    assert check_displacement_unit(replace(stiff, setup=inner), "m", "x") == []
    # small angles: a fault only where radians explain more, a warning where that is open, nothing for one pose
    small = replace(states, joints=np.radians(states.joints))
    noise = np.random.default_rng(0).normal(size=states.deflection.shape)
    stated, places = stated_units(campaign), TablePlaces("joints", "wrench")
    assert check_other_readings(replace(small, deflection=noise), campaign.chain, stated, places) == []
    assert len(angles_like_radians(small, "x")) == 1
    assert angles_like_radians(replace(small, joints=0.0 * small.joints + 0.01), "x") == []
    assert angles_like_radians(states, "x") == []


@pytest.mark.practice
def test_the_answer_rests_on_no_single_pose(fanuc: Path) -> None:
    """Without any one pose as with all of them: something is missing, and no effect is named for certain.

    Every sixth pose is left out, besides row 17, which disagrees with all others.
    """
    campaign = load_campaign(fanuc)
    states = reduce_campaign(campaign, no_progress).states
    sound = states.select(np.arange(43) != 16)
    alike = []
    for pose in range(0, 42, 6):
        found = diagnose_states(sound.select(np.arange(42) != pose), placed_robot(campaign), built_in_effects())
        alike.append(bool(found.unexplained) and not any(one.group.firm for one in found.found))
    assert sum(alike) >= 36 / 43 * len(alike)
