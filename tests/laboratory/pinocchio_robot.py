"""The same chain in pinocchio: an outside library's frames, Jacobians and weights."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain

pin: Any = pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")


def pinocchio_model(chain: Chain, tool_mass: float = 0.0, tool_com: Floats | None = None) -> Any:
    """Build pinocchio's model from the chain's fixed transforms and masses."""
    model = pin.Model()
    model.gravity.linear = chain.gravity
    joint = 0
    for k in range(chain.n_joints):
        kind = pin.JointModelPZ() if chain.prismatic[k] else pin.JointModelRZ()
        joint = model.addJoint(joint, kind, pin.SE3(chain.fixed[k]), f"joint{k + 1}")
        inertia = pin.Inertia(float(chain.link_mass[k]), chain.link_com[k], np.zeros((3, 3)))
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
    if tool_mass > 0.0 and tool_com is not None:
        model.appendBodyToJoint(joint, pin.Inertia(tool_mass, tool_com, np.zeros((3, 3))), pin.SE3(chain.flange))
    return model


def place_and_jacobian(model: Any, chain: Chain, q: Floats, frame: Attachment) -> tuple[Floats, Floats, Floats]:
    """Return position (3,), base_from_frame (3, 3) and Jacobian (6, J) of a frame on a body, base axes."""
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    body = frame.body
    joint = min(body, chain.n_joints)
    placed = pin.SE3(chain.flange) if body == chain.n_joints + 1 else pin.SE3.Identity()
    offset = placed * pin.SE3(frame.transform)
    base_from_frame = data.oMi[joint] * offset
    jacobian = np.zeros((6, model.nv))
    if joint > 0:
        own = pin.getFrameJacobian(model, data, joint, offset, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        jacobian[:] = own
    return base_from_frame.translation, base_from_frame.rotation, jacobian


def gravity_torques(model: Any, q: Floats) -> Floats:
    """Return (J,) the torques that hold the robot against its weights, N·m."""
    return np.asarray(pin.computeGeneralizedGravity(model, model.createData(), q), dtype=np.float64)
