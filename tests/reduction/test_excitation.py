"""What `check` expects of each joint is what a fit finds: springs on the drives, parallel rods included."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.measurements.load_states import LoadStates, RunInfo
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.reduction.loads.excitation import joint_excitation
from stiffcal.reduction.loads.motion import less_means_of_runs
from tests.laboratory.absolute_places import place_setup
from tests.laboratory.effect_bench import bare_states
from tests.laboratory.track_and_arm import TRACK, draw_joints, robot_of

IRB = Path(__file__).resolve().parents[2] / "campaigns" / "irb4400"
STIFFNESS = (7.3e5, 4.9e5, 4.3e5, 6.0e4, 5.7e4, 1.7e4)  # N·m/rad
NOISE_M = 1e-5
N_POSES, N_LOADS = 6, 12


def test_means_are_of_a_run_whatever_the_order_and_of_what_was_measured() -> None:
    values = np.array([[1.0, np.nan], [10.0, 4.0], [3.0, np.nan], [20.0, 8.0]])
    less = less_means_of_runs(values, np.array([2, 0, 2, 0]))
    np.testing.assert_array_equal(less, [[-1.0, np.nan], [-5.0, -2.0], [1.0, np.nan], [5.0, 2.0]])


def test_a_robot_with_a_parallel_rod_is_known_to_its_noise() -> None:
    campaign = load_campaign(IRB, check_files=False)
    chain, generator = campaign.chain, np.random.default_rng(2)
    assert chain.mechanical.any()
    values = {f"joint-compliance.j{k + 1}.c": 1.0 / stiffness for k, stiffness in enumerate(STIFFNESS)}
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    n = N_POSES * N_LOADS
    joints = np.repeat(generator.uniform(-0.8, 0.8, (N_POSES, 6)), N_LOADS, axis=0)
    wrench = np.zeros((n, 6))
    wrench[:, :3] = 300.0 * generator.normal(size=(n, 3))
    wrench[::N_LOADS] = 0.0
    balance = solve_balance(placed_robot(campaign).with_values(values), chain.model_angles(joints), wrench, setup)
    position = balance.target_position + NOISE_M * generator.normal(size=balance.target_position.shape)
    n_targets = position.shape[1]
    states = LoadStates(
        runs=tuple(RunInfo(f"pose{k}") for k in range(N_POSES)),
        run=np.repeat(np.arange(N_POSES), N_LOADS),
        time=np.arange(float(n)),
        hold=np.full(n, np.nan),
        joints=joints,
        wrench=wrench,
        position=position,
        rotation=np.full((n, n_targets, 3, 3), np.nan),
        deflection=np.full((n, n_targets, 6), np.nan),
        reference=np.arange(n) % N_LOADS == 0,
        temperature=np.zeros((n, 0)),
        row=np.arange(n),
        n_readings=np.ones(n, dtype=np.int64),
        wrench_scatter=np.full((n, 6), np.nan),
        position_scatter=np.full((n, n_targets, 3), np.nan),
        set_aside=np.full(n, ""),
        setup=setup,
    )
    # what is left by a first-order look is noise and little else; with springs on the joints it is 13 %
    assert max(entry.relative_std for entry in joint_excitation(states, chain)) < 0.02


def test_a_track_that_no_force_pushes_carries_no_force() -> None:
    """Forces across its axis: it is a force that is missing, along the axis, and no lever arm makes one."""
    chain = chain_of(robot_of(TRACK), Path())
    along = chain.fixed[0][:3, 2]
    force = 300.0 * np.random.default_rng(1).normal(size=(20, 3))
    wrench = np.hstack([force - np.outer(force @ along, along), np.zeros((20, 3))])
    wrench[::10] = 0.0
    states = bare_states([0] * 10 + [1] * 10, draw_joints(chain, 20, 1), place_setup(chain), wrench=wrench)
    words = [entry.verdict for entry in joint_excitation(states, chain)]
    assert words[0] == "carries no force in these poses: load it along its axis"
    assert not any("force" in verdict for verdict in words[1:])
