"""What is missing from a model of load states, with the models and errors that a person wants to see of it."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stiffcal.arrays import Booleans
from stiffcal.diagnosis.answers.setting_results import WrongGeometry
from stiffcal.diagnosis.held_to_places import ReferencePlaces, held_to_places
from stiffcal.diagnosis.scans.candidates import Candidate, list_candidates
from stiffcal.diagnosis.scans.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.scans.lack_of_fit import LackOfFit
from stiffcal.diagnosis.scans.load_scan import LoadScan, scan_candidates
from stiffcal.diagnosis.wrong_geometry import wrong_geometry
from stiffcal.errors import Progress, no_progress, part_of
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import (
    Problem,
    Settings,
    fit_observations,
    fit_problem,
    without_noise_dominated,
)
from stiffcal.judgement.found import Diagnosed, named_effects, superfluous_effects, with_all
from stiffcal.judgement.judge import judge
from stiffcal.judgement.numbers import TO_JUDGE, TO_SCAN
from stiffcal.judgement.reading import read_off
from stiffcal.judgement.rows_off import Off, off_mask
from stiffcal.judgement.settings_off import GivenSettings, changed_model, freed
from stiffcal.judgement.states import StatesOfCampaign
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Effect


@dataclass(frozen=True)
class DiagnosedStates(Diagnosed):
    """What is missing from a model of load states."""

    first: LoadScan
    """The present model, with each effect at each place as an addition; without states that are off."""
    last: LoadScan
    """The same data with all that is missing in the model; the same scan where nothing is."""
    states: LoadStates
    """All load states."""
    kept: Booleans
    """(n,) False for states that are probably off, and for those of runs that are."""

    measured_in = "poses and loads"
    more = "poses"

    @property
    def differ_between(self) -> str:
        """Between what readings that follow no law differ, in words."""
        return "run to run" if self.states.clamped.all() else "pose to pose"

    def run_in_words(self, run: int) -> str:
        """Return a run by its number, in words."""
        return f'run "{self.states.runs[run].name}"'

    @property
    def kept_states(self) -> LoadStates:
        """The load states without those that are off."""
        return self.states if self.kept.all() else self.states.select(self.kept)

    @property
    def doubted(self) -> Mapping[Off, float]:
        """Runs and states that are probably off, with the probability."""
        return dict(self.reading.doubted)

    @property
    def before_in_last_noise(self) -> LackOfFit | None:
        """The present model's residuals against the noise of the last: what is missing swells that of its own."""
        if self.before is None:
            return None
        own, final = self.first.fit.noise_length["translation"], self.last.fit.noise_length["translation"]
        return replace(self.before, ratio=self.before.ratio * own / final) if own and final else self.before

    @cached_property
    def wrong_geometry(self) -> WrongGeometry | None:
        """How wrong the robot file is, where absolute places contradict it."""
        return wrong_geometry(self.kept_states, self.first)


def diagnose_states(
    states: LoadStates,
    robot: CompliantRobot,
    catalogue: Mapping[str, Effect],
    settings: Settings | None = None,
    progress: Progress = no_progress,
    doubt: bool = True,
    jobs: int = 1,
) -> DiagnosedStates:
    """Find what is missing from a model of load states.

    Parameters and errors are those of `stiffcal.judgement.states.judge_states`.
    """
    start = time.perf_counter()
    settings = settings or Settings()
    if states.clamped.any():
        # joints that were not driven turn with the driven one's reading by what bends the chain: within its noise
        settings = without_noise_dominated(fit_problem(states, robot), robot, settings)
    problem = fit_problem(states, robot)
    fit = fit_observations(problem, robot, settings)
    campaign = StatesOfCampaign.of(states, robot, fit, catalogue, settings, doubt, jobs)
    judged = judge(campaign, fit, progress)
    reading = read_off(judged)
    kept = ~off_mask(states.run, np.arange(len(states)), dict(reading.doubted))
    models = _Models(states, problem, settings, campaign.geometry)
    if not kept.all():
        problem = fit_problem(states.select(kept), robot)
        fit = fit_observations(problem, robot, settings)
        models = _Models(states.select(kept), problem, settings, GeometryNuisance.of(states.select(kept), fit))
    progress("the error in held-out poses", TO_JUDGE)
    listed, not_tried = list_candidates(robot, states, catalogue)
    first = models.scan(fit, listed, part_of(progress, TO_JUDGE, TO_SCAN))
    effects = named_effects(judged, reading, catalogue)
    found = tuple(one for one in effects if one.candidate.name not in judged.model)
    held = tuple(one for one in effects if one.candidate.name in judged.model)
    changed = tuple(one.setting for one in reading.settings)
    last = first
    if found or changed:
        given = GivenSettings.of(first.fit.robot, settings.fixed, first.fit.data)
        complete = changed_model(with_all(first.fit.robot, found, judged.fit.robot), changed, given)
        last = models.scan(models.fit(complete, settings.fixed - freed(changed)))
    superfluous = superfluous_effects(judged, reading, first.fit.robot)
    seconds = time.perf_counter() - start
    return DiagnosedStates(
        judged, reading, first, last, found, held, superfluous, tuple(not_tried), seconds, states, kept
    )


@dataclass(frozen=True)
class _Models:
    """Models of the same data, and their errors."""

    states: LoadStates
    """What is fitted."""
    problem: Problem
    """The same as rows."""
    settings: Settings
    """How fits are made."""
    geometry: GeometryNuisance | None
    """What the geometry's tolerance makes in the readings, the same for all models."""

    def fit(self, robot: CompliantRobot, fixed: frozenset[str]) -> Fit:
        """Return the fit of a model; ``fixed``: full names of parameters that stay."""
        return fit_observations(self.problem, robot, replace(self.settings, fixed=fixed))

    def scan(self, fit: Fit, candidates: Sequence[Candidate] = (), progress: Progress = no_progress) -> LoadScan:
        """Return a model's errors in poses left out, with each candidate as an addition; `progress` gets the share."""
        scan = scan_candidates(fit, candidates, None, self.geometry, progress)
        return held_to_places(scan, ReferencePlaces.of(self.states, fit)) if candidates else scan
