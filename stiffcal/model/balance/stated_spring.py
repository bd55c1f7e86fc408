"""The balancing spring that robot.toml states, which acts as masses do, whether or not an effect of the model is it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.abilities import ParallelSpring
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.scalar_laws import BalancingSpring


def spring_at_rate(chain: Chain, rate: float) -> BalancingSpring | None:
    """Return the spring of robot.toml's geometry with a rate, N/m; None where the file declares none.

    Its free length follows from the preload at the joint's zero and the stated rate, whatever rate it has in truth.
    """
    if chain.compensator is None:
        return None
    joint = spring_joint(chain)
    fixed, arm = chain.fixed[joint - 1], _point(chain, "arm_m")
    # In the joint's frame before it turns, whose z is the joint's axis.
    anchor = fixed[:3, :3].T @ (_point(chain, "anchor_m") - fixed[:3, 3])
    nominal = chain.compensator.get("rate_N_m")
    preload = chain.compensator.get("preload_N") or 0.0
    stretched = 0.0 if nominal is None else float(str(preload)) / float(str(nominal))
    untensed = BalancingSpring(joint, _three(anchor), _three(arm), rate, 0.0)
    return replace(untensed, free_length=float(untensed.length(chain.offset[joint - 1])) - stretched)


def spring_joint(chain: Chain) -> int:
    """Return the compensated joint, from 1."""
    return int(str((chain.compensator or {})["joint"]))


def stated_rate(chain: Chain) -> float | None:
    """Return the rate, N/m, with which the spring counts though no effect holds it; None where it does not.

    It balances weight: where masses are not known and no weight acts, its torque alone would be wrong by all of it.
    """
    rate = None if chain.compensator is None else chain.compensator.get("rate_N_m")
    return None if rate is None or not chain.masses_known else float(str(rate))


def stated_spring(robot: CompliantRobot) -> BalancingSpring | None:
    """Return the spring that robot.toml states; None where it states none, or an effect of the model is that spring."""
    rate = stated_rate(robot.chain)
    if rate is None:
        return None
    if any(parallel_spring(robot.chain, placed) is not None for placed in robot.acting):
        return None
    return spring_at_rate(robot.chain, rate)


def parallel_spring(chain: Chain, placed: PlacedEffect) -> BalancingSpring | None:
    """Return the spring that an effect puts in parallel with its joint's drive; None where it puts none."""
    effect = placed.effect
    return effect.balancing_spring(placed.place, chain, placed.values) if isinstance(effect, ParallelSpring) else None


def spring_torque(chain: Chain, angles: Floats) -> Floats:
    """Return (n, J) N·m that the spring adds to the joints at model angles (n, J); 0 where no rate is stated."""
    torque = np.zeros_like(angles)
    rate = None if chain.compensator is None else chain.compensator.get("rate_N_m")
    spring = None if rate is None else spring_at_rate(chain, float(str(rate)))
    if spring is not None:
        torque[:, spring.joint - 1] = spring.torque(angles[:, spring.joint - 1])
    return torque


def is_spring_modelled(robot: CompliantRobot) -> bool:
    """Return whether robot.toml declares no spring, or an effect of the model is about it, with or without a value."""
    if robot.chain.compensator is None:
        return True
    joint = spring_joint(robot.chain)
    of_springs = (p for p in robot.acting if isinstance(p.effect, ParallelSpring))
    return any(placed.place.joints == (joint,) for placed in of_springs)


def _point(chain: Chain, key: str) -> Floats:
    return np.asarray((chain.compensator or {})[key], dtype=np.float64)


def _three(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
