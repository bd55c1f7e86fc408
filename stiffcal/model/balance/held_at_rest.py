"""The held frame of a clamped robot whose weight has bent it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.clamped_inverse import inverse_of
from stiffcal.mechanics.kinematics import cross
from stiffcal.model.balance.deformed_chain import deformed_chain
from stiffcal.model.balance.equilibrium import displacement_between
from stiffcal.model.effect import RZ, joint_node
from stiffcal.model.held_frame import HeldFrame

# No drive of a robot gives by more, rad.
MOST_TURN = 0.02


def held_at_rest(
    held: HeldFrame, chain: Chain, angles: Floats, small: Floats | None, run: Integers, attachment: Attachment
) -> HeldFrame:
    """Return the held frame as it is reached from the chain that its weight has bent.

    A robot is clamped after it has sagged: by 5 mrad, and its Jacobian differs by about a per cent of the undeformed
    chain's, of which the pseudo-inverse would make a give of the drive in what the others give.

    Parameters
    ----------
    held : of n states, on the undeformed chain. chain : of the model.
    angles : (J, n) model angles, rad. run : (n,) run number.
    small : (2J + 2, 6, n) node displacements under weight alone, node axes; None: none.
    attachment : the held frame.
    """
    clamped = np.flatnonzero(held.inverse.any(axis=(0, 1)))
    if not len(clamped):
        return held
    numbers, first, place = np.unique(run[clamped], return_index=True, return_inverse=True)
    one = clamped[first]
    shape = deformed_chain(chain, angles[:, one], None if small is None else small[:, :, one])
    position = shape.bodies[attachment.body].moved(attachment.transform).position
    columns = []
    for joint in range(1, chain.n_joints + 1):
        node = joint_node(joint)
        axis = shape.nodes[node].rotation[:, RZ % 3]
        columns.append(np.concatenate([cross(axis, position - shape.nodes[node].position), axis]))
    drives = np.einsum("jir,jk->rik", np.stack(columns), chain.drive_axes)
    logged = np.linalg.inv(chain.drive_axes) @ chain.coupling
    inverse, jacobian = held.inverse.copy(), held.jacobian.copy()
    for number in range(len(numbers)):
        in_run = clamped[place == number]
        inverse[:, :, in_run] = inverse_of(drives[number])[:, :, None]
        jacobian[:, :, in_run] = (drives[number] @ logged)[:, :, None]
    return replace(held, inverse=inverse, jacobian=jacobian)


def second_order_turn(
    held: HeldFrame,
    chain: Chain,
    angles: Floats,
    small: Floats | None,
    attachment: Attachment,
    displacement: Floats,
) -> Floats:
    """Return (6, n) what a displacement of the held frame holds of second order in the turn of the drives, m and rad.

    A joint that turns by 5 mrad carries a flange at 2 m along an arc of 25 µm height. The drives are turned back along
    this arc; taken for a straight way, it would be a curvature of the joint's stiffness.

    Parameters
    ----------
    held : of n states, as `held_at_rest` returns it. chain : of the model. angles : (J, n) model angles, rad.
    small : (2J + 2, 6, n) node displacements under weight alone, node axes; None: none.
    attachment : the held frame. displacement : (6, n) of the held frame, base axes, m and rad.
    """
    curved = np.zeros_like(displacement)
    clamped = np.flatnonzero(held.inverse.any(axis=(0, 1)))
    if not len(clamped):
        return curved
    turn = chain.drive_axes @ np.einsum("jin,in->jn", held.inverse[:, :, clamped], displacement[:, clamped])
    # on its way to the solution a fit may pass models that give by far more: they are not followed along their arcs
    turn *= np.minimum(1.0, MOST_TURN / np.maximum(np.abs(turn).max(axis=0), MOST_TURN))
    bent = None if small is None else small[:, :, clamped]
    before, after, opposite = (
        deformed_chain(chain, angles[:, clamped] + sign * turn, bent)
        .bodies[attachment.body]
        .moved(attachment.transform)
        for sign in (0.0, 1.0, -1.0)
    )
    curved[:, clamped] = 0.5 * (displacement_between(after, before) + displacement_between(opposite, before))
    return curved
