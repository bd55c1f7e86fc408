"""What is possible in the cell, from plan.toml: limits, boxes, the tracker, and the loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.tracker import tracker_of
from stiffcal.reduction.logs.reading_bounds import LARGEST_FORCE_N

if TYPE_CHECKING:
    from stiffcal.planning.candidates import Cell


# Of the largest force: linear springs need no more; play and knees show at small loads of both senses, a memory on the
# way back. A crossing is narrow: runs of a tenth of the force are offered as well.
ONE_SIDED = (0.5, 1.0)
SCALES = (1.0, 0.3, 0.1)
TWO_SIDED = (0.1, 0.25, 0.5, 1.0, 0.5, 0.25, 0.0, -0.1, -0.25, -0.5, -1.0, -0.5, -0.25)


def cell_of(campaign: Campaign, plan: PlanFile) -> Cell:
    """Return what limits poses.

    Raises
    ------
    InputError : a joint is not known, no angle of a joint is left, a box is empty, or a direction is zero.
    """
    from stiffcal.planning.candidates import Cell

    chain = campaign.chain
    limits = chain.limits.copy()
    for name, interval in plan.limits_deg.items():
        if name not in chain.joint_names:
            mend = f"joints: {', '.join(chain.joint_names)}"
            raise InputError.at(FaultCode.JOINT_UNKNOWN, PLAN_FILE, "limits_deg", f"unknown joint {name}", mend)
        own = np.radians(interval)
        k = chain.joint_names.index(name)
        limits[k] = max(limits[k, 0], own[0]), min(limits[k, 1], own[1])
    # A joint without limits turns once at most.
    limits = np.where(np.isfinite(limits), limits, np.array([-np.pi, np.pi]))
    limits = limits + np.radians(plan.margin_deg) * np.array([1.0, -1.0])
    for name, (low, high) in zip(chain.joint_names, limits, strict=True):
        if low >= high:
            reason = f"with margin_deg = {plan.margin_deg:g} no angle of {name} is left"
            mend = "widen its limits_deg, or lower margin_deg"
            raise InputError.at(FaultCode.POSE_UNREACHABLE, PLAN_FILE, f"limits_deg.{name}", reason, mend)
    for number, box in enumerate(plan.keep_out, start=1):
        if not all(low < high for low, high in zip(box.min_m, box.max_m, strict=True)):
            mend = "write the lower corner as min_m, the upper one as max_m"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, f"keep_out {number}", "the box is empty", mend)
    boxes = np.array([[box.min_m, box.max_m] for box in plan.keep_out]).reshape(-1, 2, 3)
    return Cell(limits, boxes, plan.link_radius_m, plan.lowest_m, tracker_of(campaign, plan))


def loads_of_places(campaign: Campaign, plan: PlanFile) -> Floats:
    """Return (D, 1, 6) what absolute places are read under: the robot's own weight, and each payload, N, base axes.

    Raises
    ------
    InputError : a force is stated, which absolute places do not have.
    """
    load = plan.load
    if load.force_N is not None or load.directions:
        reason = "absolute poses are measured under the own weight of the robot and payloads"
        mend = 'leave force_N and directions out, or write experiment = "load"'
        raise InputError.at(FaultCode.KEY_CONFLICT, PLAN_FILE, "load.force_N", reason, mend)
    forces = np.array([0.0, *load.dead_weights_kg])[:, None, None] * campaign.chain.gravity
    return np.concatenate([forces, np.zeros_like(forces)], axis=2)


def load_steps(campaign: Campaign, plan: PlanFile, two_sided: bool = False) -> Floats:
    """Return (D, K, 6) the load steps of every direction and size, N, base axes, at the load point.

    Parameters
    ----------
    two_sided : where plan.toml names no steps, in both senses, up and down, and as small loads too.

    Raises
    ------
    InputError : no load is stated, or weights and forces are.
    """
    load = plan.load
    if load.dead_weights_kg:
        if load.force_N is not None or load.directions:
            mend = "keep dead_weights_kg, or force_N with directions"
            reason = "dead weights have one direction and their own force"
            raise InputError.at(FaultCode.KEY_CONFLICT, PLAN_FILE, "load.dead_weights_kg", reason, mend)
        masses = np.array(load.dead_weights_kg)
        masses = np.concatenate([masses, masses[-2::-1]]) if two_sided else masses
        forces = masses[None, :, None] * campaign.chain.gravity
    elif load.force_N is None:
        reason = "the largest force that can be applied is not stated"
        mend = "add [load] with force_N = 500, or dead_weights_kg = [20, 40], or give --force 500"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "load.force_N", reason, mend)
    else:
        if not load.force_N <= LARGEST_FORCE_N:
            reason = f"{load.force_N:g} N is more than any robot holds"
            raise InputError.at(FaultCode.READING_IMPLAUSIBLE, PLAN_FILE, "load.force_N", reason, "give the force in N")
        steps = np.array(load.steps or (TWO_SIDED if two_sided else ONE_SIDED))
        if not steps.any():
            mend = "write shares of the largest force, as [0.5, 1.0]"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, "load.steps", "all steps are unloaded", mend)
        # steps of both senses make a direction and its opposite one run
        axes = np.eye(3) if (steps < 0.0).any() else np.concatenate([np.eye(3), -np.eye(3)])
        directions = np.array(load.directions or axes, dtype=np.float64)
        length = np.linalg.norm(directions, axis=1, keepdims=True)
        if not (length > 0.0).all():
            mend = "write directions in base axes, of any length"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, "load.directions", "a direction is zero", mend)
        ladders = steps * (np.array(SCALES)[:, None] if two_sided and not load.steps else np.ones((1, 1)))
        forces = load.force_N * ladders[:, None, :, None] * (directions / length)[:, None]
        forces = forces.reshape(-1, len(steps), 3)
    forces = np.tile(forces, (1, load.cycles, 1))
    return np.concatenate([forces, np.zeros_like(forces)], axis=2)
