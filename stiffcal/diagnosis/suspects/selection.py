"""Which states are compared with each other, and why some or all are not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.diagnosis.answers.suspect_results import NotCheckedReason, RunsNotChecked
from stiffcal.diagnosis.suspects.influence import LEAST_RUNS, most_suspects
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.suspect_kinds import SuspectKind
from stiffcal.model.assembled.composite import CompliantRobot

# Columns of twelve thousand states with six readings and forty parameters take 25 MB; of longer logs every second,
# third … state of a run is taken, which leaves the run's mean misfit as it is.
MOST_STATES = 12_000
LEAST_PER_RUN = 8
# Of four or five runs two that are exchanged are half of all, and an effect that shows in one pose looks like a bump;
# a unit or a sign has to agree in all readings of a run, which no effect does by chance.
RUNS_FOR_ALL_KINDS = 6
KINDS_OF_FEW_RUNS = (SuspectKind.UNIT, SuspectKind.SIGN)


@dataclass(frozen=True)
class Selection:
    """What of a campaign is looked at."""

    index: Integers
    """The states, as positions among all of them; empty where runs cannot be compared."""
    most: int
    """How many runs may be faulty."""
    not_checked: RunsNotChecked | None
    """What is not looked at, and why; None where all is."""

    def admits(self, kind: SuspectKind) -> bool:
        """Return whether so many runs can show this kind of fault."""
        few = self.not_checked is not None and self.not_checked.code is NotCheckedReason.UNIT_AND_SIGN_ONLY
        return not few or kind in KINDS_OF_FEW_RUNS


def select_states(states: LoadStates, robot: CompliantRobot) -> Selection:
    """Return the states of load runs, thinned where they are very many."""
    loads = np.array([run.is_displaced for run in states.runs], dtype=np.bool_)
    # States that are set aside stay in their runs: the readings of two runs are compared state by state.
    index = np.flatnonzero(loads[states.run]) if len(states) else np.zeros(0, dtype=np.int64)
    n_runs = len(np.unique(states.run[index][states.used[index]]))
    most = most_suspects(n_runs)
    nothing = np.zeros(0, dtype=np.int64)
    if not robot.placed:
        return Selection(nothing, 0, not_checked(NotCheckedReason.NO_EFFECT))
    if len(states) and states.absolute.all():
        return Selection(nothing, 0, not_checked(NotCheckedReason.ABSOLUTE_ROWS))
    if len(states) and states.clamped.all():
        return Selection(nothing, 0, not_checked(NotCheckedReason.CLAMPED_RUNS))
    if most == 0:
        return Selection(nothing, 0, not_checked(NotCheckedReason.FEW_RUNS, n_runs))
    if n_runs < RUNS_FOR_ALL_KINDS:
        return Selection(index, most, not_checked(NotCheckedReason.UNIT_AND_SIGN_ONLY, n_runs))
    if len(index) <= MOST_STATES:
        return Selection(index, most, None)
    return _thinned(states, index, most)


def _thinned(states: LoadStates, index: Integers, most: int) -> Selection:
    per_run = max(LEAST_PER_RUN, MOST_STATES // len(np.unique(states.run[index])))
    selected = []
    for run_states in (index[states.run[index] == run] for run in np.unique(states.run[index])):
        evenly = np.unique(
            np.linspace(0.0, len(run_states) - 1.0, min(per_run, len(run_states))).round().astype(np.int64)
        )
        selected.append(np.union1d(run_states[evenly], run_states[states.reference[run_states]]))
    kept = np.sort(np.concatenate(selected))
    if len(kept) == len(index):
        return Selection(index, most, None)
    return Selection(kept, most, not_checked(NotCheckedReason.SOME_STATES, len(kept), len(index)))


def not_checked(code: NotCheckedReason, *numbers: int, reason: str = "") -> RunsNotChecked:
    """Return what was not looked at, in a sentence with its numbers and the reason where there is one."""
    sentences = {
        NotCheckedReason.FEW_RUNS: (
            "runs were not compared: there are {0} load runs, and with fewer than {least} a faulty run cannot be "
            "distinguished from correct ones"
        ),
        NotCheckedReason.UNIT_AND_SIGN_ONLY: (
            "with {0} load runs only a wrong unit or sign in one of them was checked: interchanged logs or an outlier "
            "can be found with {all_kinds} runs or more"
        ),
        NotCheckedReason.SOME_STATES: (
            "runs were compared with each other in {0} of {1} states, evenly spaced in each run: single outliers "
            "among the other states were not checked"
        ),
        NotCheckedReason.ABSOLUTE_ROWS: (
            "rows of absolute runs are not compared one by one: gross mistakes are refused when a table is read, and "
            "a move of the base between two rows is checked"
        ),
        NotCheckedReason.CLAMPED_RUNS: (
            "clamped runs are not compared with each other: a faulty run is named only where its own readings "
            "contradict each other; any other fault shows as a large error of its run in validate --details"
        ),
        NotCheckedReason.NO_EFFECT: "runs were not compared: the model contains no effect",
        NotCheckedReason.NO_FIT: "runs were not compared: the model cannot be fitted to them",
    }
    sentence = sentences[code].format(*numbers, least=LEAST_RUNS, all_kinds=RUNS_FOR_ALL_KINDS)
    return RunsNotChecked(code=code, sentence=f"{sentence}: {reason}" if reason else sentence)
