"""The temperature that effects know in a simulation: that of the log, each state's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.effects_api import (
    Chain,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
    drive_terms,
    drive_torque,
)
from stiffcal.errors import InputError
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.simulation.hidden import check_hidden
from stiffcal.simulation.played.true_motion import TrueRun, solve_true_runs
from stiffcal.simulation.scene import draw_acts, robot_with_values, tool_weight, true_frames
from stiffcal.simulation.settings import load_settings

FOLDER = Path(__file__).parents[2] / "campaigns" / "irb4400"
COLD, PER_HOUR, PER_KELVIN, JOINT = 288.15, 60.0, 5e-8, 2


class WarmJoint(Law):
    """δ_Rz = c (T − 288.15 K) τ."""

    name = "warm-joint"
    place_kind = "joints"
    summary = "softer as it warms"
    parameters = (ParameterSpec("c", "rad/(N·m·K)", "per kelvin", -1e-6, 1e-6, 1e-8, "test"),)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> tuple[Term, ...]:
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        return (*drive_terms(chain, place.joints[0], "c", np.nan_to_num(loads.temperature - COLD) * torque),)


WARM = PlacedEffect(WarmJoint(), Place("joints", (JOINT,)), {"c": PER_KELVIN})


def solver(start: float, per_hour: float) -> tuple[CompliantRobot, Callable[[CompliantRobot], list[TrueRun]]]:
    """Return the robot with the law, and what plays its first run from a temperature, K, that rises by K per hour."""
    campaign, settings = load_campaign(FOLDER, check_files=False), load_settings(FOLDER)
    frames = true_frames(campaign, settings)
    planned = replace(draw_acts(campaign, settings, frames, 0)[0], start_K=start, warming_K_per_hour=per_hour)
    robot = robot_with_values(campaign)
    tool = tool_weight(campaign.manifest)
    return replace(robot, placed=(*robot.placed, WARM)), lambda played: solve_true_runs(played, [planned], frames, tool)


def solved(start: float, per_hour: float) -> TrueRun:
    robot, solve = solver(start, per_hour)
    return solve(robot)[0]


def test_a_law_over_temperature_is_softer_by_what_each_state_is_warmer() -> None:
    warming = solved(COLD, PER_HOUR)
    program = warming.planned.program
    last = len(program) - 2  # the last loaded hold
    risen = PER_HOUR * 0.5 * (program.start[last] + program.end[last]) / 3600.0
    assert risen > 1.0
    at = np.array([2.0 * last])
    runs = {"steady": solved(COLD + risen, 0.0), "cold": solved(COLD, 0.0), "unknown": solved(np.nan, PER_HOUR)}
    place = {name: run.position_at("probe_point", at) for name, run in {**runs, "warming": warming}.items()}
    # at one and the same temperature the place is the same, whatever the temperature was before
    np.testing.assert_allclose(place["warming"], place["steady"], atol=1e-11)
    assert np.linalg.norm(place["warming"] - place["cold"]) > 1e-6
    # without a logged temperature the law is that of the cold robot
    np.testing.assert_array_equal(place["unknown"], place["cold"])


def test_a_hidden_effect_that_changes_nothing_is_refused() -> None:
    robot, solve = solver(COLD, PER_HOUR)
    check_hidden(["warm-joint", "joint-compliance"], robot, solve(robot), solve)
    robot, solve = solver(np.nan, PER_HOUR)
    with pytest.raises(InputError) as raised:
        check_hidden(["warm-joint", "joint-compliance"], robot, solve(robot), solve)
    assert [fault.code for fault in raised.value.faults] == ["hidden-inactive"]
    assert "warm-joint" in raised.value.faults[0].reason
