"""Drives: what torque the drive of a joint carries, and which joints turn when it gives.

Of a prismatic joint torque is the force along its axis, N, and it gives by a length, m: the component of its node is
the shift along z in place of the turn about z.

A drive sits on its joint's own axis, but for robots whose axes are coupled mechanically (a parallel rod): there it
sits on the logged axis, and its give turns several model joints, δ_model = M δ_drive, while it carries τ_drive = Mᵀ τ.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Covariate, Term, joint_node
from stiffcal.model.scalar_laws import LawForm, ScalarLaw


def turned_joints(chain: Chain, joint: int) -> list[tuple[int, float]]:
    """Return (model joint, factor) for every joint that the drive of ``joint`` turns.

    Parameters
    ----------
    joint : from 1.
    """
    if not chain.mechanical.any():
        return [(joint, 1.0)]
    column = chain.drive_axes[:, joint - 1]
    return [(int(k) + 1, float(column[k])) for k in np.flatnonzero(column)]


def drive_torque(chain: Chain, wrench: Floats, joint: int) -> Floats:
    """Return (n,) the whole torque that the drive of ``joint`` carries, N·m.

    Parameters
    ----------
    wrench : (2J + 2, 6, n) what the nodes carry, node axes (`NodeLoads.wrench` or ``weight``).
    joint : from 1.
    """
    driven = turned_joints(chain, joint)
    if len(driven) == 1 and driven[0][1] == 1.0:
        return np.asarray(wrench[joint_node(driven[0][0]), chain.drive_components[driven[0][0] - 1]])
    return np.asarray(sum(factor * wrench[joint_node(k), chain.drive_components[k - 1]] for k, factor in driven))


def drive_covariate(chain: Chain, wrench: Floats, joint: int) -> Covariate:
    """Return what the drive of ``joint`` carries as a covariate; arguments as of `drive_torque`."""
    torque = drive_torque(chain, wrench, joint)
    if joint in chain.prismatic_joints:
        return Covariate(f"force on joint {joint}", "N", torque)
    return Covariate(f"torque on joint {joint}", "N·m", torque)


def drive_terms(chain: Chain, joint: int, symbol: str, value: Floats) -> tuple[Term, ...]:
    """Return the terms by which the drive of ``joint`` gives by ``amplitude × value``, rad.

    Parameters
    ----------
    joint : from 1.
    symbol : the amplitude's symbol; "" for none.
    value : (n,) what the amplitude is multiplied with.
    """
    return tuple(
        Term(joint_node(k), int(chain.drive_components[k - 1]), symbol, value if factor == 1.0 else factor * value)
        for k, factor in turned_joints(chain, joint)
    )


def drive_law(chain: Chain, joint: int, form: LawForm, *numbers: float) -> tuple[ScalarLaw]:
    """Return the law by which the drive of ``joint`` (from 1) turns under its torque, as data."""
    weights = tuple(
        (joint_node(k), int(chain.drive_components[k - 1]), factor) for k, factor in turned_joints(chain, joint)
    )
    return (ScalarLaw(form, numbers, weights, joint),)
