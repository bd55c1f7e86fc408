"""Friction of free joints by MuJoCo: dry friction and damping of hinges that are led through a motion."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats


def friction_torque(velocity: Floats, coulomb: float, viscous: float) -> Floats:
    """Return (n,) N·m: what a motor must do to turn a hinge at velocities (n,), rad/s, without inertia or weight."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        f"""
        <mujoco>
          <option gravity="0 0 0" jacobian="dense" tolerance="1e-12"/>
          <worldbody><body><joint type="hinge" axis="0 0 1" damping="{viscous!r}" frictionloss="{coulomb!r}"
            solreffriction="-1e7 -1e7" solimpfriction="0.9999 0.9999 1e-6"/>
          <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>
        </mujoco>"""
    )
    data = mujoco.MjData(model)
    torque = np.empty_like(velocity)
    for k, speed in enumerate(velocity):
        data.qvel[0], data.qacc[0] = speed, 0.0
        mujoco.mj_inverse(model, data)
        torque[k] = data.qfrc_inverse[0]
    return torque
