"""Joint springs in balance, all in dual quaternions (Li et al. 2019, paper 003, section 3).

The virtual work of a wrench in the eight components of a pose is f̂ · δq̂ with f̂ = Pᵀ F (P from
`displacement_from_change`), so that the joints' torques are τ = (∂q̂/∂θ)ᵀ f̂ (eq. 13 to 18). Differentiated once more
they give the complementary stiffness K_C = ∂τ/∂θ (eq. 26 to 28), and the balance is solved with K − K_C (eq. 29), here
as 1 − C K_C, which also exists for joints that do not give. No matrix of a pose or of a Jacobian takes part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.dual_quaternions import (
    attached_duals,
    displacement_from_change,
    dual_chain,
    dual_hessian,
    dual_jacobian,
    joint_lines,
)
from stiffcal.quaternions import rotation_from_quaternion

# The rounding of angles, relative to the largest, and to a radian for smaller ones.
TOLERANCE = 3e-16
MAX_STEPS = 50


@dataclass(frozen=True)
class PointLoad:
    """A wrench on a body."""

    at: Attachment
    """Where it acts; the moment is about that frame's origin."""
    axes: Attachment
    """The frame whose axes the components are in; it turns with its body."""
    wrench: Floats
    """(n, 6) force and moment, N and N·m."""


def weights_of(chain: Chain, setup: MeasurementSetup, n: int) -> list[PointLoad]:
    """Return the weights of links and tool as loads on n states."""
    base = Attachment(0, np.eye(4))
    masses = [(k + 1, float(chain.link_mass[k]), chain.link_com[k]) for k in range(chain.n_joints)]
    masses.append((chain.n_joints + 1, setup.tool_mass, setup.tool_com))
    loads = []
    for body, mass, centre in masses:
        if mass > 0.0 and np.any(chain.gravity):
            place = np.eye(4)
            place[:3, 3] = centre
            wrench = np.zeros((n, 6))
            wrench[:, :3] = mass * chain.gravity
            loads.append(PointLoad(Attachment(body, place), base, wrench))
    return loads


def reading_as_load(setup: MeasurementSetup, wrench: Floats) -> PointLoad:
    """Return the wrench as read, (n, 6), as a load."""
    return PointLoad(setup.wrench_point, setup.wrench_axes, wrench)


def joint_torques(frames: Floats, loads: Sequence[PointLoad]) -> Floats:
    """Return the loads' torques about the joints, (n, J), N·m (003, eq. 18).

    Parameters
    ----------
    frames : (n, J + 2, 8) of `dual_chain`.
    loads : what acts.
    """
    total = np.zeros((len(frames), frames.shape[1] - 2))
    for load in loads:
        force = np.einsum(
            "nab,na->nb", displacement_from_change(attached_duals(frames, load.at)), _wrench_in_base(frames, load)
        )
        total += np.einsum("nbj,nb->nj", dual_jacobian(frames, load.at), force)
    return total


def complementary_stiffness(frames: Floats, loads: Sequence[PointLoad]) -> Floats:
    """Return K_C = ∂τ/∂θ, (n, J, J), N·m/rad (003, eq. 26 to 28).

    Three parts: the pose's second derivative; the work's own change with the pose, P being linear in q̂; and loads whose
    axes turn with the robot.

    Parameters
    ----------
    frames : (n, J + 2, 8) of `dual_chain`.
    loads : what acts.
    """
    n, count = len(frames), frames.shape[1] - 2
    total = np.zeros((n, count, count))
    for load in loads:
        place, slope = attached_duals(frames, load.at), dual_jacobian(frames, load.at)
        forward, acting = displacement_from_change(place), _wrench_in_base(frames, load)
        total += np.einsum("nijb,nab,na->nij", dual_hessian(frames, load.at), forward, acting)
        along = displacement_from_change(np.swapaxes(slope, 1, 2))
        total += np.einsum("nbi,njab,na->nij", slope, along, acting)
        turning = min(load.axes.body, count)
        if turning:
            axes = joint_lines(frames)[:, :turning, 1:4]
            change = np.concatenate(
                [np.cross(axes, acting[:, None, :3]), np.cross(axes, acting[:, None, 3:])], axis=2
            )  # fmt: skip
            total[:, :, :turning] += np.einsum("nbi,nab,nja->nij", slope, forward, change)
    return total


def dual_rest(chain: Chain, compliance: Floats, angles: Floats, loads: Sequence[PointLoad]) -> Floats:
    """Return the joint angles at which springs and loads balance, (n, J), rad.

    Parameters
    ----------
    chain : J joints.
    compliance : (J, J) of the joints, rad/(N·m); diagonal but for coupled drives.
    angles : (n, J) model angles of the unloaded springs, rad.
    loads : what acts.

    Raises
    ------
    ArithmeticError : no rest is found: the load is more than the springs hold.
    """
    deflection = np.zeros_like(angles)
    # Kept from the unloaded shape: it changes by the deflection, a thousandth, and each step gains that factor.
    system = np.eye(chain.n_joints) - compliance @ complementary_stiffness(dual_chain(chain, angles), loads)
    inverse = np.linalg.inv(system)
    for _ in range(MAX_STEPS):
        frames = dual_chain(chain, angles + deflection)
        step = (inverse @ (joint_torques(frames, loads) @ compliance.T - deflection)[:, :, None])[:, :, 0]
        deflection = deflection + step
        if np.max(np.abs(step), initial=0.0) <= TOLERANCE * max(1.0, float(np.max(np.abs(angles), initial=0.0))):
            return np.asarray(angles + deflection)
    raise ArithmeticError("no equilibrium: the load exceeds what the springs can carry")


def _wrench_in_base(frames: Floats, load: PointLoad) -> Floats:
    """Return the wrench (n, 6) in base axes."""
    turn = rotation_from_quaternion(attached_duals(frames, load.axes)[:, :4])
    return np.concatenate(
        [np.einsum("nij,nj->ni", turn, load.wrench[:, :3]), np.einsum("nij,nj->ni", turn, load.wrench[:, 3:])], axis=1
    )
