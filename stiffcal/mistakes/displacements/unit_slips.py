"""Units that pass every bound and still cannot be: load and displacement contradict them.

Metres declared as millimetres make a robot a thousand times too stiff, radians declared as degrees fold all poses into
one. Nothing in a single reading shows it; load and displacement together, over all poses, do.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.robot_classes import RobotClass, typical_compliance
from stiffcal.quantities import unit
from stiffcal.quantity import LINEAR_STIFFNESS
from stiffcal.wording import in_unit, length, significant

# Industrial robots give 0.1 to 5 N/µm at the tool; machine tools begin near 20 N/µm. The softest that a whole campaign
# shows is looked at, so that a stiff direction of a single pose is no matter.
STIFFEST_N_PER_M = 2e7
USUAL_N_PER_M = (5e4, 1e7)
# What kN are in N, within which the two limits lie.
KILO = 1e3
# Below this the sensor's own noise may be all there is.
LEAST_LOAD_N = 50.0
# Of the largest load: play and noise are a small part of what such loads move.
LARGE_LOAD = 0.5
# Angles of several poses, of several joints, all within ±2π "degrees": nobody calibrates a robot in one pose only.
LEAST_POSES, LEAST_JOINTS, LEAST_MOVED_DEG = 4, 3, 0.2


def check_displacement_unit(states: LoadStates, declared: str, place: str, file: str = "campaign.toml") -> list[Fault]:
    """Return a fault where given deflections are too small for any robot under the loads that made them.

    Parameters
    ----------
    states : load states with given deflections; others are let pass (kinematics shows their unit).
    declared : the unit of translation in the manifest.
    place : its key.
    """
    if not states.deflection_given or len(states) == 0:
        return []
    # a body nearer the base than the load may well stand still
    outer = [k for k, target in enumerate(states.setup.targets) if target.body >= states.setup.wrench_point.body]
    distance = np.linalg.norm(states.deflection[:, outer, :3], axis=2)
    displaced = np.fmax.reduce(distance, axis=1, initial=0.0)
    forces = np.linalg.norm(states.wrench[:, :3], axis=1)
    force, largest = float(forces.max()), float(displaced.max())
    if force < LEAST_LOAD_N or largest <= 0.0:
        return []
    stiffness, loaded = force / largest, forces >= LEAST_LOAD_N
    # one row in another unit is not the table's: the usual loads have to be as far from what robots have
    is_usual = float(np.median(forces[loaded])) >= STIFFEST_N_PER_M * float(np.median(displaced[loaded]))
    if stiffness < STIFFEST_N_PER_M or not is_usual:
        return []
    reason = (
        f"the largest displacement is {length(largest)} under up to {significant(force)} N: "
        f"{in_unit(stiffness, LINEAR_STIFFNESS.usual)}; "
        "robots have 0.1 to 5 N/µm at the tool"
    )
    factor = unit(declared, "translation").factor
    low, high = USUAL_N_PER_M
    fitting = [
        name for name in ("m", "mm", "um") if low <= stiffness * factor / unit(name, "translation").factor <= high
    ]
    if not fitting:
        return [
            Fault(
                FaultCode.UNIT_IMPLAUSIBLE,
                file,
                place,
                reason,
                "correct units.translation, or units.force of the wrench",
            )
        ]
    return [
        Fault(
            FaultCode.UNIT_IMPLAUSIBLE,
            file,
            place,
            reason,
            f"write {toml_text.pair('units', {'translation': fitting[0]})} if that is what was logged",
        )
    ]


def loads_like_thousands(states: LoadStates, chain: Chain, place: str, file: str = "campaign.toml") -> list[str]:
    """Return a warning where deflections are too large for any robot under the loads: kN or tonnes called N.

    The softest drives, those of light arms, give the most in this geometry under the loads in N; the stiffest, those
    of heavy robots, the least under the same numbers in kN. The limit is the geometric mean of the two: it is a factor
    of seven from either, and usual compliances are good to three.

    Parameters
    ----------
    states : load states with given deflections; others are let pass, as are robots with prismatic joints, of whose
        guides no usual compliance is known.
    chain : the robot. place : the key of the load's unit in the manifest.
    """
    if not states.deflection_given or len(states) == 0 or chain.prismatic.any():
        return []
    force = np.linalg.norm(states.wrench[:, :3], axis=1)
    distance = np.nan_to_num(np.linalg.norm(states.deflection[:, :, :3], axis=2))
    light, heavy = (_moved_by_drives(states, chain, robot_class) for robot_class in ("light", "heavy"))
    large = (force[:, None] > LARGE_LOAD * force.max()) & (distance > 0.0) & (light > 0.0)
    if not large.any() or np.any(distance[large] ** 2 <= KILO * light[large] * heavy[large]):
        return []
    softer = float((distance[large] / light[large]).min())
    reason = (
        f"{length(float(distance.max()))} under up to {significant(float(force.max()))} N: "
        f"{significant(softer)} times what "
        "even the drives of light arms give, or more"
    )
    return [f"{file}: {place}: {reason}; if the log holds kN, write {toml_text.pair('units', {'force': 'kN'})}"]


def _moved_by_drives(states: LoadStates, chain: Chain, robot_class: RobotClass) -> Floats:
    """Return (n, B) m, how far the loads move each target of a robot with the usual drives of a class."""
    angles = chain.model_angles(states.joints)
    compliance = np.array([typical_compliance(robot_class, joint + 1) for joint in range(chain.n_joints)])
    _, axes = attached_poses(chain, angles, states.setup.wrench_axes)
    wrench = np.einsum("nij,nkj->nki", axes, states.wrench.reshape(-1, 2, 3)).reshape(-1, 6)
    drives = jacobians(chain, angles, states.setup.wrench_point) @ chain.drive_axes
    turn = compliance * np.einsum("nij,ni->nj", drives, wrench)
    moved = [
        np.einsum("nij,nj->ni", jacobians(chain, angles, target)[:, :3] @ chain.drive_axes, turn)
        for target in states.setup.targets
    ]
    return np.asarray(np.linalg.norm(np.stack(moved, axis=1), axis=2))


def angles_like_radians(states: LoadStates, place: str, file: str = "campaign.toml") -> list[str]:
    """Return a warning where all angles declared in degrees are so small that they may be radians.

    Parameters
    ----------
    states : load states with given deflections; others are let pass (kinematics shows the unit of their angles).
    place : the key of the unit in the manifest.
    """
    if not states.deflection_given or len(states) == 0 or not states.setup.targets:
        return []
    degrees = np.degrees(states.joints)
    largest = float(np.abs(degrees).max())
    poses = len(np.unique(np.round(degrees, 2), axis=0))
    joints = int((np.ptp(degrees, axis=0) > LEAST_MOVED_DEG).sum())
    if largest > 2.0 * np.pi or poses < LEAST_POSES or joints < LEAST_JOINTS:
        return []
    reason = f"all angles of {poses} poses lie within {significant(largest)} degrees of zero: these look like radians"
    return [f'{file}: {place}: {reason}; if they are, write units = {{ position = "rad" }}']
