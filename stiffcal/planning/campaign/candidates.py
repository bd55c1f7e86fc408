"""The runs that a plan chooses from, and the ways between those that it chose."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import PLANNED
from stiffcal.planning.campaign.means import cell_of, load_steps, loads_of_places
from stiffcal.planning.campaign.model import PlanModel
from stiffcal.planning.campaign.pairs import FEWER, Candidates

if TYPE_CHECKING:
    from stiffcal.measurements.load_states import Attachment
    from stiffcal.planning.candidates import Cell
    from stiffcal.planning.results import RunToMeasure


# Poses that are drawn near the chosen ones to refine joint angles: near each, and near all of few.
NEAR_EACH, NEAR_ALL = 12, 240


def candidates_of(campaign: Campaign, plan: PlanFile, model: PlanModel, two_sided: bool = False) -> Candidates:
    """Return possible poses, each with every direction of load.

    Parameters
    ----------
    two_sided : load steps in both senses, up and down, where plan.toml names no steps (`load_steps`).

    Raises
    ------
    InputError : no pose is possible, or plan.toml is wrong.
    """
    from stiffcal.planning.candidates import possible_poses

    cell = cell_of(campaign, plan)
    tips = tips_of(campaign, model)
    joints, rejected = possible_poses(campaign.chain, cell, model.setup.targets[0], tips, plan.candidates, plan.seed)
    if not len(joints):
        counts = {
            "keep_out": (
                rejected.collision,
                "a link enters a keep-out box, goes below lowest_m or collides with another link",
            ),
            "tracker.cone_deg": (
                rejected.out_of_view,
                "the measured frame is outside the field of view of the tracker",
            ),
            "tracker.acceptance_deg": (rejected.reflector, "the reflector is turned away from the tracker"),
            "tracker.position_m": (rejected.obstructed, "a link or a keep-out box blocks the tracker beam"),
        }
        place, (count, why) = max(counts.items(), key=lambda entry: entry[1][0])
        reason = f"none of {rejected.drawn} poses within the joint limits is possible: in {count} of them {why}"
        raise InputError.at(
            FaultCode.POSE_UNREACHABLE, PLAN_FILE, place, reason, "correct plan.toml, or widen limits_deg"
        )
    if model.kind == "clamped":
        from stiffcal.planning.campaign.clamped import clamped_runs

        return clamped_runs(campaign, plan, model, joints)
    loads = loads_of_places(campaign, plan) if model.absolute else load_steps(campaign, plan, two_sided)
    n, directions = len(joints), len(loads)
    PLANNED.check(n * directions * loads.shape[1], PLAN_FILE, "candidates", FEWER)
    return Candidates(np.repeat(joints, directions, axis=0), np.tile(loads, (n, 1, 1)))


def refined_around(
    campaign: Campaign, plan: PlanFile, model: PlanModel, chosen: Candidates, spread: float
) -> Candidates:
    """Return runs with the chosen ones and possible poses near them, under the same loads."""
    from stiffcal.planning.candidates import near_poses

    if chosen.turn is not None:
        return chosen  # a fixture stands where it stands
    near, source = near_poses(
        campaign.chain, cell_of(campaign, plan), model.setup.targets[0], tips_of(campaign, model), chosen.joints,
        spread, max(NEAR_EACH, NEAR_ALL // len(chosen.joints)), plan.seed,
    )  # fmt: skip
    return chosen + Candidates(near, chosen.wrench[source])


def tips_of(campaign: Campaign, model: PlanModel) -> tuple[Attachment, ...]:
    """Return the frames on the flange that the last capsules reach to."""
    frames = (model.setup.wrench_point, *model.setup.targets)
    return tuple(frame for frame in frames if frame.body == campaign.chain.n_joints + 1)


def with_ways(
    campaign: Campaign, cell: Cell, model: PlanModel, poses: Floats, runs: list[RunToMeasure]
) -> tuple[list[RunToMeasure], list[list[str]]]:
    """Return the runs with the poses to drive through before each, and the pairs between which no way is free."""
    from stiffcal.planning.moves import ways_between

    joints = np.stack([run.joints for run in runs])
    ways = ways_between(campaign.chain, cell, tips_of(campaign, model), joints, poses)
    blocked = [[runs[k].id, runs[k + 1].id] for k, way in enumerate(ways) if way is None]
    reached = [replace(run, approach=way) if way is not None else run for run, way in zip(runs[1:], ways, strict=True)]
    return [runs[0], *reached], blocked
