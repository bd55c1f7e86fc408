"""Whether the poses are enough to find frames from."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.like_poses import SAME_POSE_RAD, pose_groups


def refuse_few_poses(
    unloaded: LoadStates, states: LoadStates, names: tuple[str, ...], trackers: tuple[str, ...]
) -> None:
    """Raise where all `states`, or those that an estimated tracker reads, are too few poses.

    Parameters
    ----------
    unloaded : states that could be gone by. states : those of them that show all targets.
    names : frames to be found. trackers : the frames in which places are read.
    """
    full_pose = bool(np.isfinite(states.rotation).all())
    least = {names[0]: 3 if full_pose or len(names) == 1 or set(names) <= set(trackers) else 4}
    least |= {name: 3 for name in names if name in trackers and len(trackers) > 1}
    for name, count in least.items():
        number = trackers.index(name) if name in trackers and len(trackers) > 1 else None
        own = states if number is None else states.select(states.tracker == number)
        n_poses = different_poses(own.joints)
        if n_poses >= count:
            continue
        found = f"{n_poses} different unloaded pose{' is' if n_poses == 1 else 's are'} too few"
        possible = unloaded if number is None else unloaded.select(unloaded.tracker == number)
        rare = _seldom_measured(possible, count)
        found += f": {' and '.join(rare)} {'was' if len(rare) == 1 else 'were'} measured in no others" if rare else ""
        lacking = rare if n_poses else _never_measured(possible)
        reason = found if n_poses else _not_measured(lacking, len(possible.setup.target_names))
        mend = f"measure {count} or more poses that differ in position and orientation, or give the frame"
        place = f"frames.{name}.estimate"
        raise InputError(Fault(FaultCode.POSES_TOO_FEW, "campaign.toml", place, reason, mend, names=tuple(lacking)))


def _never_measured(states: LoadStates) -> list[str]:
    """Return the targets that no state shows."""
    once: Booleans = np.asarray(np.isfinite(states.position).all(axis=2).any(axis=0))
    return [name for name, measured in zip(states.setup.target_names, once, strict=True) if not measured]


def _not_measured(lacking: list[str], n_targets: int) -> str:
    """Return which targets no unloaded pose shows, or that no pose shows all of them."""
    if len(lacking) == n_targets:
        return "no target was measured in any unloaded pose"
    if lacking:
        return f"{' and '.join(lacking)} {'was' if len(lacking) == 1 else 'were'} measured in no unloaded pose"
    return "no unloaded pose shows all targets"


def _seldom_measured(states: LoadStates, least: int) -> list[str]:
    """Return the targets that are measured in fewer than ``least`` states, where others are in more."""
    times = np.isfinite(states.position).all(axis=2).sum(axis=0)
    names = states.setup.target_names
    return [name for name, n in zip(names, times, strict=True) if n < least <= times.max()]


def different_poses(joints: Floats) -> int:
    """Count configurations that differ by more than a degree."""
    # one degree itself still counts as alike
    return int(pose_groups(joints, np.nextafter(SAME_POSE_RAD, np.inf)).max(initial=-1)) + 1
