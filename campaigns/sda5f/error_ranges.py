"""How far a dumbbell of 0.153 kg moves the hand of the SDA5F, over all joint angles (paper 003, Fig. 4 and 5).

Run it as ``python campaigns/sda5f/error_ranges.py``: it prints, for each arm, the largest position and orientation
error (003, eq. 48 to 52) next to the printed ones.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.dual_quaternions import displacement_of_duals, dual_from_pose
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.simulation.scene import robot_with_values

HERE = Path(__file__).parent
DUMBBELL_KG = 0.153
PRINTED = {"left": (3.5e-3, 4.5e-3), "right": (4.2e-3, 3.7e-3)}  # m, rad


def largest_errors(arm: str, n_poses: int = 20000) -> tuple[float, float]:
    """Return the largest position error, m, and orientation error, rad, of the flange under the dumbbell.

    Parameters
    ----------
    arm : "left" or "right".
    n_poses : drawn evenly within the joints' limits, from a fixed seed.
    """
    campaign = load_campaign(HERE / arm, check_files=False)
    chain = campaign.chain
    angles = np.random.default_rng(3).uniform(chain.limits[:, 0], chain.limits[:, 1], (n_poses, chain.n_joints))
    hand = Attachment(chain.n_joints + 1, np.eye(4))
    setup = MeasurementSetup(Attachment(0, np.eye(4)), hand, (hand,), ("hand",), True, np.eye(4))
    weight = np.zeros((n_poses, 6))
    weight[:, :3] = DUMBBELL_KG * chain.gravity
    balance = solve_balance(robot_with_values(campaign), chain.model_angles(angles), weight, setup)
    nominal = dual_from_pose(balance.unloaded_position[:, 0], balance.unloaded_rotation[:, 0])
    loaded = dual_from_pose(balance.target_position[:, 0], balance.target_rotation[:, 0])
    # 003, eq. 51 and 52: lengths of the position error and of the orientation error.
    error = displacement_of_duals(loaded, nominal).reshape(-1, 2, 3)
    position, orientation = np.sqrt(np.sum(error**2, axis=2)).max(axis=0)
    return float(position), float(orientation)


if __name__ == "__main__":
    for name, (printed_position, printed_orientation) in PRINTED.items():
        position, orientation = largest_errors(name)
        sys.stdout.write(
            f"{name} arm: position up to {1e6 * position:.1f} µm, printed {1e6 * printed_position:.0f} µm "
            f"({printed_position / position:.0f} times); orientation up to {1e6 * orientation:.0f} µrad, printed "
            f"{1e6 * printed_orientation:.0f} µrad ({printed_orientation / orientation:.0f} times)\n"
        )
