"""campaigns/kr125 from joint-compliance alone: `improve` climbs to the backlash and the p-form that are simulated."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.workflow.identify import identify_campaign
from stiffcal.workflow.improve import improve_campaign
from tests.laboratory.kr125 import DEGREE, TABLE_2, simulated

JOINTS = (3, 6)
LINEAR = 'schema = "stiffcal/model/1"\n\n[[effects]]\ntype = "joint-compliance"\njoints = [3, 6]\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two joints in three positions each; of fewer points than usual the play's crossing would be a broken line."""
    runs = tuple(f"{position}-joint{joint}" for joint in JOINTS for position in "abc")

    def all_points(text: str) -> str:
        return text.replace("points = 60", "")

    campaign = simulated(tmp_path_factory.mktemp("ladder"), runs, settings=all_points)
    (campaign / "model.toml").write_text(LINEAR, encoding="utf-8")
    return campaign


def test_improve_adds_what_each_joint_has(folder: Path) -> None:
    result = improve_campaign(folder)
    added = {(step.effect, tuple(step.where.joints or ())) for step in result.steps if step.effect is not None}
    assert added == {(effect, (joint,)) for joint in JOINTS for effect in ("backlash", "cubic-stiffness")}
    values = {parameter.name: parameter for parameter in identify_campaign(folder).parameters}
    for joint in JOINTS:
        width, *stiffness = TABLE_2[joint]  # in degrees and 10³ N·m, the cubic term first
        true = [width * DEGREE, *(p * 1e3 / DEGREE**power for power, p in enumerate(reversed(stiffness), 1))]
        names = [f"backlash.j{joint}.width", *(f"cubic-stiffness.j{joint}.p{power}" for power in (1, 2, 3))]
        for name, expected in zip(names, true, strict=True):
            value, std = values[name].value, values[name].std
            assert value is not None, name
            assert std is not None, name
            assert abs(value - expected) < 3.0 * std, name
