"""Settings that the readings may contradict: parameters that are held, the first-order balance, a tool not stated."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.parameters import Parameter
from stiffcal.identification.fit import Fit
from stiffcal.identification.observation import predicted, rests
from stiffcal.judgement.evidence import MemberColumns
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.priors import LEVER_OF_TOOL, SIZE_WEIGHTS, SIZES, TOOL_SIZES, MemberKind, RobotScale, Share
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import ParameterRole

UNSTATED_TOOL = "tool not stated"
"""Name of the member by which the robot carries a tool of which nothing is said."""
BALANCE = "balance first-order"
"""Name of the member by which the wrench acts on the deformed robot."""


@dataclass(frozen=True)
class SettingOff:
    """A setting that the readings may contradict."""

    name: str
    """In words; of a held parameter its full name."""
    share: Share
    """What it is before any reading."""
    columns: MemberColumns
    """What it does to the readings."""


def settings_off(ground: Ground, fit: Fit, of_tool: Floats | None, scale: RobotScale) -> Iterator[SettingOff]:
    """Give the settings that may be wrong, about a fit.

    Parameters
    ----------
    of_tool : (4, m, n) how the readings change with mass and first moment of the link that carries the tool; None where
        every hypothesis has its weight, and where a tool is stated.
    """
    for parameter in fit.parameters:
        if parameter.fixed and parameter.spec.role is ParameterRole.AMPLITUDE:
            yield from _released(ground, parameter, scale)
    if not fit.robot.deformed:
        deformed = replace(fit.robot, deformed=True)
        change = predicted(deformed, ground.space.data, *rests(deformed, ground.space.data)) - ground.state.predicted
        # it has no size of its own
        columns = MemberColumns(ground.space.rows(change[None]), np.ones(1, np.bool_), np.ones(1), np.ones(1))
        yield SettingOff(BALANCE, Share("balance", BALANCE, MemberKind.SETTING, False), columns)
    if of_tool is not None:
        payload = np.abs(ground.space.data.wrench[:3]).max(initial=0.0) / max(_gravity(fit.robot.chain), 1e-3)
        rows = ground.space.rows(of_tool * payload) * np.array([1.0, *[LEVER_OF_TOOL] * 3])[:, None]
        even = np.full(len(TOOL_SIZES), 1.0 / len(TOOL_SIZES))
        # what is carried has no negative mass
        columns = MemberColumns(rows, np.array([True, False, False, False]), TOOL_SIZES, even)
        yield SettingOff(UNSTATED_TOOL, Share("tool", UNSTATED_TOOL, MemberKind.SETUP, False), columns)


def _released(ground: Ground, parameter: Parameter, scale: RobotScale) -> Iterator[SettingOff]:
    """Give a held amplitude as what it may be off by, as large as the effect usually is."""
    placed = next(
        one for one in ground.state.robot.placed if (one.effect.name, one.place) == (parameter.effect, parameter.place)
    )
    regressor = ground.state.regressor(placed.effect, placed.place, placed.shape())
    if parameter.spec.symbol not in regressor.symbols:
        return
    column = regressor.columns[regressor.symbols.index(parameter.spec.symbol)]
    rows = ground.space.rows(column[None]) * scale.typical(placed.effect, placed.place, parameter.spec.symbol)
    share = Share(parameter.name, "held", MemberKind.SETTING, False)
    yield SettingOff(parameter.name, share, MemberColumns(rows, np.zeros(1, np.bool_), SIZES, SIZE_WEIGHTS))


def _gravity(chain: Chain) -> float:
    return float(np.linalg.norm(chain.gravity))
