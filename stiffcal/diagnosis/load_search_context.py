"""What a search in load states works on: fits of the robot in balance, and forms of laws that replace each other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate, list_candidates
from stiffcal.diagnosis.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.held_to_places import ReferencePlaces, held_to_places
from stiffcal.diagnosis.judge import LackOfFit
from stiffcal.diagnosis.load_scan import LoadScan, scan_candidates, weights_of
from stiffcal.diagnosis.results import ResidualDependence, UntestableEffect
from stiffcal.diagnosis.scan import Trial
from stiffcal.diagnosis.search_context import NoBalanceWithError, SearchContext
from stiffcal.diagnosis.setting_results import WrongGeometry
from stiffcal.diagnosis.structure import what_it_follows
from stiffcal.diagnosis.thresholds import MOST_GENERAL_LAWS, MOST_LAWS, MOST_UNDERSTATED
from stiffcal.diagnosis.whole_form import with_whole_form
from stiffcal.diagnosis.wrong_geometry import wrong_geometry
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import Problem, Settings, fit_observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect
from stiffcal.model.no_balance import NoBalanceError

# Standard errors over poses by which another form must err less than the one that is expected.
EXPECTED_ERRORS = 2.0


@dataclass(frozen=True)
class LoadSearchContext(SearchContext[LoadScan, Fit]):
    """What a search in load states works on."""

    states: LoadStates
    problem: Problem
    catalogue: Mapping[str, Effect]
    settings: Settings
    n_searches: int = 1
    """Searches of the same campaign that share nothing: chance has as many more candidates."""
    geometry: list[GeometryNuisance | None] = field(default_factory=list, kw_only=True)
    """What the geometry's tolerance makes in the readings, the same for all models of the search; made once."""
    places: list[ReferencePlaces | None] = field(default_factory=list, kw_only=True)
    """Absolute places of the reference states, where there are any; made once."""

    def fit(self, robot: CompliantRobot) -> Fit:
        """Fit a model on the balanced robot."""
        return fit_observations(self.problem, robot, self.settings)

    def scan(self, fit: Fit, candidates: Sequence[Candidate], like: Fit | None = None) -> LoadScan:
        """Try candidates as additions to a fit."""
        self.release()
        if not self.geometry:
            self.geometry.append(GeometryNuisance.of(self.states, fit))
            self.places.append(ReferencePlaces.of(self.states, fit))
        scan = scan_candidates(fit, candidates, None if like is None else weights_of(like), self.geometry[0])
        scan = replace(scan, n_tried=scan.n_tried * self.n_searches)
        return held_to_places(scan, self.places[0])

    def fit_of(self, scan: LoadScan) -> Fit:
        """Return the fit that a scan is of."""
        return scan.fit

    def candidates(self, robot: CompliantRobot) -> tuple[list[Candidate], list[UntestableEffect]]:
        """Return the effects that can be added to a model, and those that cannot, with the reason."""
        return list_candidates(robot, self.states, self.catalogue)

    def look_with(self, robot: CompliantRobot, *trials: Trial) -> LoadScan:
        """Add candidates to a model, each in the form of its law that errs least, and look at it.

        Raises
        ------
        NoBalanceWithError : the robot finds no balance with the last of them.
        """
        return self.in_best_form(super().look_with(robot, *trials))

    def error_alone(self, robot: CompliantRobot, trial: Trial) -> LoadScan:
        """Return a scan of a model with a candidate in the form of its laws that errs least.

        Raises
        ------
        NoBalanceWithError : the robot finds no balance with the candidate.
        """
        scan = super().error_alone(robot, trial)
        forms = [with_whole_form(self.states, scan.fit, placed) for placed in scan.fit.robot.placed]
        return self.look_with(robot, trial) if any(form is not None for form in forms) else scan

    def in_best_form(self, scan: LoadScan) -> LoadScan:
        """Return the look at the same laws, each in the form that errs least in what is left out."""
        best = scan
        for placed in scan.fit.robot.placed:
            whole = with_whole_form(self.states, best.fit, placed)
            if whole is None:
                continue
            try:
                look = self.look(whole)
            except (NoBalanceError, ArithmeticError):
                # a curve that turns over within the loads is no curve of a spring
                continue
            change = look.base.heldout - best.base.heldout
            # chance over poses is allowed for where the load itself decides which form acts
            allowed = EXPECTED_ERRORS * _standard_error(change) if placed.effect.whole_form_expected else 0.0
            if float(np.sum(change)) < allowed:
                best = look
        return best

    def in_added_form(self, robot: CompliantRobot, present: CompliantRobot) -> CompliantRobot:
        """Return a model with laws in the form that is added to others, where the search replaced it."""
        kept = {(placed.effect.name, placed.place) for placed in present.placed}
        placed_effects: list[PlacedEffect] = []
        for placed in robot.placed:
            added = self._as_added(robot, placed)
            if (placed.effect.name, placed.place) in kept or added.parameters == placed.effect.parameters:
                placed_effects.append(placed)
                continue
            replaced = (
                p for p in present.placed if p.place == placed.place and p.effect.name in placed.effect.includes
            )
            placed_effects += [*replaced, PlacedEffect(added, placed.place)]
        return replace(robot, placed=tuple(placed_effects))

    def _as_added(self, robot: CompliantRobot, placed: PlacedEffect) -> Effect:
        """Return a law in the form in which the catalogue adds it at its place."""
        return self.catalogue.get(placed.effect.name, placed.effect).at(placed.place, robot.chain)

    def in_other_form(self, robot: CompliantRobot, candidate: Candidate) -> bool:
        """Return whether another law at the candidate's place is not in the form in which it is added."""
        return any(
            placed.place == candidate.place
            and placed.effect.name != candidate.effect.name
            and placed.effect.parameters != self._as_added(robot, placed).parameters
            for placed in robot.placed
        )

    def form_of(self, robot: CompliantRobot, candidate: Candidate) -> tuple[tuple[str, float], ...]:
        """Return symbols and values of the form that an effect has in a model; empty where it is the catalogue's."""
        for placed in robot.placed:
            if (placed.effect.name, placed.place) == (candidate.effect.name, candidate.place):
                usual = self._as_added(robot, placed)
                return () if placed.effect.parameters == usual.parameters else tuple(placed.values.items())
        return ()

    def form_alone(self, first: LoadScan, candidate: Candidate) -> tuple[tuple[str, float], ...]:
        """Return symbols and values from which a fit starts where a candidate alone is added, in its whole form."""
        trial = next((trial for trial in first.trials if trial.candidate.name == candidate.name), None)
        if trial is None:
            return ()
        try:
            fit = super().look_with(first.fit.robot, trial).fit
        except NoBalanceWithError:
            return ()
        for placed in fit.robot.placed:
            if (placed.effect.name, placed.place) == (candidate.effect.name, candidate.place):
                whole = with_whole_form(self.states, fit, placed)
                return () if whole is None else tuple(whole.placed[-1].values.items())
        return ()

    def follows(self, scan: LoadScan) -> list[ResidualDependence]:
        """Return what the residual of a scan's model follows, largest share first."""
        return what_it_follows(scan, self.states)

    @property
    def most_understated(self) -> float:
        """By what factor noise that was only stated can be larger, where what is left follows nothing.

        Places that were measured once each show no repeats: there only a small part of what is left is noise.
        """
        return MOST_UNDERSTATED if self.problem.data.absolute.any() else np.inf

    def mimics_anything(self, candidates: Iterable[Candidate]) -> bool:
        """Return whether effects together have so many different laws that they explain any error of these data.

        So it is of places that were measured once each: loads come in steps, which laws have to follow.
        """
        if not self.problem.data.absolute.all():
            return False
        effects = [candidate.effect for candidate in candidates]
        laws, general = {effect.name for effect in effects}, sum(effect.general for effect in effects)
        return len(laws) > MOST_LAWS or general > MOST_GENERAL_LAWS

    def wrong_geometry(self, scan: LoadScan) -> WrongGeometry | None:
        """Return how wrong the robot's geometry is, where absolute places contradict it."""
        return wrong_geometry(self.states, scan)

    def in_units_of(self, final: Fit, present: Fit, own: LackOfFit) -> LackOfFit:
        """Return the present model's residuals against the noise as the final model estimates it."""
        if final.noise is None or present.noise is None:
            return own
        before, after = present.noise_length["translation"], final.noise_length["translation"]
        if not before or not after:
            return own
        return replace(own, ratio=own.ratio * before / after)


def _standard_error(change: Floats) -> float:
    """Return the standard error of the sum of changes (F,) over poses; 0 of a single one."""
    return float(np.sqrt(len(change)) * np.std(change, ddof=1)) if len(change) > 1 else 0.0
