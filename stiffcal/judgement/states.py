"""Load states as readings that are judged: models are fitted on the balanced robot."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.held_to_places import ReferencePlaces
from stiffcal.diagnosis.scans.candidates import Candidate, driven_joint_of_state, list_candidates
from stiffcal.diagnosis.scans.drift import walking_together
from stiffcal.diagnosis.scans.geometry_nuisance import GeometryNuisance
from stiffcal.diagnosis.suspects.influence import most_suspects
from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.estimation.unknowns import ParameterColumn
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.identification.noise.weights import residual_noise
from stiffcal.judgement.covariance_kind import CovarianceKind
from stiffcal.judgement.discrepancy import Discrepancy, LouderRun
from stiffcal.judgement.forms import as_added, in_best_form, is_whole, replaced, spring_of, spring_symbol
from stiffcal.judgement.ground import columns_of
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.judge import AskedAgain, Judged, JudgedReadings, is_member, judge, weighed_about
from stiffcal.judgement.lasting_errors import lasting_errors, made_by
from stiffcal.judgement.like_states import variance_of, with_noise_of_like_states
from stiffcal.judgement.lingering_noise import LingeringNoise
from stiffcal.judgement.members import Member, list_members, off_columns, unlisted_columns
from stiffcal.judgement.mistakes import mistakes_and_settings, state_changes
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import (
    ALIKE_IN_SWEEPS,
    ALONE,
    DOUBTED_RUN,
    LINGERING,
    NAMED,
    OF_LOADS,
    OF_TIME,
    STATED_NOISE_DOF,
)
from stiffcal.judgement.priors import JOINT_SPRING, RobotScale, log_odds_of_doubt
from stiffcal.judgement.reference_places import with_reference_places
from stiffcal.judgement.rivals import with_rivals_refitted
from stiffcal.judgement.rows_off import Off, off_mask, rows_off
from stiffcal.judgement.settings_off import GivenSettings, changed_model, freed, setting_columns
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.unlisted import UnlistedLaw, unlisted_laws
from stiffcal.judgement.weight import WeightOfLinks, shown
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.states.mistake import StateMistake
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Effect, ParameterRole, Place


def judge_states(
    states: LoadStates,
    robot: CompliantRobot,
    catalogue: Mapping[str, Effect],
    settings: Settings | None = None,
    progress: Progress = no_progress,
    doubt: bool = True,
    jobs: int = 1,
) -> Judged:
    """Compare all sets of members that are worth it.

    Parameters
    ----------
    states : the campaign's load states.
    robot : the present model, with or without values.
    catalogue : effects by name.
    settings : how fits are made.
    progress : receives a description of each step.
    doubt : whether runs and single readings may be off.
    jobs : threads in which members are prepared; answers do not depend on it.

    Raises
    ------
    InputError : the data hold no more readings than the model has values.
    """
    settings = settings or Settings()
    fit = fit_observations(fit_problem(states, robot), robot, settings)
    return judge(StatesOfCampaign.of(states, robot, fit, catalogue, settings, doubt, jobs), fit, progress)


def _nothing_left(dof: int, n_parameters: int) -> InputError:
    """Return the fault where the model's own values use up all readings: no residual could show an effect."""
    reason = f"{max(dof, 0)} readings for {n_parameters} parameters of the model"
    mend = "measure more poses or loads, or remove effects from model.toml: there are no degrees of freedom left"
    return InputError.at(FaultCode.DATA_MISSING, "campaign.toml", "runs", reason, mend)


def _noise_of(fit: Fit) -> Noise:
    """Return the noise of a fit; where none is known, the residuals' own size by kind of row."""
    return fit.noise or residual_noise(fit.data, fit.predicted)


