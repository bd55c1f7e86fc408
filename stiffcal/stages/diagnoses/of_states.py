"""What is missing from a campaign's model of load states, with what the campaign knows."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.diagnosis.answers.results import DiagnoseResult, SeparatingMeasurement, UntestableEffect
from stiffcal.stages.experiments import robot_to_fit
from stiffcal.stages.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.judgement.diagnosed import DiagnosedStates

PAIRS_PLANNED = 3
"""Look-alikes for which a measurement is sought that separates them from the first missing effect."""


def diagnose_now(data: Ingested, loss: str, context: RunContext, doubt: bool = True) -> DiagnosedStates:
    """Judge a campaign's load states, the user's own effects included, without looking at the store.

    Parameters
    ----------
    data : the campaign.
    loss : of the fit.
    context : progress, threads.
    doubt : whether runs and single readings may be off.
    """
    from stiffcal.identification.fitting.identify import Settings
    from stiffcal.judgement.diagnosed import diagnose_states
    from stiffcal.model.assembled.assembly import fixed_parameters
    from stiffcal.model.catalogue.campaign_effects import all_effects

    settings = Settings(loss=loss, fixed=fixed_parameters(data.campaign.model))
    catalogue, _ = all_effects(data.campaign)
    robot = robot_to_fit(data)
    return diagnose_states(data.states, robot, catalogue, settings, context.progress, doubt, context.jobs)


def diagnosis_of(data: Ingested, found: DiagnosedStates) -> DiagnoseResult:
    """Return the result of a judgement, with what the campaign's own effects need."""
    from stiffcal.judgement.document import diagnosis_result
    from stiffcal.model.catalogue.campaign_effects import all_effects

    _, untrusted = all_effects(data.campaign)
    diagnosis = diagnosis_result(found)
    return replace(
        diagnosis,
        not_tried=[*diagnosis.not_tried, *(UntestableEffect(effect.effect, effect.needs) for effect in untrusted)],
        next_measurement=_next_measurement(data, found),
    )


def _next_measurement(data: Ingested, found: DiagnosedStates) -> SeparatingMeasurement | None:
    """Return the pose and load that would separate the first missing effect from the nearest look-alike it can.

    None where no load would show a difference beyond the noise: creep that is over at once is compliance; where joints
    were clamped alone, whose poses and loads the fixture decides on; and of poses under the robot's own weight, where
    no load was applied whose size could be taken.
    """
    import numpy as np

    states, scan = found.kept_states, found.first
    if states.clamped.all() or not np.any(states.wrench):
        return None

    from stiffcal.diagnosis.refits.heldout_error import with_values_of
    from stiffcal.diagnosis.scans.ranking import effect_at
    from stiffcal.identification.answers.document import finite
    from stiffcal.judgement.document import look_alike_pairs
    from stiffcal.model.assembled.assembly import fixed_parameters
    from stiffcal.planning.rivals import RivalModel
    from stiffcal.planning.separate import KnownPair, separating_measurement

    fixed = fixed_parameters(data.campaign.model)
    noise = (scan.fit.noise.translation or scan.fit.noise.gauge) if scan.fit.noise is not None else 0.0
    for pair in look_alike_pairs(found, PAIRS_PLANNED):
        first, second = (with_values_of(scan, trial) for trial in pair)
        known = None
        if scan.fit.noise is not None and scan.fit.whitening is not None:
            turns = bool(np.isfinite(states.rotation).any())
            one, other = (
                RivalModel.of_data(robot, scan.fit.data, scan.fit.whitening, fixed) for robot in (first, second)
            )
            known = KnownPair(one, other, scan.fit.noise, turns, fixed)
        separation = separating_measurement(
            first, second, states.setup, states.joints, states.wrench, noise, known=known
        )
        if separation is not None and separation.difference >= noise:
            return SeparatingMeasurement(
                pose_deg=data.campaign.chain.printed_positions(separation.joints).tolist(),
                load=separation.wrench.tolist(),
                separates=[effect_at(trial.candidate) for trial in pair],
                gain=finite(separation.gain),
                difference_m=separation.difference,
            )
    return None
