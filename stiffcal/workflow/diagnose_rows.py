"""The searches of kinds of experiment whose readings are no load states, for ``diagnose``."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal.diagnosis.merging import PartialDiagnosis, Subject
from stiffcal.workflow.experiments import measured_runs
from stiffcal.workflow.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.diagnosis.row_document import RowSearch


def diagnose_rows(data: Ingested, context: RunContext) -> list[PartialDiagnosis]:
    """Return the answer of every search of such readings; empty where the campaign holds none."""
    from stiffcal.diagnosis.ranking import effect_at
    from stiffcal.diagnosis.redundant import redundant_effects
    from stiffcal.diagnosis.row_context import RowSearchContext
    from stiffcal.diagnosis.row_document import row_diagnosis, too_few_folds
    from stiffcal.diagnosis.search import search_in
    from stiffcal.experiments import all_kinds
    from stiffcal.model.campaign_effects import all_effects

    measured = measured_runs(data)
    problems = [(kind, problem) for kind in all_kinds() for problem in kind.problems(measured)]
    if not problems:
        return []
    catalogue, _ = all_effects(data.campaign)
    parts = []
    for kind, problem in problems:
        fit = problem.fit(problem.robot)
        refused = too_few_folds(problem, fit)
        if refused is not None:
            parts.append(PartialDiagnosis(refused, (), len(fit.residual), problem.joints, Subject.MOTION))
            continue
        bench = RowSearchContext(problem, catalogue, len(problems))
        search: RowSearch = search_in(bench, problem.robot, context.progress)
        redundant = redundant_effects(bench, search.first.fit, kind.basic_effects())
        result = replace(row_diagnosis(bench, search), superfluous=[effect_at(candidate) for candidate in redundant])
        falls = tuple(missing.judgement.fall for missing in search.found)
        parts.append(PartialDiagnosis(result, falls, len(fit.residual), problem.joints, Subject.MOTION))
    return parts
