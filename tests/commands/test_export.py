"""Exports, read by programs that are not ours."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import duckdb
import numpy as np
import pandas as pd
import pytest

from stiffcal.commands.export import export_campaign
from stiffcal.commands.plot import plot_campaign
from stiffcal.commands.report import report_campaign
from stiffcal.compensation import fitted_robot
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.report.gathering.one_picture import _approach
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.effect_bench import bare_states
from tests.laboratory.small_campaign import POSES_DEG, STIFFNESS


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_states_hold_measured_predicted_and_residual(campaign: Path, ending: str) -> None:
    file = campaign / f"states.{ending}"
    export_campaign(campaign, output=file)
    with duckdb.connect() as connection:
        frame = connection.execute(f"select * from '{file.as_posix()}'").df()
    assert len(frame) == 100
    difference = frame["target_dz_m_measured"] - frame["target_dz_m_predicted"]
    assert np.allclose(difference, frame["target_dz_m_residual"], atol=1e-12)
    assert float(np.sqrt(np.mean(frame["target_dz_m_residual"] ** 2))) < 20e-6
    assert np.degrees(frame["A1_rad"].iloc[0]) == pytest.approx(POSES_DEG[0][0])


def test_store_tables_are_read_in_one_line(campaign: Path) -> None:
    heldout = pd.read_parquet(campaign / "store" / "current" / "unseen.parquet")
    assert {"state", "run", "row", "target_dx_m_residual"} <= set(heldout.columns)


def test_model_as_json(campaign: Path) -> None:
    file = campaign / "model.json"
    export_campaign(campaign, output=file)
    document = json.loads(file.read_text())
    assert document["parameters"][0]["name"] == "joint-compliance.j1.c"
    assert len(document["covariance"]) == 6


def test_urdf_has_the_same_kinematics(campaign: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    file = campaign / "robot.urdf"
    export_campaign(campaign, output=file)
    model = pinocchio.buildModelFromUrdf(str(file))
    data = model.createData()
    angles = np.radians(POSES_DEG[1])
    pinocchio.framesForwardKinematics(model, data, angles)
    pose = data.oMf[model.getFrameId("flange")].homogeneous
    from stiffcal.mechanics.kinematics import body_poses

    chain = up_to_date_states(campaign, RunContext()).campaign.chain
    positions, rotations = body_poses(chain, chain.model_angles(angles[None]))
    assert np.allclose(pose[:3, 3], positions[0, -1], atol=1e-9)
    assert np.allclose(pose[:3, :3], rotations[0, -1], atol=1e-9)
    stiffness = [float(value) for value in _stiffnesses(file)]
    assert np.allclose(stiffness, STIFFNESS, rtol=0.1)


def test_stiffnesses_that_are_not_significant_are_named(
    campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file of plain numbers does not hold that only a lower limit is known."""

    def one(name: str, *, is_compliance: bool, above_noise: bool | None) -> SimpleNamespace:
        return SimpleNamespace(name=name, is_compliance=is_compliance, above_noise=above_noise)

    parameters = [
        one("joint-compliance.j1.c", is_compliance=True, above_noise=True),
        one("joint-compliance.j2.c", is_compliance=True, above_noise=False),
        one("joint-compliance.j3.c", is_compliance=True, above_noise=None),
        one("link-geometry.j3.x", is_compliance=False, above_noise=False),
    ]
    (words,) = fitted_robot.known_from_below(cast(IdentifyResult, SimpleNamespace(parameters=parameters)))
    assert re.findall(r"[\w-]+\.j\d\.\w", words) == ["joint-compliance.j2.c"]
    assert not list(fitted_robot.known_from_below(cast(IdentifyResult, SimpleNamespace(parameters=parameters[:1]))))
    monkeypatch.setattr(fitted_robot, "known_from_below", lambda identified: iter([words]))
    for name in ("robot.urdf", "code.c", "robot.xml"):
        assert words in export_campaign(campaign, output=tmp_path / name).warnings


def _stiffnesses(file: Path) -> list[str]:
    from xml.etree import ElementTree

    return [element.attrib["value"] for element in ElementTree.parse(file).iter("stiffness")]


