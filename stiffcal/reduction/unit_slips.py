"""Units that pass every bound and still cannot be: load and displacement contradict them.

Metres declared as millimetres make a robot a thousand times too stiff, radians declared as degrees fold all poses into
one. Nothing in a single reading shows it; load and displacement together, over all poses, do.
"""

from __future__ import annotations

import numpy as np

from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.quantities import unit

# Industrial robots give 0.1 to 5 N/µm at the tool; machine tools begin near 20 N/µm. The softest that a whole campaign
# shows is looked at, so that a stiff direction of a single pose is no matter.
STIFFEST_N_PER_M = 2e7
# Light arms begin near 5 N/mm. What a campaign shows with its larger loads, in its stiffest direction.
SOFTEST_N_PER_M = 2e3
USUAL_N_PER_M = (5e4, 1e7)
# Below this the sensor's own noise may be all there is.
LEAST_LOAD_N = 50.0
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
    largest = float(np.nanmax(distance, initial=0.0))
    force = float(np.linalg.norm(states.wrench[:, :3], axis=1).max())
    if force < LEAST_LOAD_N or largest <= 0.0 or force < STIFFEST_N_PER_M * largest:
        return []
    stiffness = force / largest
    reason = (
        f"the largest displacement is {1e3 * largest:.3g} mm under up to {force:.3g} N: {1e-6 * stiffness:.3g} N/µm; "
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


def loads_like_thousands(states: LoadStates, place: str, file: str = "campaign.toml") -> list[str]:
    """Return a warning where deflections are too large for any robot under the loads: kN or tonnes called N.

    Parameters
    ----------
    states : load states with given deflections; others are let pass.
    place : the key of the load's unit in the manifest.
    """
    if not states.deflection_given or len(states) == 0:
        return []
    force = np.linalg.norm(states.wrench[:, :3], axis=1)
    distance = np.nanmax(np.linalg.norm(states.deflection[:, :, :3], axis=2), axis=1, initial=0.0)
    large = (force > 0.5 * force.max()) & (distance > 0.0)
    if not large.any():
        return []
    stiffest = float((force[large] / distance[large]).max())
    if stiffest >= SOFTEST_N_PER_M:
        return []
    reason = (
        f"{1e3 * float(distance.max()):.3g} mm under up to {float(force.max()):.3g} N: at most "
        f"{1e-3 * stiffest:.3g} N/mm, robots have 100 to 5000 N/mm at the tool"
    )
    return [f"{file}: {place}: {reason}; if the log holds kN, write {toml_text.pair('units', {'force': 'kN'})}"]


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
    reason = f"all angles of {poses} poses lie within {largest:.3g} degrees of zero: these look like radians"
    return [f'{file}: {place}: {reason}; if they are, write units = {{ position = "rad" }}']
