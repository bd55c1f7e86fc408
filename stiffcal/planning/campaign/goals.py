"""What a plan is for: stiffness, predictions along a path or in a region, look-alikes, or several of them in a mix."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.candidates import tips_of
from stiffcal.planning.campaign.means import cell_of
from stiffcal.planning.campaign.model import PlanModel
from stiffcal.planning.campaign.pairs import Candidates

if TYPE_CHECKING:
    from stiffcal.planning.candidates import Cell

STIFFNESS, LOOK_ALIKES, REGION = "stiffness", "look-alikes", "region"
# Poses that stand for a region, and for all that is possible.
AREA_POSES = 100
# Poses that are drawn to find those of a region, at most.
DRAWN = 20000


@dataclass(frozen=True)
class WantedGoal:
    """One thing that runs are chosen for."""

    name: str
    """"stiffness", "look-alikes", "region", or a CSV of poses and loads to predict at."""
    weight: float
    """In the mix."""

    @property
    def is_prediction(self) -> bool:
        """Whether an error of prediction counts."""
        return self.name not in (STIFFNESS, LOOK_ALIKES)


@dataclass(frozen=True)
class PredictedArea:
    """Where the error of prediction is stated."""

    joints: Floats
    """(n, L) rad."""
    wrench: Floats
    """(n, 6) N, N·m."""
    name: str
    """The path's file, "region", or "random poses"."""
    doubts: tuple[str, ...] = ()
    """What was read of the path's file and may not have been meant, in words."""


def wanted_goals(purpose: str, with_rivals: bool) -> list[WantedGoal]:
    """Return the goals of ``--for``: one, or several with weights, as "stiffness=2, path.csv=1".

    Parameters
    ----------
    purpose : as the user wrote it.
    with_rivals : rivals are named: alone they are the goal where nothing else is asked for.

    Raises
    ------
    InputError : a weight is no positive number, or a goal is named twice.
    """
    goals = []
    for text in purpose.split(","):
        name, _, weight = text.strip().rpartition("=") if "=" in text else (text.strip(), "", "1")
        try:
            size = float(weight)
        except ValueError:
            size = 0.0
        if not name.strip() or not 0.0 < size < np.inf:
            mend = 'write goals with positive weights, as --for "stiffness=2, path.csv=1"'
            raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--for", f"{text!r} is not a goal", mend)
        goals.append(WantedGoal(name.strip(), size))
    names = [goal.name for goal in goals]
    if len(set(names)) < len(names):
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--for", "a goal is named twice", "state it once")
    if sum(goal.is_prediction for goal in goals) > 1:
        mend = "put the poses of both into one table"
        reason = "the error of prediction is requested for two sets of poses"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--for", reason, mend)
    if with_rivals and names == [STIFFNESS]:
        return [WantedGoal(LOOK_ALIKES, 1.0)]
    if with_rivals and LOOK_ALIKES not in names:
        return [*goals, WantedGoal(LOOK_ALIKES, 1.0)]
    return goals


def area_of(
    goals: list[WantedGoal], campaign: Campaign, plan: PlanFile, model: PlanModel, candidates: Candidates
) -> PredictedArea:
    """Return where the error of prediction is stated: of the goal, else of the region, else of random poses.

    Raises
    ------
    InputError : a table cannot be read, or no pose is in the region.
    """
    named = next((goal.name for goal in goals if goal.is_prediction), None)
    if named is not None and named != REGION:
        from stiffcal.compensation.load_table import read_load_table

        chain = campaign.chain
        table = read_load_table(Path(named), chain.joint_names, joints_needed=True, prismatic=chain.prismatic_names)
        return PredictedArea(table.joints, table.wrench, Path(named).name, table.doubts)
    if named == REGION or plan.region is not None:
        return _region(campaign, plan, model, candidates)
    pick = np.linspace(0, len(candidates.joints) - 1, min(AREA_POSES, len(candidates.joints))).astype(np.int64)
    return PredictedArea(candidates.joints[pick], _largest(candidates.wrench[pick]), "random poses")


def _region(campaign: Campaign, plan: PlanFile, model: PlanModel, candidates: Candidates) -> PredictedArea:
    """Return poses whose target lies in the region, each with a load."""
    from stiffcal.planning.candidates import Region, poses_in_region

    if plan.region is None:
        reason, mend = "no region is stated", "add [region] with min_m = [1.2, -0.5, 0.3] and max_m = [1.8, 0.5, 0.9]"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "region", reason, mend)
    if not all(low < high for low, high in zip(plan.region.min_m, plan.region.max_m, strict=True)):
        mend = "write the lower corner as min_m, the upper one as max_m"
        raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, "region", "the box is empty", mend)
    cell: Cell = cell_of(campaign, plan)
    region = Region(np.array(plan.region.min_m), np.array(plan.region.max_m))
    target, tips = model.setup.targets[0], tips_of(campaign, model)
    joints = poses_in_region(campaign.chain, cell, target, tips, region, AREA_POSES, DRAWN, plan.seed)
    if not len(joints):
        reason = f"none of {DRAWN} poses within the limits puts {model.setup.target_names[0]} into it"
        raise InputError.at(FaultCode.POSE_UNREACHABLE, PLAN_FILE, "region", reason, "correct it, or widen limits_deg")
    if plan.region.force_N is not None:
        axes = np.concatenate([np.eye(3), -np.eye(3)])
        loads = np.concatenate([plan.region.force_N * axes, np.zeros((6, 3))], axis=1)
    else:
        loads = np.unique(_largest(candidates.wrench), axis=0)
    return PredictedArea(joints, loads[np.arange(len(joints)) % len(loads)], REGION)


def _largest(wrench: Floats) -> Floats:
    """Return (N, 6) the load step of the largest force of runs (N, K, 6)."""
    size = np.linalg.norm(wrench[:, :, :3], axis=2)
    return np.asarray(wrench[np.arange(len(wrench)), np.argmax(size, axis=1)])
