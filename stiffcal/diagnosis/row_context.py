"""What a search in rows that are no load states works on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stiffcal.diagnosis.candidates import Candidate, stands_in_the_way
from stiffcal.diagnosis.results import ResidualDependence, UntestableEffect
from stiffcal.diagnosis.row_scan import RowScan, scan_row_candidates
from stiffcal.diagnosis.row_structure import what_rows_follow
from stiffcal.diagnosis.search_context import SearchContext
from stiffcal.experiments.row_search import RowFit, RowProblem, merged_lacking
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import Effect


@dataclass(frozen=True)
class RowSearchContext(SearchContext[RowScan, RowFit]):
    """What a search in rows of one problem works on."""

    problem: RowProblem
    catalogue: Mapping[str, Effect]
    n_searches: int = 1
    """Problems that are searched together."""

    def fit(self, robot: CompliantRobot) -> RowFit:
        """Fit a model."""
        return self.problem.fit(robot)

    def scan(self, fit: RowFit, candidates: Sequence[Candidate], like: RowFit | None = None) -> RowScan:
        """Try candidates as additions to a fit."""
        return scan_row_candidates(fit, candidates, self.n_searches, like)

    def fit_of(self, scan: RowScan) -> RowFit:
        """Return the fit that a scan is of."""
        return scan.fit

    def candidates(self, robot: CompliantRobot) -> tuple[list[Candidate], list[UntestableEffect]]:
        """Return the effects that can be added to a model, and those that these rows cannot show, with the reason."""
        in_model = {(placed.effect.name, placed.place) for placed in robot.placed}
        begun = {place for _, place in in_model}
        candidates: list[Candidate] = []
        lacking: dict[str, list[str]] = {}
        for effect in self.catalogue.values():
            for place in self.problem.places(effect):
                if (effect.name, place) in in_model or stands_in_the_way(effect, place, robot):
                    continue
                if self.basic and effect.name not in self.basic and place not in begun:
                    continue
                reason = self.problem.lacking(effect, place)
                if reason is not None:
                    lacking.setdefault(effect.name, []).append(reason)
                else:
                    candidates.append(Candidate(effect, place, len(effect.parameters)))
        return candidates, [UntestableEffect(name, text) for name, text in merged_lacking(lacking)]

    def follows(self, scan: RowScan) -> list[ResidualDependence]:
        """Return what the residual of a scan's model follows, largest share first."""
        return what_rows_follow(scan, self.problem)
