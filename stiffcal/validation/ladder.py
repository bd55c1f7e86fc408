"""The ladder of absolute places: from the nominal robot to the present model, every rung fitted to the same rows."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.model.assembled.base_tilt import BaseTilt
from stiffcal.model.assembled.measured_frames import FramePosition
from stiffcal.validation.distance_results import Distances, LadderStep
from stiffcal.validation.distances import distances_of, summary_of

if TYPE_CHECKING:
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.model.assembled.composite import CompliantRobot

RUNGS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("frames", ()),
    ("offsets", ("joint-offset",)),
    ("geometry", ("link-geometry",)),
    ("springs", ("link-geometry", "joint-compliance")),
)
"""Each rung's effects, on all joints; the frames that the manifest leaves to be found are in all of them, the turn of
the base against gravity where a law answers weight.
"""
MODEL = "model"
"""The rung of the present model, where it is none of the others."""


def ladder_of(states: LoadStates, fit: Fit, own: Distances) -> list[LadderStep]:
    """Return the rungs, from the nominal robot with its frames where registration put them.

    Parameters
    ----------
    states : the campaign's absolute places.
    fit : of the present model. own : its distances.
    """
    from stiffcal.identification.fitting.identify import Settings, identify_parameters

    nominal = summary_of(fit.data.measured, fit.data)
    rms = None if nominal is None else nominal.rms
    mean = None if nominal is None else nominal.mean
    steps = [LadderStep("nominal", 0, rms, rms, rms, mean, mean)]
    present = _effects(fit.robot)
    for name, effects in RUNGS:
        robot = _rung(fit.robot, effects)
        if _effects(robot) == present:
            steps.append(_step(name, fit, own))
            continue
        rung = identify_parameters(states, robot, Settings(noise=fit.noise))
        distances = distances_of(rung)
        if distances is not None:
            steps.append(_step(name, rung, distances))
    if present not in [_effects(_rung(fit.robot, effects)) for _, effects in RUNGS]:
        steps.append(_step(MODEL, fit, own))
    return steps


def _step(name: str, fit: Fit, distances: Distances) -> LadderStep:
    random, region = distances.heldout_random, distances.heldout_region
    return LadderStep(
        name,
        sum(parameter.std is not None or parameter.at_bound for parameter in fit.parameters),
        distances.fit.rms,
        None if random is None else random.rms,
        None if region is None else region.rms,
        None if region is None else region.mean,
        None if random is None else random.mean,
    )


def _rung(robot: CompliantRobot, effects: tuple[str, ...]) -> CompliantRobot:
    """Return the robot with its frames and these effects on all joints alone, without values."""
    from stiffcal.model.assembled.composite import PlacedEffect
    from stiffcal.model.catalogue.catalogue import built_in_effects
    from stiffcal.model.effect import Kind

    catalogue = built_in_effects()
    gives = any(catalogue[name].kind is Kind.NODE_LAW for name in effects)
    frames = [
        replace(placed, values={})
        for placed in robot.placed
        if isinstance(placed.effect, FramePosition) or (gives and isinstance(placed.effect, BaseTilt))
    ]
    added = [
        PlacedEffect(catalogue[name].at(place, robot.chain), place)
        for name in effects
        for place in catalogue[name].places(robot.chain)
    ]
    return replace(robot, placed=(*frames, *added))


def _effects(robot: CompliantRobot) -> set[str]:
    return {placed.parameter_name("") for placed in robot.placed}
