"""Runs in which the controller was correcting: what it commanded, taken out of what was measured.

With ``compensation = "on"`` the joint log holds q + δq: the controller moves the robot against the deflection. That is
neither deflection nor a motor that is pushed off (servo-deflection). What the rigid chain makes of δq is taken out of
every reading, and the joints are put back to where the run started: what remains is what the load did, and such runs
show the robot like all others. The states as measured stay in the store, for with and without.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.reduction.loads.motion import gauge_directions

# A tenth of an arc second: less than any correction of a deflection that can be measured.
_STANDS_STILL = 5e-7
_NOT_LOGGED = "the controller was correcting, and no joint log contains the correction"


def compensated_states(states: LoadStates) -> NDArray[np.bool_]:
    """Return (n,) True for the states in whose runs the controller was correcting."""
    return np.array([run.compensated for run in states.runs], dtype=np.bool_)[states.run]


def without_commands(states: LoadStates, chain: Chain) -> LoadStates:
    """Return the states as they would have been measured without the controller's corrections.

    Parameters
    ----------
    states : as reduced; states of runs without compensation stay as they are.
    chain : the robot.

    Returns
    -------
    LoadStates
        Runs whose corrections are not logged, or whose deflection came already taken, are set aside.
    """
    on = compensated_states(states)
    if not on.any():
        return states
    position, rotation = states.position.copy(), states.rotation.copy()
    joints, displacement = states.joints.copy(), states.displacement.copy()
    not_logged = np.zeros(len(states), dtype=np.bool_)
    for run in np.unique(states.run[on]):
        members = np.flatnonzero(states.run == run)
        marked = members[states.reference[members]]
        start = joints[marked[0] if marked.size else members[0]]
        travel = np.abs(joints[members] - start).max()
        if states.deflection_given or travel < _STANDS_STILL:
            not_logged[members] = states.used[members]
            continue
        for b, target in enumerate(states.setup.targets):
            shift, turn = _rigid_motion(chain, joints[members], start, target)
            position[members, b] -= shift
            rotation[members, b] = np.swapaxes(turn, 1, 2) @ rotation[members, b]
        if states.setup.gauges:
            along = gauge_directions(states.select(members), chain)
            for g, gauge in enumerate(states.setup.gauges):
                shift, _ = _rigid_motion(chain, joints[members], start, states.setup.targets[gauge.target])
                displacement[members, g] -= np.einsum("ni,ni->n", along[:, g], shift)
        joints[members] = start
    corrected = replace(states, position=position, rotation=rotation, joints=joints, displacement=displacement)
    return corrected.with_set_aside(not_logged, SetAsideCode.COMMANDS_NOT_LOGGED, _NOT_LOGGED)


def _rigid_motion(chain: Chain, joints: Floats, start: Floats, target: Attachment) -> tuple[Floats, Floats]:
    """Return (n, 3) and (n, 3, 3): how the rigid chain's frame moves and turns from the start's joints, base axes."""
    place, rotation = attached_poses(chain, chain.model_angles(joints), target)
    first, upright = attached_poses(chain, chain.model_angles(start[None]), target)
    return place - first, rotation @ upright[0].T
