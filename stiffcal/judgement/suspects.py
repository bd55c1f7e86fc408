"""Runs that disagree with all the others, with the lines of campaign.toml that leave them out."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.escapes import toml_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from stiffcal.campaign.loading import Campaign
    from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked, Suspect
    from stiffcal.diagnosis.suspects.find import Suspicion
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.identification.fitting.identify import Settings
    from stiffcal.judgement.diagnosed import DiagnosedStates
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.mistakes.places.mistake import MovedRows
    from stiffcal.model.assembled.composite import CompliantRobot


def suspicion_of(
    campaign: Campaign,
    states: LoadStates,
    loss: str = "linear",
    progress: Progress = no_progress,
    present: Fit | None = None,
) -> Suspicion:
    """Hold each run of a campaign against all the others, with the campaign's present model.

    Parameters
    ----------
    campaign : the folder's three files. states : its load states.
    loss : as for a fit. progress : called with what is being done.
    present : the fit of these states with this model and loss, where it is at hand.

    Returns
    -------
    Suspicion
        Nothing is judged where the model cannot be fitted; why not is in ``not_checked``.

    Raises
    ------
    InputError : something else is wrong, such as code of the campaign that fails.
    """
    from stiffcal.diagnosis.suspects import find

    def search(states: LoadStates, robot: CompliantRobot, settings: Settings) -> Suspicion:
        return find.find_suspects(states, robot, settings, progress, present)

    return _searched(campaign, states, loss, progress, search, present)


def misplaced_in(campaign: Campaign, states: LoadStates, loss: str, progress: Progress) -> Suspicion:
    """Return the runs whose places are not where their joint angles put them, and a move of the base.

    Displacements say nothing of these: they are left out before anything is judged. Whether runs and absolute rows are
    off is part of what is judged. Parameters as of `suspicion_of`.
    """
    from stiffcal.diagnosis.answers.suspect_results import NotCheckedReason
    from stiffcal.diagnosis.suspects.find import find_misplaced

    suspicion = _searched(campaign, states, loss, progress, find_misplaced)
    open_rows = suspicion.not_checked is not None and suspicion.not_checked.code is NotCheckedReason.ABSOLUTE_ROWS
    return replace(suspicion, not_checked=None) if open_rows else suspicion


def _searched(
    campaign: Campaign,
    states: LoadStates,
    loss: str,
    progress: Progress,
    search: Callable[[LoadStates, CompliantRobot, Settings], Suspicion],
    present: Fit | None = None,
) -> Suspicion:
    """Return what a search finds, with a move of the base; why nothing was searched where no model can be fitted."""
    from stiffcal.diagnosis.answers.suspect_results import NotCheckedReason
    from stiffcal.diagnosis.suspects.find import Suspicion
    from stiffcal.diagnosis.suspects.moved_rows import moved_rows
    from stiffcal.diagnosis.suspects.selection import not_checked
    from stiffcal.identification.fitting.identify import Settings, identify_parameters
    from stiffcal.identification.fitting.not_fitted import is_not_fitted
    from stiffcal.model.assembled.assembly import fixed_parameters
    from stiffcal.model.catalogue.campaign_effects import placed_robot

    try:
        settings = Settings(loss=loss, fixed=fixed_parameters(campaign.model))
        robot = placed_robot(campaign)
        suspicion = search(states, robot, settings)
        if states.absolute.any():
            fit = present or identify_parameters(states, robot, settings, progress)
            suspicion = replace(suspicion, moved=moved_rows(fit, states))
        return suspicion
    except InputError as error:
        if not is_not_fitted(error):
            raise
        return Suspicion(not_checked=not_checked(NotCheckedReason.NO_FIT, reason=error.reason))


def described_doubts(found: DiagnosedStates, campaign: Campaign, loss: str) -> list[Suspect]:
    """Return the runs and readings that are probably off as results, each with the lines that leave it out.

    Parameters
    ----------
    found : what is missing. campaign : the folder's three files. loss : of the fit.
    """
    from stiffcal.diagnosis.suspects.find import described_runs
    from stiffcal.diagnosis.suspects.words import suspects_of
    from stiffcal.identification.fitting.identify import Settings
    from stiffcal.judgement.document import explaining_run
    from stiffcal.judgement.doubts import reading_off
    from stiffcal.judgement.numbers import FIRM
    from stiffcal.model.assembled.assembly import fixed_parameters

    states, suspects = found.states, []
    runs = [off.run for off in found.doubted if off.state is None]
    if runs:
        settings = Settings(loss=loss, fixed=fixed_parameters(campaign.model))
        suspicion = described_runs(states, found.last.fit.robot, settings, runs)
        probability = {off.run: p for off, p in found.doubted.items() if off.state is None}
        suspects += [
            replace(
                suspect,
                probability=probability[one.run],
                firm=probability[one.run] >= FIRM,
                explained_by=explaining_run(found, one.run),
            )
            for one, suspect in zip(suspicion.suspects, suspects_of(suspicion, states, campaign.chain), strict=True)
        ]
    suspects = [_inside_a_run(suspect, found) for suspect in suspects]
    suspects += [reading_off(found, off, p) for off, p in found.doubted.items() if off.state is not None]
    return [replace(suspect, exclude=_exclusion(suspect, campaign, states)) for suspect in suspects]


def _inside_a_run(suspect: Suspect, found: DiagnosedStates) -> Suspect:
    """Return a suspect with what probably went wrong inside its run, where no mistake of all of it explains it."""
    from stiffcal.mistakes.suspect_kinds import SuspectKind

    mistakes = {found.states.runs[off.run].name: one for off, one in found.judged.mistakes.items()}
    if suspect.run not in mistakes or suspect.kind not in (SuspectKind.UNKNOWN, SuspectKind.BUMP):
        return suspect
    mistake = mistakes[suspect.run]
    return replace(suspect, kind=mistake.kind, likely=mistake.likely)


def described(suspicion: Suspicion, campaign: Campaign, states: LoadStates) -> list[Suspect]:
    """Return the suspects as results, each with the lines that leave it out.

    Parameters
    ----------
    suspicion : what was found in these states. campaign : the folder's three files.
    """
    from stiffcal.diagnosis.suspects.words import suspect_of_move, suspects_of

    suspects = suspects_of(suspicion, states, campaign.chain)
    suspects = [replace(suspect, exclude=_exclusion(suspect, campaign, states)) for suspect in suspects]
    if suspicion.moved is not None:
        mistake, moved = suspicion.moved
        suspects.append(_with_exclusion(suspect_of_move(mistake, moved, states), moved, campaign, states))
    return suspects


def _with_exclusion(suspect: Suspect, moved: MovedRows, campaign: Campaign, states: LoadStates) -> Suspect:
    """Return the suspect with the lines that leave out the rows on the shorter side of the move."""
    from stiffcal.campaign.checks.absolute_checks import absolute_sources
    from stiffcal.diagnosis.answers.suspect_results import exclusion_lines

    holding = [
        name
        for name, source in campaign.manifest.sources.items()
        if source.is_states and name in absolute_sources(campaign.manifest) and source.body_poses()
    ]
    if not holding:
        return suspect
    name, why = holding[0], "before or after the base was moved"
    by_run: dict[str, list[int]] = {}
    for k in moved.leave_out.nonzero()[0]:
        run = states.runs[states.run[k]]
        # rows of a table of several runs are counted in the table
        in_file = "" if campaign.manifest.sources[name].run is not None else run.of or run.name
        by_run.setdefault(in_file, []).append(int(states.row[k]))
    lines = [line for run, rows in by_run.items() for line in exclusion_lines(name, rows, why, run)]
    return replace(suspect, exclude=lines)


def suspects_in(
    campaign: Campaign,
    states: LoadStates,
    loss: str = "linear",
    progress: Progress = no_progress,
    present: Fit | None = None,
) -> tuple[list[Suspect], RunsNotChecked | None]:
    """Return the runs of a campaign that disagree with all the others, and what was not compared.

    Parameters as of `suspicion_of`.
    """
    suspicion = suspicion_of(campaign, states, loss, progress, present)
    return described(suspicion, campaign, states), suspicion.not_checked


def _exclusion(suspect: Suspect, campaign: Campaign, states: LoadStates) -> list[str]:
    """Return the lines of campaign.toml that leave a suspect out."""
    from stiffcal.diagnosis.answers.suspect_results import exclusion_lines
    from stiffcal.mistakes.suspect_kinds import SuspectKind

    kind = "" if suspect.kind is SuspectKind.UNKNOWN else f": {suspect.kind}"
    why = f"disagrees with the other runs{kind}"
    tables = [(name, source) for name, source in campaign.manifest.sources.items() if source.is_states]
    if not tables:
        # of logs that were sampled in time the rows are many; a run that is held out is not fitted
        return ["[[runs]]", toml_text.pair("id", suspect.run), "holdout = true"]
    name, source = tables[0]
    names = [run.name for run in states.runs]
    in_run = states.row[states.run == names.index(suspect.run)]
    rows = [suspect.row] if suspect.row is not None else [int(row) for row in in_run]
    return exclusion_lines(name, rows, why, "" if source.run is not None else suspect.run)
