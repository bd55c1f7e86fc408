"""What model.toml and campaign.toml set and the data contradict: a fixed parameter, the first-order balance, a frame.

A value that is held wrong leaves a remainder as a missing effect does, and the effect that comes nearest would be named
for it. So each fixed parameter is freed in turn, the first-order balance replaced by the deformed robot's, and of
absolute places each frame estimated that the manifest gives, as candidates among the effects: the error in poses left
out has to fall by as much, and as surely.

A frame and the geometry of the joint next to it are one motion but for the directions that the geometry leaves out. Of
few poses the error in those left out chooses between them at random: where the estimated frame reproduces what an
effect displaces to within the noise (`judge.same_within_noise` in one direction), the frame is named, and the effect
with it where the frame explains no more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.judge import f_tail, reduction_between
from stiffcal.diagnosis.load_scan import LoadScan, scan_candidates, weights_of
from stiffcal.diagnosis.scan import Trial
from stiffcal.diagnosis.search_results import Search
from stiffcal.diagnosis.setting_results import ContradictedSetting, SettingKind
from stiffcal.diagnosis.thresholds import FAMILY_P, LEAST_FALL, LOOK_ALIKE_ERRORS, STANDARD_ERRORS
from stiffcal.identification.identify import Problem, Settings, fit_observations
from stiffcal.identification.readings import Observations
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.measured_frames import placed_frame

# So many settings are changed one after another.
MOST_CHANGES = 5


def search_with_settings(
    search: Search, problem: Problem, settings: Settings, search_again: Callable[[CompliantRobot, Settings], Search]
) -> Search:
    """Try the settings of the present model as candidates among the effects that a search found.

    Parameters
    ----------
    search : of the present model with its settings.
    problem : the observations that it was made of.
    settings : how its fits were made.
    search_again : searches with another balance or other fixed parameters.

    Returns
    -------
    Search
        The search with the settings changed that the data contradict, where that explains as much with fewer
        effects; else the search as it was, with the settings that are contradicted also where its effects are added.
    """
    if not search.tried and not search.unexplained:
        return search
    tried = [missing_effect.candidate for missing_effect in search.tried]
    changed = _contradicted(search.first, problem, settings, tried)
    if changed:
        other = search_again(changed[-1].scan.fit.robot, changed[-1].settings)
        kept = {missing_effect.candidate.name for missing_effect in other.tried}
        dropped = [candidate for candidate in tried if candidate.name not in kept]
        as_good = _error(other) <= _error(search) + LEAST_FALL or all(
            any(trial.reproduces(candidate) for trial in changed) for candidate in dropped
        )
        fewer = len(other.tried) < len(search.tried) and as_good
        if fewer or (search.unexplained and not (search.found and other.unexplained)):
            return replace(other, contradicted=tuple(trial.result(dropped) for trial in changed))
    if not search.found:
        return search
    changed = _contradicted(search.final_scan, problem, settings, ())
    return replace(search, contradicted=tuple(trial.result(()) for trial in changed))


def _error(search: Search) -> float:
    return float(np.sqrt(np.sum(search.final_scan.base.heldout) / search.final_scan.dof))


def _contradicted(scan: LoadScan, problem: Problem, settings: Settings, tried: Sequence[Candidate]) -> list[_Changed]:
    """Change one setting after another as long as the data contradict one, or it stands for an effect of ``tried``."""
    changed: list[_Changed] = []
    robot, present = scan.fit.robot, settings
    while len(changed) < MOST_CHANGES:
        trials = list(_trials(scan, problem, robot, present))
        supported = [
            trial for trial in trials if trial.supported(len(trials)) or any(trial.reproduces(one) for one in tried)
        ]
        if not supported:
            break
        best = min(supported, key=lambda trial: float(np.sum(trial.scan.base.heldout)))
        changed.append(best)
        scan, robot, present = best.scan, best.scan.fit.robot, best.settings
    return changed


@dataclass(frozen=True)
class _Changed:
    """The model with one setting changed, fitted again."""

    kind: SettingKind
    name: str
    """The parameter's full name; "" for the balance."""
    before: LoadScan
    scan: LoadScan
    settings: Settings

    def reduction(self) -> tuple[float, float]:
        """Return the fall of the error in poses left out, over the noise, and its size in standard errors."""
        return reduction_between(self.before, self.scan)

    def p_value(self, n_trials: int) -> float:
        """Return the probability of so large a fall of the fit's squares by chance, for all trials together."""
        return min(1.0, n_trials * self._p_against(self.before.base.sum_of_squares, self.before.n_columns))

    def _p_against(self, sum_of_squares: float, n_columns: int) -> float:
        """Return the probability by chance of the fall from the squares of a model with so many parameters."""
        rest = self.scan.residual_dof
        if rest <= 0:
            return 1.0
        added = max(self.scan.n_columns - n_columns, 1)
        drop = max(sum_of_squares - self.scan.base.sum_of_squares, 0.0)
        noise = self.scan.fit.noise
        freedom = float(rest) if noise is None else min(rest, noise.dof)
        scale = max(1.0, self.scan.base.sum_of_squares / rest)
        return f_tail(drop / (added * scale), float(added), freedom)

    def reproduces(self, candidate: Candidate) -> bool:
        """Return whether a frame displaces what an effect does, as fitted without it, to within the noise."""
        found = self._trial_of(candidate)
        if self.kind is not SettingKind.FRAME or found is None:
            return False
        regressor = found.regressor
        amplitude = found.score.solution[len(found.score.solution) - len(regressor.symbols) :]
        moved = np.einsum("qmn,q->mn", regressor.columns, amplitude) + regressor.fixed
        rows = self.scan.space.rows(np.concatenate([self.scan.own_columns, moved[None]]))
        known, aim = rows[:-1].T, rows[-1]
        left = aim - known @ np.linalg.lstsq(known, aim, rcond=1e-10)[0]
        scatter = self.scan.base.sum_of_squares / max(self.scan.residual_dof, 1)
        unit = scatter if self.scan.fit.noise is None else max(1.0, scatter)
        return float(left @ left) <= LOOK_ALIKE_ERRORS**2 * unit

    def _explains_no_more_than(self, candidate: Candidate) -> bool:
        """Return whether an effect that the frame reproduces leaves no more than the frame does, but for chance."""
        found = self._trial_of(candidate)
        assert found is not None
        n_columns = self.before.n_columns + len(found.regressor.symbols)
        return self._p_against(found.score.sum_of_squares, n_columns) >= FAMILY_P

    def _trial_of(self, candidate: Candidate) -> Trial | None:
        return next((trial for trial in self.before.trials if trial.candidate.name == candidate.name), None)

    def supported(self, n_trials: int) -> bool:
        """Return whether the data contradict the setting."""
        fall, errors = self.reduction()
        return fall > LEAST_FALL and errors > STANDARD_ERRORS and self.p_value(n_trials) < FAMILY_P

    def result(self, dropped: Sequence[Candidate]) -> ContradictedSetting:
        """Return it with what it would be, and which of the effects ``dropped`` cannot be distinguished from it."""
        from stiffcal.diagnosis.heldout_error import left_out_rms
        from stiffcal.diagnosis.ranking import effect_at

        alike = [one for one in dropped if self.reproduces(one) and self._explains_no_more_than(one)]

        parameters = {parameter.name: parameter for parameter in self.scan.fit.parameters}
        fixed = {parameter.name: parameter for parameter in self.before.fit.parameters}
        free = parameters.get(self.name)
        return ContradictedSetting(
            setting=self.kind,
            parameter=self.name or None,
            fixed_at=fixed[self.name].value if self.name in fixed else None,
            free_value=None if free is None else free.value,
            free_std=None if free is None else free.std,
            standard_errors=self.reduction()[1],
            heldout_rms_before=left_out_rms(self.before, None),
            heldout_rms_after=left_out_rms(self.scan, None),
            alternatives=[effect_at(candidate) for candidate in alike],
        )


