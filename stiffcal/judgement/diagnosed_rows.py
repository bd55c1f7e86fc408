"""What is missing from a model of rows, with the models and errors that a person wants to see of it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.diagnosis.of_rows.row_candidates import row_candidates
from stiffcal.diagnosis.of_rows.row_scan import RowScan, scan_row_candidates
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.errors import Progress, no_progress
from stiffcal.judgement.found import Diagnosed, named_effects, superfluous_effects, with_all
from stiffcal.judgement.numbers import ALIKE
from stiffcal.judgement.reading import read_off
from stiffcal.judgement.rows import judge_rows
from stiffcal.kinds.row_search import RowProblem
from stiffcal.model.effect import Effect


@dataclass(frozen=True)
class DiagnosedRows(Diagnosed):
    """What is missing from a model of the rows of one problem."""

    first: RowScan
    """The present model, with each effect at each place as an addition."""
    last: RowScan
    """The same rows with all that is missing in the model; the same scan where nothing is."""
    problem: RowProblem
    """The rows."""

    @property
    def measured_in(self) -> str:
        """By what something would show, in words."""
        return self.problem.folds_in_words

    @property
    def more(self) -> str:
        """Of what more would decide, in words."""
        return self.problem.folds_in_words

    @property
    def differ_between(self) -> str:
        """Between what readings that follow no law differ, in words."""
        return "pass to pass"

    def run_in_words(self, run: int) -> str:
        """Return what is left out with a pass, in words."""
        return self.problem.group_in_words(run)

    def time_would_do(self, candidate: Candidate) -> bool:
        """Return whether what an effect that follows the temperature makes would be made by one that follows the time.

        Beyond what all else that is fitted can make.
        """
        scan = self.last
        placed = next(
            (
                one
                for one in scan.fit.robot.placed
                if (one.effect.name, one.place) == (candidate.effect.name, candidate.place)
            ),
            None,
        )
        if placed is None:
            return False
        timed = self.problem.with_time_for_temperature(placed.effect, placed.place, placed.shape())
        if timed is None:
            return False
        own = scan.ground.state.regressor(placed.effect, placed.place, placed.shape())
        others = [column for column in scan.columns if not any(np.array_equal(column, one) for one in own.columns)]
        basis, _ = np.linalg.qr(scan.space.rows(np.array(others).reshape(-1, *own.fixed.shape)).T)
        made = sum(placed.amplitude(s) * column for s, column in zip(own.symbols, own.columns, strict=True))
        rows = scan.space.rows(np.concatenate([timed.columns, np.asarray(made)[None]]))
        rows = rows - (rows @ basis) @ basis.T
        by_time, _ = np.linalg.qr(rows[:-1].T)
        return bool(np.sum((rows[-1] @ by_time) ** 2) >= ALIKE**2 * np.sum(rows[-1] ** 2))


def diagnose_rows(
    problem: RowProblem, catalogue: Mapping[str, Effect], progress: Progress = no_progress, n_joints: int | None = None
) -> DiagnosedRows:
    """Find what is missing from a model of rows.

    Parameters
    ----------
    problem : the rows and the present model. catalogue : effects by name.
    progress : receives a description of each step.
    n_joints : joints of all problems of the campaign; None: of this one.
    """
    start = time.perf_counter()
    n_joints = n_joints or len(problem.joints)
    judged = judge_rows(problem, catalogue, progress, n_joints)
    reading = read_off(judged)
    fit = problem.fit(problem.robot)
    listed, not_tried = row_candidates(problem, fit.robot, catalogue)
    first = last = scan_row_candidates(fit, listed, n_joints // len(problem.joints))
    effects = named_effects(judged, reading, catalogue)
    found = tuple(one for one in effects if one.candidate.name not in judged.model)
    held = tuple(one for one in effects if one.candidate.name in judged.model)
    if found:
        last = scan_row_candidates(problem.fit(with_all(fit.robot, found, judged.fit.robot)), [])
    superfluous = superfluous_effects(judged, reading, fit.robot)
    seconds = time.perf_counter() - start
    return DiagnosedRows(judged, reading, first, last, found, held, superfluous, tuple(not_tried), seconds, problem)
