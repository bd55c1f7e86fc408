"""Absolute places whose table states from where each joint came: what friction and creep in a drive leave is named."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import ingest_campaign, stored_states
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import EffectAtRest
from stiffcal.model.forms import added_forms
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign

PRACTICE = Path(__file__).resolve().parents[2] / "campaigns" / "absolute" / "02"
STIFFNESS = (2.0e6, 2.0e6, 1.6e6, 3.5e5, 2.5e5, 1.7e5)
SPRINGS = "\n".join(
    f'"joint-compliance.j{k}.c" = {{ value = {1.0 / stiffness} }}' for k, stiffness in enumerate(STIFFNESS, start=1)
)
SIMULATE = """
schema = "stiffcal/simulate/1"
seed = 3
[absolute]
poses = 80
payloads_kg = [0.0, 80.0, 150.0]
point = "payload"
[robot]
geometry_error_m = 2.5e-4
geometry_error_rad = 5e-4
hidden = ["HIDDEN"]
[frames.tracker]
xyz_m = [3.4, -1.1, 0.35]
rpy_deg = [0.3, -0.5, 120.0]
[frames.target1]
xyz_m = [0.083, 0.004, 0.118]
[sensors.table.white]
translation_m = 2e-5
[[runs]]
id = "poses"
joints_deg = [0, -70, 20, 0, 0, 0]
"""


@dataclass(frozen=True)
class Hidden:
    """An effect of one joint that the campaign's model lacks."""

    effect: str
    joint: int
    values: dict[str, float]


# 2 c slip = 0.12 mrad, 0.1 mm at the tool
FRICTION = Hidden("friction-hysteresis", 3, {"c": 3e-7, "slip": 200.0})
CREEP = Hidden("creep", 2, {"c": 5e-8, "time": 30.0})


def campaign(folder: Path, hidden: Hidden, logged: str, gear_ratio: float | None = None) -> Path:
    """Simulate a campaign; ``logged`` is how its manifest states the order: "columns", "direct" or "" (not at all).

    With a ``gear_ratio`` the angles are those of the motors.
    """
    source, out = folder / "source", folder / "campaign"
    source.mkdir(parents=True)
    robot = (PRACTICE / "robot.toml").read_text(encoding="utf-8")
    if gear_ratio is not None:
        robot = robot.replace("limits_deg", f"gear_ratio = {gear_ratio}\nlimits_deg")
    (source / "robot.toml").write_text(robot, encoding="utf-8")
    manifest = (PRACTICE / "campaign.toml").read_text(encoding="utf-8")
    manifest = manifest.replace("\ndead_weight", '\nhold = { column = "held", units = { time = "s" } }\ndead_weight')
    if logged == "direct":
        manifest = manifest.rstrip() + '\napproach = "direct"\n'
    elif logged == "columns":
        manifest = manifest.replace('position = "A1..A6",', 'position = "A1..A6", approach = "S1..S6",')
    if gear_ratio is not None:
        manifest = manifest.replace('position = "A1..A6",', 'position = "A1..A6", motor = true,')
    (source / "campaign.toml").write_text(manifest, encoding="utf-8")
    name = f"{hidden.effect}.j{hidden.joint}"
    values = "\n".join(f'"{name}.{symbol}" = {{ value = {value} }}' for symbol, value in hidden.values.items())
    (source / "model.toml").write_text(
        f'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = "all"\n[effects.parameters]\n'
        f'{SPRINGS}\n[[effects]]\ntype = "link-geometry"\njoints = "all"\n[[effects]]\ntype = "{hidden.effect}"\n'
        f"joints = [{hidden.joint}]\n[effects.parameters]\n{values}\n",
        encoding="utf-8",
    )
    (source / "simulate.toml").write_text(SIMULATE.replace("HIDDEN", hidden.effect), encoding="utf-8")
    simulate_campaign(load_campaign(source, check_files=False), load_settings(source), out)
    return out


@pytest.mark.long
def test_friction_is_named_by_the_direction_of_the_last_motion(tmp_path: Path) -> None:
    folder = campaign(tmp_path, FRICTION, "columns")
    (missing,) = diagnose_campaign(folder).missing
    assert (missing.effect, missing.where.joints) == ("friction-hysteresis", [3])
    edit_model(folder, "add", "friction-hysteresis", where={"joints": "3"}, start={"width": 1e-4})
    width = identify_campaign(folder).parameter("friction-hysteresis.j3.width")
    assert width.value is not None
    assert width.std is not None
    assert abs(width.value - 2.0 * 3e-7 * 200.0) < 3.5 * width.std < 2e-5


@pytest.mark.practice
def test_creep_is_named_where_the_rows_follow_each_other(tmp_path: Path) -> None:
    result = diagnose_campaign(campaign(tmp_path, CREEP, "direct"))
    assert not {"friction-hysteresis", "creep"} & {entry.effect for entry in result.not_tried}
    assert [(effect.effect, effect.where.joints) for effect in result.missing] == [("creep", [2])]
    values = {value.symbol: value.value for value in result.findings[0].parameters}
    # five standard uncertainties of each in these poses
    assert values["c"] == pytest.approx(5e-8, rel=0.1)
    assert values["time"] == pytest.approx(30.0, rel=0.25)


@pytest.mark.parametrize(("logged", "not_tried"), [("", {"friction-hysteresis", "creep"}), ("columns", {"creep"})])
def test_what_is_not_tried_without_the_order(tmp_path: Path, logged: str, not_tried: set[str]) -> None:
    folder = campaign(tmp_path, CREEP, logged)
    ingest_campaign(folder)
    chain, states, effects = load_campaign(folder).chain, stored_states(folder), built_in_effects()
    laws = {name: law for name in ("friction-hysteresis", "creep") if isinstance(law := effects[name], EffectAtRest)}
    reasons = {name: [form.lacking(chain, states) for form in added_forms(law)] for name, law in laws.items()}
    lacking = {name: "" if None in every else str(every[0]) for name, every in reasons.items()}
    assert {name for name, needs in lacking.items() if needs} == not_tried
    assert all("order of approach" in lacking[name] for name in not_tried)


def test_rows_and_columns_state_the_same_directions(tmp_path: Path) -> None:
    found = []
    for logged in ("columns", "direct"):
        place = tmp_path / logged
        folder = campaign(place, FRICTION, logged)
        ingest_campaign(folder)
        found.append(stored_states(folder).approach)
    np.testing.assert_array_equal(found[0], found[1])
    assert {-1.0, 1.0} <= set(found[0][1:].ravel().tolist())
    assert not found[0][0].any()


def test_a_motor_that_turns_against_its_joint_states_the_joint_s_direction(tmp_path: Path) -> None:
    found = []
    for gear_ratio in (None, -100.0):
        folder = campaign(tmp_path / str(gear_ratio), FRICTION, "columns", gear_ratio)
        ingest_campaign(folder)
        found.append(stored_states(folder))
    np.testing.assert_allclose(found[0].joints, found[1].joints, atol=1e-8)  # a table of nine digits
    np.testing.assert_array_equal(found[0].approach, found[1].approach)