def _trials(scan: LoadScan, problem: Problem, robot: CompliantRobot, settings: Settings) -> Iterator[_Changed]:
    """Yield the model with each setting changed."""
    whitening = weights_of(scan.fit)
    names = {parameter.name for parameter in scan.fit.parameters if parameter.fixed}
    for name in sorted(names & settings.fixed):
        freed = replace(settings, fixed=settings.fixed - {name})
        fit = fit_observations(problem, robot, freed)
        yield _Changed(SettingKind.FIXED, name, scan, scan_candidates(fit, [], whitening, scan.geometry), freed)
    if not robot.deformed:
        fit = fit_observations(problem, replace(robot, deformed=True), settings)
        yield _Changed(SettingKind.BALANCE, "", scan, scan_candidates(fit, [], whitening, scan.geometry), settings)
    for frame in given_frames(robot, problem.data):
        fit = fit_observations(problem, replace(robot, placed=(frame, *robot.placed)), settings)
        name = f"{frame.effect.name}.{frame.place.frame}"
        yield _Changed(SettingKind.FRAME, name, scan, scan_candidates(fit, [], whitening, scan.geometry), settings)


def given_frames(robot: CompliantRobot, data: Observations) -> list[PlacedEffect]:
    """Return the frames of tracker and targets that the manifest gives, as parts of a model of absolute places.

    None where load states are fitted too: their displacements depend on the tracker's turn, which its frame leaves out.
    The position of a single target on the flange is target-offset.
    """
    if not data.absolute.all():
        return []
    found, setup = {placed.place.frame for placed in robot.placed}, data.setup
    turned = {int(body) for body in data.body[data.rotational]}
    targets = {name: number in turned for number, name in enumerate(setup.target_names)}
    if len(targets) == 1 and not turned and setup.targets[0].body == robot.chain.n_joints + 1:
        targets = {}
    names = {tracker.frame: True for tracker in setup.trackers if tracker.frame} | targets
    return [placed_frame(name, with_turn) for name, with_turn in names.items() if name not in found]