@dataclass(frozen=True)
class StatesOfCampaign(JudgedReadings[Fit]):
    """A campaign's load states, and what may be missing from a model of them."""

    states: LoadStates
    """The load states."""
    model: CompliantRobot
    """The present model: readings are of its kinematics."""
    data: Observations
    """Of all runs that take part, as rows."""
    springs: CompliantRobot
    """What every hypothesis has."""
    catalogue: Mapping[str, Effect]
    """Effects by name …"""
    candidates: Sequence[Candidate]
    """… and at their places."""
    scale: RobotScale
    """How soft and how loaded the robot is."""
    geometry: GeometryNuisance | None
    """Errors of its geometry."""
    weight: WeightOfLinks
    """What the links weigh beyond what is stated."""
    settings: Settings
    """How fits are made."""
    given: GivenSettings
    """What model file and manifest set."""
    places: ReferencePlaces | None
    """Absolute places of reference states; None where there are none."""
    doubt: bool
    """Whether runs and single readings may be off."""
    jobs: int
    """Threads in which members are prepared."""

    @property
    def driven(self) -> frozenset[int] | None:
        """The joints that were driven where all runs are of a clamped robot; else None."""
        if not self.states.clamped.all():
            return None
        return frozenset(driven_joint_of_state(self.states, self.springs.chain).tolist())

    @classmethod
    def of(
        cls,
        states: LoadStates,
        model: CompliantRobot,
        fit: Fit,
        catalogue: Mapping[str, Effect],
        settings: Settings,
        doubt: bool,
        jobs: int = 1,
    ) -> StatesOfCampaign:
        """Prepare, with the fit of a model: the robot is as large and as loaded as in the runs that took part in it."""
        springs = without_members(fit.robot, catalogue)
        candidates, _ = list_candidates(springs, states, catalogue)
        scale = RobotScale.of(fit.robot, Linearised.about(fit.robot, fit.data).loads)
        # about springs alone: next to a play more weight moves its edge, and would explain the play itself
        geometry, weight = GeometryNuisance.of(states, fit), WeightOfLinks.of(springs, fit.data)
        given = GivenSettings.of(model, settings.fixed, fit.data)
        places = ReferencePlaces.of(states, fit)
        return cls(
            states,
            model,
            _with_noise_of_like_states(fit, fit.data),
            springs,
            catalogue,
            candidates,
            scale,
            geometry,
            weight,
            settings,
            given,
            places,
            doubt,
            jobs,
        )

    def about(self, fit: Fit) -> StatesOfCampaign:
        """Return it prepared with another fit."""
        return StatesOfCampaign.of(self.states, self.model, fit, self.catalogue, self.settings, self.doubt, self.jobs)

    def next_to(self, fit: Fit) -> StatesOfCampaign:
        """Return it with the noise that like states of sweeps show next to a model."""
        return replace(self, data=_with_noise_of_like_states(fit, self.data))

    def without(self, names: frozenset[str]) -> StatesOfCampaign:
        """Return it without some effects."""
        return replace(self, candidates=[one for one in self.candidates if one.name not in names])

    @property
    def most_off(self) -> int:
        """How many mistakes of runs are possible next to those that are set aside, of which two may be one exchange."""
        of_states, of_data = len(np.unique(self.states.run)), len(np.unique(self.data.run))
        return max(most_suspects(of_states) - (of_states - of_data + 1) // 2, 0)

    def fit(self, chosen: Sequence[Member], aside: frozenset[Off]) -> Fit:
        """Return the fit of the model with some effects; runs that are off take no part."""
        robot = self.springs
        for one in chosen:
            if one.candidate is not None:
                robot = replaced(robot, as_added(one.candidate, self.candidates, one.shape))
        kept = ~off_mask(self.states.run, np.arange(len(self.states)), aside) if aside else None
        problem = fit_problem(self.states, self.model, kept)
        changed = tuple(one.setting for one in chosen if one.setting is not None)
        settings = replace(self.settings, fixed=self.settings.fixed - freed(changed))

        def refit(robot: CompliantRobot) -> Fit:
            return fit_observations(problem, robot, settings)

        return in_best_form(self.states, refit(changed_model(robot, changed, self.given)), refit)

    def with_rivals(self, judged: Judged, fit: Fit, aside: frozenset[Off]) -> Judged:
        """Return a judgement with the nearest rivals of its set refitted, what is off left out."""
        noise = _noise_of(fit)
        weighed = with_rivals_refitted(
            judged.weighed,
            judged.own,
            judged.ground,
            self.scale,
            lambda members: self.ground(self.fit(members, aside), noise, self.data),
            lambda ground, setting: setting_columns(ground, setting, self.given, self.scale),
        )
        return replace(judged, weighed=weighed)

    def asked_again(self, judged: Judged, fit: Fit, aside: frozenset[Off]) -> AskedAgain:
        """Return of each run and state that was set aside how probable it is that it is off, and how."""
        if not aside:
            return AskedAgain({}, {})
        everything = fit_problem(self.states, self.model).data
        ground = self.ground(fit, _noise_of(fit), everything)
        laws = {law.place + ": " + law.follows: law for law in unlisted_laws(ground.state, self.driven)}
        columns = [
            columns_of(ground, ground.state.regressor(one.effect, one.place, one.shape()), self.scale)
            for one in ground.present
        ]
        columns += [unlisted_columns(ground, laws[one.name].columns) for one in judged.best if one.name in laws]
        n_rows = len(ground.white)
        off = [(Off(one.run), off_columns(one.rows(n_rows)), 0.0) for one in ground.runs_off() if Off(one.run) in aside]
        states = frozenset(one.state for one in aside if one.state is not None)
        off += [(one, off_columns(rows, ALONE), 0.0) for one, rows in rows_off(ground, states)]
        usual, how = range(len(columns) + len(off)), dict[int, StateMistake]()
        for mistake, change in state_changes(ground, inside_runs_alone=True):
            if Off(change.runs[0]) in aside:
                how[len(columns) + len(off)] = mistake
                off.append((Off(change.runs[0]), off_columns(change.rows), change.log_share))
        evidence = ground.evidence([*columns, *(rows for _, rows, _ in off)])
        log_odds, likeliest = dict[Off, float](), dict[Off, tuple[float, StateMistake | None]]()
        for number, (one, _, share) in enumerate(off, start=len(columns)):
            sound = [i for i in usual if i < len(columns) or off[i - len(columns)][0] != one]
            gain = evidence.of_set([*sound, number]) - evidence.of_set(sound)
            odds = gain + share + log_odds_of_doubt(one.state is not None)
            log_odds[one] = float(np.logaddexp(log_odds.get(one, -np.inf), odds))
            if one not in likeliest or odds > likeliest[one][0]:
                likeliest[one] = odds, how.get(number)
        return AskedAgain(
            {one: float(1.0 / (1.0 + np.exp(-np.clip(odds, -500.0, 500.0)))) for one, odds in log_odds.items()},
            {
                one: mistake
                for one, (odds, mistake) in likeliest.items()
                if mistake is not None and odds - log_odds[one] >= np.log(NAMED)
            },
        )

    def judged(self, fit: Fit, chosen: frozenset[str], number: int, progress: Progress = no_progress) -> Judged:
        """Weigh sets about a model."""
        ground = self.ground(fit, _noise_of(fit), self.data)
        weights = dict(self.weight.of_links) if self.springs.chain.masses_known else {}
        # who states a tool has not forgotten it: what its link lacks is then a law like those of the others
        of_tool = None if self.data.setup.tool_mass else weights.pop(self.springs.chain.link_names[-1], None)
        of_weight = (UnlistedLaw(f"link {a}", "weight", b) for a, b in weights.items())
        laws = chain(unlisted_laws(ground.state, self.driven), of_weight)
        given = replace(self.given, of_tool=of_tool)
        mistakes = mistakes_and_settings(ground, given, self.scale, self.doubt)
        members = list_members(ground, self.candidates, self.scale, laws, mistakes, progress=progress, jobs=self.jobs)
        evidence = ground.evidence([one.columns for one in members], jobs=self.jobs)
        if self.places is not None:
            members = with_reference_places(members, evidence, ground, self.places, self.scale)
        weighed, own = weighed_about(members, evidence, chosen, self.most_off, progress)
        return Judged(weighed, fit, ground, chosen, own, number)

    def ground(self, fit: Fit, noise: Noise, data: Observations) -> GroundOfStates:
        """Return what members are compared about: a fit, what it has beyond the springs as members.

        Parameters
        ----------
        data : of all runs that take part, as they were read; or of all, where errors of geometry and weight stay out.
        """
        state = Linearised.about(fit.robot, data)
        about = fit.linearised(noise, state, data)
        own = [(placed.effect.name, placed.place) for placed in self.springs.placed]
        present = tuple(one for one in fit.robot.placed if (one.effect.name, one.place) not in own)
        common = [
            k
            for k, column in enumerate(about.columns)
            for placed in (fit.robot.placed[column.placed],)
            if (placed not in present or column.symbol == spring_symbol(placed))
            and placed.parameter_name(column.symbol) not in self.given.fixed
        ]
        # what every hypothesis has of any size is so in one unit: that of a spring, also where a curve holds it
        unit = np.array([_in_compliance(fit.robot, about.columns[k]) for k in common])
        columns, prior = about.derivative[common], _prior_of(about.prior, common)
        columns, prior = columns * unit[:, None, None], prior * np.append(unit, 1.0)
        nuisance = []
        if self.geometry is not None and data is self.data:
            nuisance.append(self.geometry.directions(about.space, columns))
        if not fit.robot.chain.masses_known and data is self.data:
            nuisance.append(shown(self.weight.unknown(self.scale), about.space))
        alike = Discrepancy.of_like_states(about.space)
        errors = lasting_errors(state, noise)
        # the states of a sweep err alike place by place, across which errors of its run reach: these are columns there
        of_runs, of_several = made_by(errors, state.data, by_run=alike is None)
        if len(of_several):
            nuisance.append(shown(of_several, about.space))
        p, q = len(columns), sum(len(part) for part in nuisance)
        columns = np.concatenate([columns, *nuisance])
        prior = np.insert(prior, [p] * q, 0.0, axis=1)
        prior = np.concatenate([prior, np.eye(q, p + q + 1, p)])
        derivative: dict[tuple[str, Place], dict[str, Floats]] = defaultdict(dict)
        for column, change in zip(about.columns, about.derivative, strict=True):
            placed = fit.robot.placed[column.placed]
            of_curve = is_whole(placed) and column.symbol != spring_symbol(placed)
            if placed in present and (of_curve or column.role is not ParameterRole.NONLINEAR):
                derivative[placed.effect.name, placed.place][column.symbol] = change
        space = about.space
        stated = fit.noise is not None and fit.noise.source == "manifest"
        if about.dof <= len(common):
            raise _nothing_left(about.dof, len(common))
        scale = NoiseScale(float(about.dof - len(common)), STATED_NOISE_DOF if stated else 0.0)
        lasting = Discrepancy.of_lasting(space, of_runs, state.data.run) if len(of_runs) else None
        of_loads, of_time = Discrepancy.of_loads(space, lasting), Discrepancy.of_time(space, lasting)
        louder = LouderRun.of(space, space.rows(about.residual[None])[0], lasting) if self.doubt else None
        lingering = LingeringNoise.of(space, walking_together(space.data), np.arange(space.data.n_states), lasting)
        kinds: list[tuple[CovarianceKind, float]] = [
            (of_loads, OF_LOADS), (of_time, OF_TIME), (lingering, LINGERING),
        ]  # fmt: skip
        if louder is not None:
            kinds.append((louder, DOUBTED_RUN))
        if alike is not None:
            kinds.append((alike, ALIKE_IN_SWEEPS))
        shared = Shared(space.rows(columns), prior, kinds, lasting)
        return GroundOfStates(
            state, space, shared, about.residual, present, derivative, of_loads, of_time, lingering, louder, scale,
            alike=alike, of_wrench=noise.of_wrenches(state.data),
        )  # fmt: skip


def without_members(robot: CompliantRobot, catalogue: Mapping[str, Effect]) -> CompliantRobot:
    """Return a robot without the effects that are judged; in place of a curve that holds its spring, the spring."""
    kept = (
        placed if not is_member(placed) else spring_of(placed, catalogue.get(JOINT_SPRING)) for placed in robot.placed
    )
    return replace(robot, placed=tuple(one for one in kept if one is not None))


def _in_compliance(robot: CompliantRobot, column: ParameterColumn) -> float:
    """Return by what a column is multiplied to be one per compliance: a curve of torque has it per rigidity; else 1."""
    placed = robot.placed[column.placed]
    return placed.values[column.symbol] ** 2 if column.symbol == spring_symbol(placed) else 1.0


def _with_noise_of_like_states(fit: Fit, data: Observations) -> Observations:
    """Return readings, those of clamped motors with the noise that their like states show next to a model."""
    if data.clamped is None:
        return data
    about = fit.linearised(_noise_of(fit), data=data)
    return with_noise_of_like_states(data, about.residual, variance_of(about.space.whitening))


def _prior_of(prior: Floats, chosen: Sequence[int]) -> Floats:
    """Return the rows (r, p + 1) of what is known before that are of chosen parameters alone, as rows of these."""
    kept = [row for row in prior if not np.delete(row[:-1], chosen).any()]
    return np.array([[*row[:-1][chosen], row[-1]] for row in kept]).reshape(-1, len(chosen) + 1)
