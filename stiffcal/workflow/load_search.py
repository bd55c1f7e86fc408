"""The search of load states for missing effects, and its result with what the campaign knows."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.diagnosis.results import DiagnoseResult, SeparatingMeasurement, UntestableEffect
from stiffcal.workflow.experiments import robot_to_fit
from stiffcal.workflow.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.diagnosis.search_results import Search
    from stiffcal.model.composite import CompliantRobot


def search_now(
    data: Ingested, loss: str, context: RunContext, robot: CompliantRobot | None = None, n_searches: int = 1
) -> Search:
    """Search the catalogue, the user's own effects included, without looking at the store.

    Parameters
    ----------
    data : the campaign.
    loss : of the fit.
    context : progress.
    robot : the model; None for the campaign's.
    n_searches : how many searches of the campaign there are, this among them, that share nothing.
    """
    from stiffcal.diagnosis.model_settings import given_frames, search_with_settings
    from stiffcal.diagnosis.search import search_missing
    from stiffcal.identification.identify import Settings, fit_problem
    from stiffcal.model.assembly import fixed_parameters
    from stiffcal.model.campaign_effects import all_effects

    campaign, present = data.campaign, robot or robot_to_fit(data)
    settings = Settings(loss=loss, fixed=fixed_parameters(campaign.model))
    catalogue, _ = all_effects(campaign)
    problem = fit_problem(data.states, present)

    def search_again(robot: CompliantRobot, settings: Settings) -> Search:
        # observations are of the kinematics, whatever the effects
        known = problem if robot.chain is present.chain else None
        return search_missing(
            data.states, robot, catalogue, settings, context.progress, problem=known, n_searches=n_searches
        )

    search = search_again(present, settings)
    if not settings.fixed and present.deformed and not data.states.absolute.all():
        return search
    if not settings.fixed and present.deformed and not given_frames(present, problem.data):
        return search
    return search_with_settings(search, problem, settings, search_again)


def diagnosis_of(data: Ingested, search: Search) -> DiagnoseResult:
    """Return the result of a search, with what the present model holds and does not need."""
    from stiffcal.campaign.model_file import default_model
    from stiffcal.diagnosis.document import diagnosis_result
    from stiffcal.diagnosis.everywhere import effect_everywhere, everywhere_in_words
    from stiffcal.diagnosis.load_search_context import LoadSearchContext
    from stiffcal.diagnosis.ranking import effect_at
    from stiffcal.diagnosis.redundant import redundant_effects
    from stiffcal.identification.identify import Settings, fit_problem
    from stiffcal.model.assembly import fixed_parameters
    from stiffcal.model.campaign_effects import all_effects

    present, campaign = search.first.fit, data.campaign
    catalogue, untrusted = all_effects(campaign)
    bench = LoadSearchContext(
        data.states,
        fit_problem(data.states, present.robot),
        catalogue,
        Settings(fixed=fixed_parameters(campaign.model) - {setting.parameter for setting in search.contradicted}),
    )
    experiments = {run.experiment for run in campaign.manifest.runs}
    basic = [entry.type for entry in default_model(campaign.chain.n_joints, experiments).effects]
    redundant = redundant_effects(bench, present, basic)
    diagnosis = diagnosis_result(data.states, search)
    everywhere = effect_everywhere(bench, search)
    return replace(
        diagnosis,
        everywhere=everywhere,
        summary=diagnosis.summary if everywhere is None else f"{diagnosis.summary} {everywhere_in_words(everywhere)}.",
        not_tried=[*diagnosis.not_tried, *(UntestableEffect(effect.effect, effect.needs) for effect in untrusted)],
        superfluous=[effect_at(candidate) for candidate in redundant],
        next_measurement=_next_measurement(data, search),
    )


def _next_measurement(data: Ingested, search: Search) -> SeparatingMeasurement | None:
    """Return the pose and load that would separate the first missing effect from the nearest look-alike it can.

    None where no load would show a difference beyond the noise: creep that is over at once is compliance; where joints
    were clamped alone, whose poses and loads the fixture decides on; and of poses under the robot's own weight, where
    no load was applied whose size could be taken.
    """
    import numpy as np

    if data.states.clamped.all() or not np.any(data.states.wrench):
        return None

    from stiffcal.diagnosis.document import look_alike_pairs
    from stiffcal.diagnosis.heldout_error import with_values_of
    from stiffcal.diagnosis.ranking import effect_at
    from stiffcal.identification.document import finite
    from stiffcal.model.assembly import fixed_parameters
    from stiffcal.planning.rivals import RivalModel
    from stiffcal.planning.separate import KnownPair, separating_measurement

    scan, states = search.first, data.states
    fixed = fixed_parameters(data.campaign.model)
    noise = (scan.fit.noise.translation or scan.fit.noise.gauge) if scan.fit.noise is not None else 0.0
    for pair in look_alike_pairs(search):
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
