"""The catalogue as additions to a model of rows that are no load states: torque over motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.base_rows import BaseRows, in_order
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.scan import Scan, scan_rows, try_candidate
from stiffcal.diagnosis.thresholds import MANY_ROW_SHAPES
from stiffcal.estimation.constants import without_constants
from stiffcal.kinds.row_search import RowFit
from stiffcal.measurements.load_states import members_of


@dataclass(frozen=True)
class RowProjection:
    """Whitens rows (q, 1, k) and takes their free constants out."""

    sigma: Floats
    """(k,) standard uncertainty of each row."""
    members: tuple[Integers, ...]
    """Rows of each free constant."""

    @classmethod
    def of(cls, fit: RowFit) -> RowProjection:
        """Prepare."""
        numbers = np.unique(fit.constant[fit.constant >= 0])
        return cls(fit.sigma, tuple(np.flatnonzero(fit.constant == number) for number in numbers))

    @property
    def n_constants(self) -> int:
        """How many constants are free."""
        return len(self.members)

    def rows(self, stack: Floats) -> Floats:
        """Return (q, k) whitened rows."""
        white = np.array(stack[:, 0] / self.sigma, dtype=np.float64)
        for members in self.members:
            white[:, members] = without_constants(white[:, members], 1.0 / self.sigma[members, None])
        return white


@dataclass(frozen=True)
class RowScan(Scan):
    """All candidates as additions to one model of rows."""

    fit: RowFit
    """The model to which they are added."""
    space: RowProjection
    """Whitened rows."""
    ground: BaseRows
    """The model's rows, to which more can be added."""

    def mean_square(self) -> float:
        """Return the residuals' mean square, in the measure's unit."""
        return float(np.sum(self.residual**2))


def scan_row_candidates(fit: RowFit, candidates: Sequence[Candidate], n_searches: int = 1) -> RowScan:
    """Try every candidate as an addition to a fit of rows.

    Parameters
    ----------
    fit : the present model's.
    candidates : who is tried.
    n_searches : searches of other rows that are made with this one; chance has as many more opportunities.
    """
    space = RowProjection.of(fit)
    folds = members_of(fit.fold)
    rows = fit.rows
    ground = BaseRows.of(fit.maker, space, rows.stack, folds, *rows.steps_within, rows.prior)
    dof = rows.residual.size - space.n_constants
    trials, n_tried = scan_rows(
        ground, candidates, try_one=lambda candidate: try_candidate(candidate, ground, MANY_ROW_SHAPES)
    )
    return RowScan(
        fit=fit, base=in_order(ground.base, ground.order), trials=trials, folds=tuple(folds), groups=ground.groups,
        dof=dof, n_columns=len(rows.values), n_tried=n_tried * n_searches, space=space, columns=rows.derivative,
        residual=rows.residual, bounds=rows.steps_within, outside=ground.outside, ground=ground,
    )  # fmt: skip
