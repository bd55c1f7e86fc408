"""campaigns/kr125 from joint-compliance alone: `improve` climbs to the backlash and the p-form that are simulated."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.improve import improve_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.stages.fit import fit_now
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.kr125 import DEGREE, SOURCE, TABLE_2, simulated

JOINTS = (6,)
LINEAR = 'schema = "stiffcal/model/1"\n\n[[effects]]\ntype = "joint-compliance"\njoints = [6]\n'
PLAY_OF_JOINT_4 = """schema = "stiffcal/model/1"

[[effects]]
type = "cubic-stiffness"
joints = [4]

[[effects]]
type = "backlash"
joints = [4]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A joint in three positions."""
    runs = tuple(f"{position}-joint{joint}" for joint in JOINTS for position in "abc")
    campaign = simulated(tmp_path_factory.mktemp("ladder"), runs)
    (campaign / "model.toml").write_text(LINEAR, encoding="utf-8")
    return campaign


def test_play_that_is_crossed_within_the_noise_of_the_sensor(tmp_path: Path) -> None:
    """Joint 4 crosses its play within 0.05 N·m, which the sensor reads to 0.01 to 0.04 N·m in a state."""
    true = load_campaign(SOURCE, check_files=False).model.parameter_settings()
    folder = simulated(tmp_path, tuple(f"{position}-joint4" for position in "abc"))
    (folder / "model.toml").write_text(PLAY_OF_JOINT_4, encoding="utf-8")
    fit = fit_now(up_to_date_states(folder, RunContext()), "linear", RunContext())
    assert fit is not None
    assert fit.last_step is None  # it has settled
    values = {parameter.name: parameter for parameter in fit.parameters}
    for name in ("backlash.j4.width", "backlash.j4.band"):
        value, std = values[name].value, values[name].std
        assert value is not None, name
        assert std is not None, name
        assert abs(value - true[name].value) < 3.0 * std, name


@pytest.mark.practice
def test_improve_adds_what_the_joint_has(folder: Path) -> None:
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
    validation = validate_campaign(folder)
    assert validation.worst[0].residual_m is None  # no displacement was measured
    assert validation.worst[0].residual_rad == validation.max.motor_angle
    assert validation.rms.translation is None
