"""An outside robot with drives: what torque MuJoCo needs to move a chain against frictional loss, dampers, weight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.quaternions import quaternion_from_rotation

STEP_S = 1e-3


@dataclass(frozen=True)
class Drives:
    """Each joint's drive.

    Attributes
    ----------
    loss : (J,) N·m of dry friction. damping : (J,) N·m·s/rad. inertia : (J,) kg·m² of the rotor, joint side.
    """

    loss: Floats
    damping: Floats
    inertia: Floats


def _xml(chain: Chain, drives: Drives) -> str:
    x, y, z = chain.gravity
    bodies, ends = [], []
    for k in range(chain.n_joints):
        place, turn = chain.fixed[k, :3, 3], quaternion_from_rotation(chain.fixed[k, :3, :3][None])[0]
        mass, com = float(chain.link_mass[k]), chain.link_com[k]
        bodies.append(
            f'<body pos="{place[0]} {place[1]} {place[2]}" quat="{turn[0]} {turn[1]} {turn[2]} {turn[3]}">'
            f'<inertial pos="{com[0]} {com[1]} {com[2]}" mass="{mass}" diaginertia="1e-4 1e-4 1e-4"/>'
            f'<joint name="j{k}" type="hinge" axis="0 0 1" frictionloss="{drives.loss[k]}" '
            f'damping="{drives.damping[k]}" armature="{drives.inertia[k]}" solreffriction="0.002 1"/>'
        )
        ends.append("</body>")
    return (
        f'<mujoco><compiler angle="radian"/><option timestep="{STEP_S}" gravity="{x} {y} {z}" '
        f'iterations="200" tolerance="1e-12"/><worldbody>{"".join(bodies)}{"".join(ends)}</worldbody></mujoco>'
    )


def driven(
    chain: Chain, drives: Drives, path: Callable[[Floats], Floats], seconds: float
) -> tuple[Floats, Floats, Floats]:
    """Move the chain along a path, and let MuJoCo say what torque the drives need for it (``mj_inverse``).

    Parameters
    ----------
    path : times (n,) to wanted angles (n, J), rad.

    Returns
    -------
    time (n,), angles (n, J), torque (n, J) : s, rad, N·m of the drives, every millisecond.
    """
    model = mujoco.MjModel.from_xml_string(_xml(chain, drives))
    data = mujoco.MjData(model)
    time = np.asarray(np.arange(round(seconds / STEP_S)) * STEP_S, dtype=np.float64)
    angles, before, after = path(time), path(time - STEP_S), path(time + STEP_S)
    torque = np.zeros_like(angles)
    for k in range(time.size):
        data.qpos[:] = angles[k]
        data.qvel[:] = (after[k] - before[k]) / (2.0 * STEP_S)
        data.qacc[:] = (after[k] - 2.0 * angles[k] + before[k]) / STEP_S**2
        mujoco.mj_inverse(model, data)
        torque[k] = data.qfrc_inverse
    return time, angles, torque
