"""What model.toml and campaign.toml set and the data contradict: a fixed parameter, the first-order balance, a frame.

A value that is held wrong leaves a remainder as a missing effect does, and the effect that comes nearest would be named
for it. So each fixed parameter is freed in turn, the first-order balance replaced by the deformed robot's, and of
absolute places each frame estimated that the manifest gives, as candidates among the effects: the error in poses left
out has to fall by as much, and as surely.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.diagnosis.judge import f_tail, reduction_between
from stiffcal.diagnosis.load_scan import LoadScan, scan_candidates, weights_of
from stiffcal.diagnosis.search_results import Search
from stiffcal.diagnosis.setting_results import ContradictedSetting, SettingKind
from stiffcal.diagnosis.thresholds import FAMILY_P, LEAST_FALL, STANDARD_ERRORS
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
    changed, robot, freed = _contradicted(search.first, problem, settings)
    if changed:
        other = search_again(robot, freed)
        fewer = len(other.tried) < len(search.tried) and _error(other) <= _error(search) + LEAST_FALL
        if fewer or (search.unexplained and not (search.found and other.unexplained)):
            return replace(other, contradicted=changed)
    if not search.found:
        return search
    return replace(search, contradicted=_contradicted(search.final_scan, problem, settings)[0])


def _error(search: Search) -> float:
    return float(np.sqrt(np.sum(search.final_scan.base.heldout) / search.final_scan.dof))


def _contradicted(
    scan: LoadScan, problem: Problem, settings: Settings
) -> tuple[tuple[ContradictedSetting, ...], CompliantRobot, Settings]:
    """Change one setting after another as long as the data contradict one; return them and what is left set."""
    changed: list[ContradictedSetting] = []
    robot, present = scan.fit.robot, settings
    while len(changed) < MOST_CHANGES:
        trials = list(_trials(scan, problem, robot, present))
        supported = [trial for trial in trials if trial.supported(len(trials))]
        if not supported:
            break
        best = min(supported, key=lambda trial: float(np.sum(trial.scan.base.heldout)))
        changed.append(best.result())
        scan, robot, present = best.scan, best.scan.fit.robot, best.settings
    return tuple(changed), robot, present


@dataclass(frozen=True)
class _Trial:
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
        rest = self.scan.dof - self.scan.n_columns
        if rest <= 0:
            return 1.0
        added = max(self.scan.n_columns - self.before.n_columns, 1)
        scale = max(1.0, self.scan.base.sum_of_squares / rest)
        drop = max(self.before.base.sum_of_squares - self.scan.base.sum_of_squares, 0.0)
        noise = self.scan.fit.noise
        freedom = float(rest) if noise is None else min(rest, noise.dof)
        return min(1.0, n_trials * f_tail(drop / (added * scale), float(added), freedom))

    def supported(self, n_trials: int) -> bool:
        """Return whether the data contradict the setting."""
        fall, errors = self.reduction()
        return fall > LEAST_FALL and errors > STANDARD_ERRORS and self.p_value(n_trials) < FAMILY_P

    def result(self) -> ContradictedSetting:
        """Return it with what it would be."""
        from stiffcal.diagnosis.heldout_error import left_out_rms

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
        )


def _trials(scan: LoadScan, problem: Problem, robot: CompliantRobot, settings: Settings) -> Iterator[_Trial]:
    """Yield the model with each setting changed."""
    whitening = weights_of(scan.fit)
    names = {parameter.name for parameter in scan.fit.parameters if parameter.fixed}
    for name in sorted(names & settings.fixed):
        freed = replace(settings, fixed=settings.fixed - {name})
        fit = fit_observations(problem, robot, freed)
        yield _Trial(SettingKind.FIXED, name, scan, scan_candidates(fit, [], whitening, scan.geometry), freed)
    if not robot.deformed:
        fit = fit_observations(problem, replace(robot, deformed=True), settings)
        yield _Trial(SettingKind.BALANCE, "", scan, scan_candidates(fit, [], whitening, scan.geometry), settings)
    for frame in given_frames(robot, problem.data):
        fit = fit_observations(problem, replace(robot, placed=(frame, *robot.placed)), settings)
        name = f"{frame.effect.name}.{frame.place.frame}"
        yield _Trial(SettingKind.FRAME, name, scan, scan_candidates(fit, [], whitening, scan.geometry), settings)


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
    names = ({setup.tracker: True} if setup.tracker else {}) | targets
    return [placed_frame(name, with_turn) for name, with_turn in names.items() if name not in found]
