"""What would identify a parameter that the stated means do not: other means are tried, one at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.candidates import candidates_of
from stiffcal.planning.campaign.model import PlanModel

if TYPE_CHECKING:
    from stiffcal.planning.results import Remedy

# Poses that stand for what other means allow.
POSES = 60
# How much farther the load acts, m; how much larger it is.
LEVER, FACTOR = 0.2, 3.0
# What absolute places are tried with, kg and N.
PAYLOAD, PULL = 20.0, 200.0
# Of orientations where none are measured: what a tracker measures of a target of this size, m.
TARGET_SIZE = 0.1


def remedies_of(
    campaign: Campaign, plan: PlanFile, model: PlanModel, names: list[str], n_runs: int, two_sided: bool
) -> list[Remedy]:
    """Return for each parameter the other means of which any one identifies it with as many runs.

    Parameters
    ----------
    names : full names of the parameters that the stated means do not identify.
    n_runs : how many runs there are.
    two_sided : as `candidates_of` has it.
    """
    from stiffcal.planning.results import Remedy

    if not names:
        return []
    means: dict[str, list[str]] = {name: [] for name in names}
    for words, other_plan, other_model, runs in _other_means(campaign, plan, model, n_runs):
        for name in _identified(campaign, other_plan, other_model, runs, two_sided) & means.keys():
            means[name].append(words)
    return [Remedy(parameter=name, means=found) for name, found in means.items()]


def _other_means(
    campaign: Campaign, plan: PlanFile, model: PlanModel, n_runs: int
) -> Iterator[tuple[str, PlanFile, PlanModel, int]]:
    """Yield other means in words, with the plan file and model that have them, and the number of runs."""
    force, moment = plan.load.force_N, plan.load.moment_Nm
    if model.kind == "clamped":
        yield "a fixture at any possible pose", plan.model_copy(update={"fixtures": ()}), model, n_runs
        limits = {name: size and FACTOR * size for name, size in (("force_N", force), ("moment_Nm", moment))}
        larger = plan.model_copy(update={"load": plan.load.model_copy(update=limits)})
        yield f"{FACTOR:g} times the largest force and moment", larger, model, n_runs
    elif model.absolute:
        yield from _other_places(plan, model, n_runs)
    else:
        yield from _other_loads(campaign, plan, model, n_runs)
    if not model.with_rotation and model.kind != "clamped":
        noise = replace(model.noise, rotation=model.noise.rotation or model.noise.translation / TARGET_SIZE)
        yield "orientations of the target", plan, replace(model, with_rotation=True, noise=noise), n_runs
    if plan.limits_deg or plan.tracker is not None or plan.keep_out or plan.lowest_m is not None:
        anywhere = plan.model_copy(update={"limits_deg": {}, "tracker": None, "keep_out": (), "lowest_m": None})
        yield "poses beyond limits_deg, the boxes and the field of view of the tracker", anywhere, model, n_runs
    yield f"{FACTOR:g} times as many runs", plan, model, int(FACTOR * n_runs)


def _other_loads(
    campaign: Campaign, plan: PlanFile, model: PlanModel, n_runs: int
) -> Iterator[tuple[str, PlanFile, PlanModel, int]]:
    load = plan.load
    largest = load.force_N or max(load.dead_weights_kg, default=1.0) * float(np.linalg.norm(campaign.chain.gravity))
    if load.directions or load.dead_weights_kg:
        free = load.model_copy(update={"dead_weights_kg": (), "directions": (), "force_N": largest})
        yield "forces along and against every base axis", plan.model_copy(update={"load": free}), model, n_runs
    for axis, name in enumerate("xyz"):
        yield f"a load point {LEVER:g} m farther along its {name} axis", plan, _with_lever(model, axis), n_runs
    larger = load.model_copy(
        update={
            "force_N": None if load.force_N is None else FACTOR * load.force_N,
            "dead_weights_kg": tuple(FACTOR * mass for mass in load.dead_weights_kg),
        }
    )
    yield f"{FACTOR:g} times the load", plan.model_copy(update={"load": larger}), model, n_runs


def _other_places(plan: PlanFile, model: PlanModel, n_runs: int) -> Iterator[tuple[str, PlanFile, PlanModel, int]]:
    weighted = plan.load.model_copy(update={"dead_weights_kg": (PAYLOAD,)})
    with_payload = plan.model_copy(update={"load": weighted})
    yield f"a payload of {PAYLOAD:g} kg at the load point", with_payload, model, n_runs
    yield f"a payload of {PAYLOAD:g} kg, {LEVER:g} m off the load point", with_payload, _with_lever(model, 0), n_runs
    pulled = plan.load.model_copy(update={"dead_weights_kg": (), "force_N": PULL})
    loaded = plan.model_copy(update={"experiment": "load", "load": pulled})
    means = f"load runs, {PULL:g} N along every base axis, {LEVER:g} m off the load point"
    yield means, loaded, replace(_with_lever(model, 0), kind="load"), n_runs


def _with_lever(model: PlanModel, axis: int) -> PlanModel:
    """Return the model with its load point farther along an axis of its frame."""
    shift = np.eye(4)
    shift[axis, 3] = LEVER
    point = model.setup.wrench_point
    moved = replace(model.setup, wrench_point=replace(point, transform=point.transform @ shift))
    return replace(model, setup=moved)


def _identified(campaign: Campaign, plan: PlanFile, model: PlanModel, n_runs: int, two_sided: bool) -> set[str]:
    """Return the parameters that the best runs with these means identify."""
    from stiffcal.planning.campaign.scenarios import known_information
    from stiffcal.planning.choice import LARGEST_RELATIVE, choose_runs
    from stiffcal.planning.criterion import Criterion

    few = plan.model_copy(update={"candidates": min(plan.candidates, POSES)})
    try:
        candidates = candidates_of(campaign, few, model, two_sided)
        information = model.information(candidates)
    except InputError as error:
        if error.code not in (FaultCode.POSE_UNREACHABLE, FaultCode.NO_BALANCE):
            raise
        return set()
    choice = choose_runs(
        information.factors, n_runs, Criterion.DETERMINANT, known_information(model, information),
        limit=max(plan.repeats, -(-n_runs // len(candidates.joints))), nonlinear=information.nonlinear,
    )  # fmt: skip
    if choice is None:
        return set()
    relative = np.full(len(information.names), np.inf)
    relative[choice.free] = choice.design.course[-1]
    known = choice.identified & (relative <= LARGEST_RELATIVE)
    return {name for name, is_known in zip(information.names, known, strict=True) if is_known}
