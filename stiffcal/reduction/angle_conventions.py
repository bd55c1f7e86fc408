"""Other ways to count joint angles than stated: units, columns, directions, angles counted together.

On FANUC's and some other controllers the angle of joint 3 stands still while joint 2 moves the forearm: it is the sum
of two angles of the robot file, or the difference. So are angles of motors of a wrist, whose gears lie one in another.
`logged` of robot.toml states the sum.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.signals import JointSignals
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.quantities import unit, unit_names

# Where the search for a joint's zero begins, rad: the whole circle lies within half a quarter of one of them.
QUARTERS = (0.0, np.pi / 2, np.pi, -np.pi / 2)
# Of a joint before it: counted against it, not at all, or together with it.
_COUNTED = (-1.0, 0.0, 1.0)


@dataclass(frozen=True)
class CountedAngles:
    """Joint angles as they are if they were counted in another way than the robot file states."""

    joints: Floats
    """(n, L) rad, as they would be; m of a prismatic joint."""
    change: InputChange
    """The other way."""


def stated_units(campaign: Campaign) -> Floats:
    """Return (L,) the units that the manifest states of the logged angles, rad; 1 of a prismatic joint's length."""
    count = campaign.chain.coupling.shape[1]
    signal = next((signal for _, _, signal in campaign.manifest.signals() if isinstance(signal, JointSignals)), None)
    units = () if signal is None else signal.position_units(count)
    if len(units) != count:
        return np.ones(count)
    return np.array([own.factor if own.quantity == "angle" else 1.0 for own in units])


def counted_otherwise(joints: Floats, chain: Chain, stated: Floats) -> Iterator[CountedAngles]:
    """Yield another direction of a joint, all or one in another unit, counted together, two columns interchanged.

    Parameters
    ----------
    joints : (n, L) logged, rad; m of prismatic joints. chain : the robot. stated : as of `stated_units`.
    """
    names = logged_names(joints, chain)
    for k, name in enumerate(names):
        yield CountedAngles(_with(joints, k, -joints[:, k]), InputChange(ChangeKind.DIRECTION, (name,)))
    turning = np.flatnonzero(~chain.prismatic[: joints.shape[1]]).tolist()
    for unit_name in unit_names("angle"):
        factor = unit(unit_name, "angle").factor / stated
        others = [k for k in turning if not np.isclose(factor[k], 1.0)]
        if others:
            angles = joints * np.where(np.isin(np.arange(joints.shape[1]), turning), factor, 1.0)
            yield CountedAngles(angles, InputChange(ChangeKind.ANGLE_UNIT, value=unit_name))
        for k in others:
            change = InputChange(ChangeKind.JOINT_UNIT, (names[k],), value=unit_name)
            yield CountedAngles(_with(joints, k, factor[k] * joints[:, k]), change)
    yield from coupled_angles(joints, chain)
    for a, b in combinations(range(joints.shape[1]), 2):
        angles = joints.copy()
        angles[:, [a, b]] = joints[:, [b, a]]
        yield CountedAngles(angles, InputChange(ChangeKind.JOINT_ORDER, (names[b], names[a])))


def coupled_angles(joints: Floats, chain: Chain) -> Iterator[CountedAngles]:
    """Yield the angles with each turning joint counted otherwise together with one before it.

    Parameters
    ----------
    joints : (n, L) logged, rad. chain : the robot.
    """
    if len(chain.joint_names) != joints.shape[1]:
        return
    turning = [joint for joint in range(min(joints.shape[1], chain.n_joints)) if not chain.prismatic[joint]]
    for first, second in combinations(turning, 2):
        stated = float(chain.coupling[second, first] / chain.coupling[second, second])
        for counted in _COUNTED:
            share = counted - stated
            if abs(share) not in (1.0, 2.0):  # nothing changes, or a gear between the two is stated
                continue
            angles = _with(joints, second, joints[:, second] + share * joints[:, first])
            pair = chain.joint_names[first], chain.joint_names[second]
            yield CountedAngles(angles, InputChange(ChangeKind.COUNTED_TOGETHER, pair, (share,)))


def logged_names(joints: Floats, chain: Chain) -> tuple[str, ...]:
    """Return the names of the logged joints; their numbers where the robot file names others."""
    count = joints.shape[1]
    return chain.joint_names if len(chain.joint_names) == count else tuple(map(str, range(count)))


def _with(joints: Floats, joint: int, angles: Floats) -> Floats:
    changed = joints.copy()
    changed[:, joint] = angles
    return changed
