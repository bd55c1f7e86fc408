"""Several bodies: the first target is the outermost, and all of them count for what the joints' loads tell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.measurements.load_states import Attachment
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.reduction.loads.excitation import joint_excitation
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

BODIES = Path(__file__).parents[2] / "campaigns" / "kr125-bodies"


def test_targets_from_the_tool_inwards() -> None:
    campaign = load_campaign(BODIES, check_files=False)
    setup = measurement_setup(campaign.manifest, campaign.chain, resolve_frames(campaign.manifest, campaign.chain))
    assert setup.target_names == ("leds6", "leds5", "leds4", "leds3", "leds2", "leds1")
    assert [target.body for target in setup.targets] == [7, 5, 4, 3, 2, 1]


def test_a_body_behind_a_joint_shows_what_the_tool_does_not() -> None:
    chain = six_axes()
    robot = joint_springs(chain, SIX_STIFFNESS)
    tool = played(robot, runs=1, load_scatter=0.02)
    targets = (*tool.setup.targets, *(Attachment(body, np.eye(4)) for body in (5, 4, 3, 2)))
    setup = replace(tool.setup, targets=targets, target_names=("target", "five", "four", "three", "two"))
    balance = solve_balance(robot, chain.model_angles(tool.joints), tool.wrench, setup)
    noise = 2e-5 * np.random.default_rng(1).normal(size=balance.target_position.shape)
    position = balance.target_position + noise
    unknown = np.full((len(tool), 5, 6), np.nan)
    many = replace(
        tool, setup=setup, position=position, rotation=balance.target_rotation, deflection=unknown,
        position_scatter=unknown[:, :, :3],
    )  # fmt: skip
    alone = replace(
        tool, position=position[:, :1], rotation=balance.target_rotation[:, :1], deflection=unknown[:, :1],
        position_scatter=unknown[:, :1, :3],
    )  # fmt: skip
    reported = [np.nanmax([one.relative_std for one in joint_excitation(states, chain)]) for states in (many, alone)]
    assert reported[0] < 0.5 * reported[1]
