"""Where the tracker of a plan stands, and what is to be known of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.frames import resolve_frames
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.planning.candidates import Tracker

FRAME = "tracker"
# Places of the tracker in plan.toml and campaign.toml that are further apart are two different places, m.
APART = 0.1


def tracker_of(campaign: Campaign, plan: PlanFile) -> Tracker | None:
    """Return what the tracker can measure; None where plan.toml has none.

    Raises
    ------
    InputError : its place is not stated, or a direction is zero.
    """
    from stiffcal.planning.candidates import Tracker

    table = plan.tracker
    if table is None:
        return None
    for key, vector in (("axis", table.axis), ("reflector_axis", table.reflector_axis)):
        if vector is not None and not any(vector):
            mend = "write a direction, of any length"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, f"tracker.{key}", "all zero", mend)
    position = _place_of_frame(campaign) if table.position_m is None else np.array(table.position_m)
    if position is None:
        reason = f"the position of the tracker is not stated, and {MANIFEST_FILE} has no position of [frames.{FRAME}]"
        mend = "write position_m = [3.5, -1.0, 0.5], base axes"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "tracker.position_m", reason, mend)
    return Tracker(
        position,
        None if table.axis is None else np.array(table.axis),
        float(np.radians(table.cone_deg)),
        None if table.reflector_axis is None else np.array(table.reflector_axis),
        float(np.radians(table.acceptance_deg)),
    )


def tracker_warnings(campaign: Campaign, plan: PlanFile) -> list[str]:
    """Return what plan.toml leaves open of the tracker, or has unlike campaign.toml."""
    table = plan.tracker
    if table is None:
        return []
    warnings = []
    if table.axis is None and table.reflector_axis is None:
        warnings.append(
            "[tracker] has neither axis nor reflector_axis: no pose is excluded by its field of view or by the "
            "reflector's acceptance, only those with a blocked beam"
        )
    frame = _place_of_frame(campaign)
    if table.position_m is not None and frame is not None:
        distance = float(np.linalg.norm(np.array(table.position_m) - frame))
        if distance > APART:
            warnings.append(
                f"[tracker] position_m is {distance:.2f} m away from [frames.{FRAME}] of {MANIFEST_FILE}: "
                "position_m is used"
            )
    return warnings


def _place_of_frame(campaign: Campaign) -> Floats | None:
    """Return (3,) the origin of the tracker's frame, base axes, m; None where it is not written or not on the base."""
    frame = campaign.manifest.frames.get(FRAME)
    if frame is None or "xyz_m" not in frame.model_fields_set:
        return None
    attached = resolve_frames(campaign.manifest, campaign.chain)[FRAME]
    return attached.transform[:3, 3] if attached.body == 0 else None
