"""The diagnosis of kinds of experiment whose readings are no load states."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stiffcal.diagnosis.merging import PartialDiagnosis
from stiffcal.errors import part_of
from stiffcal.stages.diagnoses.stored_curves import row_refit_columns
from stiffcal.stages.experiments import measured_runs
from stiffcal.stages.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.arrays import Integers
    from stiffcal.diagnosis.refits.refits import Refit, RefitSummary
    from stiffcal.stages.diagnoses.stored_curves import Columns


@dataclass
class RowDiagnoses:
    """The answers of all problems, with what is stored of them."""

    parts: list[PartialDiagnosis] = field(default_factory=list)
    """One each; empty where the campaign contains no such readings."""
    refits: list[Refit] = field(default_factory=list)
    """Refits of all."""
    index: list[Integers] = field(default_factory=list)
    """The rows of each refit."""

    @property
    def entries(self) -> list[RefitSummary]:
        """The summaries of the refits."""
        return [refit.summary for refit in self.refits]

    def columns(self) -> Columns:
        """Return the columns of the table ``row_refits``."""
        return row_refit_columns(self.refits, self.index)


def diagnoses_of_rows(data: Ingested, context: RunContext) -> RowDiagnoses:
    """Return the answer of each problem of such readings."""
    from stiffcal.diagnosis.of_rows.row_refits import row_refits_of
    from stiffcal.judgement.diagnosed_rows import diagnose_rows
    from stiffcal.judgement.row_document import row_diagnosis, too_few_folds
    from stiffcal.kinds import all_kinds
    from stiffcal.model.catalogue.campaign_effects import all_effects

    measured = measured_runs(data)
    problems = [problem for kind in all_kinds() for problem in kind.problems(measured)]
    answers = RowDiagnoses()
    if not problems:
        return answers
    catalogue, _ = all_effects(data.campaign)
    for number, problem in enumerate(problems):
        progress = part_of(context.progress, number / len(problems), (number + 1) / len(problems))
        fit = problem.fit(problem.robot)
        refused = too_few_folds(problem, fit)
        if refused is not None:
            answers.parts.append(PartialDiagnosis(refused, (), fit.rows.residual.size, problem.joints, problem.subject))
            continue
        found = diagnose_rows(problem, catalogue, progress, sum(len(one.joints) for one in problems))
        result = row_diagnosis(found)
        sizes = tuple(one.group.size for one in found.found)
        answers.parts.append(
            PartialDiagnosis(result, sizes, fit.rows.residual.size, problem.joints, problem.subject, found.explained)
        )
        refits = list(row_refits_of(found.first, found.last if found.found else None, problem, result))
        answers.refits += refits
        answers.index += [problem.index] * len(refits)
    return answers
