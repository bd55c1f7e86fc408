"""The curve of a law that nobody has written down against the law that was played."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.judgement.document import diagnosis_result
from tests.rates.practice import diagnosed_campaign, truth

FOLDER = Path(__file__).parents[2] / "campaigns" / "hidden" / "09"


@pytest.mark.long
def test_a_joint_whose_compliance_follows_another_joints_angle_has_that_curve() -> None:
    """Joint 2 gives by c sin(2.3 q₁) more than its spring; waves of once and twice the angle come near that."""
    size = truth()[FOLDER.name]["hidden"][0]["parameters"]["outside the catalogue"]
    law = next(one for one in diagnosis_result(diagnosed_campaign(FOLDER)).unknown or () if one.of == "joint 2")
    assert law.curve is not None
    assert (law.curve.over, law.curve.unit, law.curve.value_unit) == ("angle:1", "rad", "rad/(N*m)")
    at, value = np.array(law.curve.at), np.array(law.curve.value)
    assert np.all(np.diff(at) > 0.0)
    played = size * np.sin(2.3 * at)
    assert np.corrcoef(value, played)[0, 1] > 0.95
    assert np.polyfit(played, value, 1)[0] == pytest.approx(1.0, abs=0.2)
