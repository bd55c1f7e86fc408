"""Sections that a customer asks for in campaign.toml: acceptance limits and lines for signatures."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from stiffcal.campaign.manifest.report_settings import MOST_SIGNATURES, ReportSettings
from stiffcal.report.blocks import LeftOut, Paragraph, ReportSection, TableBlock
from stiffcal.report.content import PoseStiffness, ReportContent
from stiffcal.report.sections import acceptance, cartesian, sign_off
from stiffcal.validation.results import ThresholdCheck
from tests.laboratory.report_content import made_up_content

WITHIN = ThresholdCheck("max_rms_m", "", 1e-4, 5e-5, "m", True, "within")
BELOW = ThresholdCheck("min_stiffness", "A2", 2e6, 1e6, "N·m/rad", False, "below")
UNKNOWN = ThresholdCheck("max_over_noise", "", 1.5, None, "", None, "not known")


def content(*checks: ThresholdCheck, **settings: Any) -> ReportContent:
    """Return made-up content with these checks of its validation."""
    made = made_up_content()
    assert made.validate is not None
    return replace(
        made, validate=replace(made.validate, checks=list(checks)), settings=ReportSettings.model_validate(settings)
    )


def test_nothing_is_added_without_being_asked_for() -> None:
    assert acceptance.section(content(WITHIN)) is None
    assert sign_off.section(content(WITHIN)) is None


@pytest.mark.parametrize(
    ("checks", "verdict"), [((WITHIN,), "Passed"), ((WITHIN, BELOW, UNKNOWN), "Failed"), ((WITHIN, UNKNOWN), "Not")]
)
def test_every_limit_is_listed_with_its_result(checks: tuple[ThresholdCheck, ...], verdict: str) -> None:
    section = acceptance.section(content(*checks, acceptance=True))
    assert isinstance(section, ReportSection)
    key, table = section.blocks
    assert isinstance(key, Paragraph)
    assert isinstance(table, TableBlock)
    assert key.text.startswith(verdict)
    results = {True: "passed", False: "FAILED", None: "not judged"}
    assert [row[-1] for row in table.rows] == [results[check.held] for check in checks]


def test_limits_are_in_the_units_that_people_read() -> None:
    section = acceptance.section(content(WITHIN, BELOW, acceptance=True))
    assert isinstance(section, ReportSection)
    table = section.blocks[1]
    assert isinstance(table, TableBlock)
    first, second = (list(row[1:5]) for row in table.rows)
    assert first == ["", "0.100", "0.0500", "mm"]
    assert second == ["A2", "2.00·10⁶", "1.00·10⁶", "N·m/rad"]


def test_without_limits_the_report_names_what_is_missing() -> None:
    assert isinstance(acceptance.section(content(acceptance=True)), LeftOut)


def test_each_role_has_a_line_to_sign() -> None:
    section = sign_off.section(content(sign_off=["measured by", "approved by"]))
    assert section is not None
    (table,) = section.blocks
    assert isinstance(table, TableBlock)
    assert [row[0].strip() for row in table.rows] == ["measured by", "approved by"]


@pytest.mark.parametrize("wrong", [{"sign_off": ["x"] * (MOST_SIGNATURES + 1)}, {"sign_off": [""]}, {"logo": 1}])
def test_wrong_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        ReportSettings.model_validate(wrong)


def test_stiffness_in_a_pose_follows_its_uncertainty() -> None:
    compliance = np.array([1e-6, 2e-6, 0.0, 1e-6, 1e-6, 1e-6])
    pose = PoseStiffness(np.radians([0.0, -90.0, 45.0]), "tool", compliance, 0.01 * compliance, None)
    section = cartesian.section(replace(made_up_content(), stiffness_poses=(pose,)))
    assert isinstance(section, ReportSection)
    table = section.blocks[1]
    assert isinstance(table, TableBlock)
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["along x"] == ("1.000 ± 0.020", "–", "N/µm")
    assert rows["about x"] == ("1000 ± 20", "–", "kN·m/rad")
    assert rows["along z"][0] == "–"
    assert "−90.0°" in table.caption
    assert cartesian.section(made_up_content()) is None
