"""The searches of kinds of experiment whose readings are no load states, for ``diagnose``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from stiffcal.diagnosis.merging import PartialDiagnosis
from stiffcal.workflow.evidence import row_refit_columns
from stiffcal.workflow.experiments import measured_runs
from stiffcal.workflow.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.arrays import Integers
    from stiffcal.diagnosis.refits import Refit, RefitSummary
    from stiffcal.diagnosis.row_document import RowSearch
    from stiffcal.workflow.evidence import Columns


@dataclass
class RowDiagnoses:
    """The answers of all searches, with what is stored of them."""

    parts: list[PartialDiagnosis] = field(default_factory=list)
    """One a search; empty where the campaign contains no such readings."""
    refits: list[Refit] = field(default_factory=list)
    """Refits of all searches."""
    index: list[Integers] = field(default_factory=list)
    """The rows of each refit."""

    @property
    def entries(self) -> list[RefitSummary]:
        """The summaries of the refits."""
        return [refit.summary for refit in self.refits]

    def columns(self) -> Columns:
        """Return the columns of the table ``row_refits``."""
        return row_refit_columns(self.refits, self.index)


def diagnose_rows(data: Ingested, context: RunContext) -> RowDiagnoses:
    """Return the answer of every search of such readings."""
    from stiffcal.diagnosis.ranking import effect_at
    from stiffcal.diagnosis.redundant import redundant_effects
    from stiffcal.diagnosis.row_context import RowSearchContext
    from stiffcal.diagnosis.row_document import row_diagnosis, too_few_folds
    from stiffcal.diagnosis.row_refits import row_refits_of
    from stiffcal.diagnosis.search import search_in
    from stiffcal.experiments import all_kinds
    from stiffcal.model.campaign_effects import all_effects

    measured = measured_runs(data)
    problems = [(kind, problem) for kind in all_kinds() for problem in kind.problems(measured)]
    answers = RowDiagnoses()
    if not problems:
        return answers
    catalogue, _ = all_effects(data.campaign)
    for kind, problem in problems:
        fit = problem.fit(problem.robot)
        refused = too_few_folds(problem, fit)
        if refused is not None:
            answers.parts.append(PartialDiagnosis(refused, (), len(fit.residual), problem.joints, problem.subject))
            continue
        bench = RowSearchContext(problem, catalogue, len(problems), basic=frozenset(kind.basic_effects()))
        search: RowSearch = search_in(bench, problem.robot, context.progress)
        redundant = redundant_effects(bench, search.first.fit, kind.basic_effects())
        result = replace(row_diagnosis(bench, search), superfluous=[effect_at(candidate) for candidate in redundant])
        falls = tuple(missing.judgement.fall for missing in search.found)
        answers.parts.append(PartialDiagnosis(result, falls, len(fit.residual), problem.joints, problem.subject))
        refits = list(row_refits_of(search, problem, result))
        answers.refits += refits
        answers.index += [problem.index] * len(refits)
    return answers