def test_unknown_ending_and_missing_folder(campaign: Path) -> None:
    with pytest.raises(InputError, match=r"a name that ends in \.doc does not fit"):
        export_campaign(campaign, output=Path("states.doc"))
    with pytest.raises(InputError, match="its folder does not exist"):
        export_campaign(campaign, output=campaign / "nowhere" / "states.csv")


@pytest.mark.parametrize(
    ("run", "against", "drawn"),
    [
        (None, None, "load-deformation of all runs"),
        ("pose2", None, "load-deformation of run pose2"),
        (None, "torque:4", "residual against torque on joint 4"),
        ("pose1", "angle:A2", "residual against angle of joint 2 in run pose1"),
        (None, "force:z", "residual against force along z"),
        (None, "load", "residual against load"),
    ],
)
def test_plots(campaign: Path, run: str | None, against: str | None, drawn: str) -> None:
    file = campaign / "plot.svg"
    assert plot_campaign(campaign, output=file, run=run, against=against).drawn == drawn
    assert file.read_text(encoding="utf-8").rstrip().endswith("</svg>")


@pytest.mark.parametrize(
    ("run", "against", "message"),
    [
        ("pose9", None, "unknown run pose9; runs: pose1, pose2"),
        (None, "torque:9", "unknown joint 9"),
        (None, "moon", "unknown quantity moon"),
        (None, "time", "time is not logged in this campaign"),
    ],
)
def test_plots_that_cannot_be(campaign: Path, run: str | None, against: str | None, message: str) -> None:
    with pytest.raises(InputError, match=message):
        plot_campaign(campaign, output=campaign / "plot.svg", run=run, against=against)


def test_a_wrong_picture_is_refused_before_anything_is_read(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stiffcal.commands.plot.up_to_date_states", lambda *given: pytest.fail("the logs were read"))
    for of, run in (("moon", None), ("normal", "pose1")):
        with pytest.raises(InputError) as refused:
            plot_campaign(campaign, output=campaign / "plot.svg", of=of, run=run)
        assert refused.value.code is FaultCode.OPTION_INVALID
        assert refused.value.place == "--of"


def test_a_clamped_run_is_torque_over_angle(tmp_path: Path) -> None:
    """Clamped runs have states, and no displacement of a target: axes of force and displacement would be empty."""
    folder = tmp_path / "bench"
    shutil.copytree(Path(__file__).parents[2] / "campaigns" / "joints" / "02", folder)
    manifest = folder / "campaign.toml"
    text = manifest.read_text("utf-8")
    manifest.write_text(text[: text.index('[[runs]]\nid = "p3"')], encoding="utf-8")
    file = folder / "plot.svg"
    assert plot_campaign(folder, output=file, run="p1").drawn == "torque over angle of axis (p1)"
    assert plot_campaign(folder, output=file).drawn.startswith("torque over angle of axis")
    with pytest.raises(InputError, match="no displacement of a target was measured"):
        plot_campaign(folder, output=file, against="torque:1")


@pytest.mark.long
def test_report_is_a_pdf_with_the_stiffness_table(campaign: Path) -> None:
    from pypdf import PdfReader

    file = Path(report_campaign(campaign, RunContext(update=False)).file)
    assert file == campaign / "report.pdf"
    # a number stays with its unit
    text = "\n".join(page.extract_text() for page in PdfReader(file).pages).replace("\N{NO-BREAK SPACE}", " ")
    assert "medium six-axis" in text
    assert "98.5 % of the" in text
    first = file.read_bytes()
    report_campaign(campaign, RunContext(update=False))
    assert file.read_bytes() == first


def test_the_approach_of_a_joint_that_never_moved_is_no_picture() -> None:
    """Joint 2 came from both sides, joint 1 from none; states without directions have their own line."""
    states = replace(bare_states([0, 1, 2]), approach=np.array([[0.0, 1.0], [0.0, -1.0], [0.0, 0.0]]))
    np.testing.assert_array_equal(_approach(states, 1), [1.0, -1.0, np.nan])
    with pytest.raises(InputError, match="joint 1 did not move before any row"):
        _approach(states, 0)
    with pytest.raises(InputError, match="not known in this campaign"):
        _approach(replace(states, approach=np.zeros((3, 2))), 0)
