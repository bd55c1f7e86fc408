"""The diagnosis of clamped runs of several joints: one search each, one answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stiffcal.diagnosis.merging import PartialDiagnosis
from stiffcal.diagnosis.refits import RefitSummary, refits_of
from stiffcal.workflow.evidence import Columns, evidence_of, refit_columns
from stiffcal.workflow.load_search import diagnosis_of, search_now
from stiffcal.workflow.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.arrays import Integers
    from stiffcal.diagnosis.drive_parts import DrivePart


@dataclass(frozen=True)
class DriveDiagnoses:
    """The answers of all joints, with what is stored of them."""

    parts: list[PartialDiagnosis]
    """One a joint."""
    evidence: Columns
    """The table ``evidence``."""
    refits: Columns
    """The table ``refits``."""
    refit_entries: list[RefitSummary]
    """Of the refits, in the order of their table."""


def diagnose_drives(
    data: Ingested, drives: Sequence[DrivePart], index: Integers, loss: str, context: RunContext
) -> DriveDiagnoses:
    """Search what each drive lacks.

    Parameters
    ----------
    data : the campaign, without suspects.
    drives : its parts.
    index : (n,) its states in the store's table.
    loss : of the fit.
    context : store, progress and so on.
    """
    answers = []
    for number, drive in enumerate(drives):
        context.progress(f"joint {drive.joint}, separately", 0.1 + 0.8 * number / len(drives))
        answers.append(_diagnose_drive(data, drive, len(drives), index, loss))
    return DriveDiagnoses(
        [answer.part for answer in answers],
        _stacked([answer.evidence for answer in answers]),
        _stacked([answer.refits for answer in answers]),
        [entry for answer in answers for entry in answer.refit_entries],
    )


@dataclass(frozen=True)
class _DriveAnswer:
    """The answer of one joint, with what is stored of it, as `DriveDiagnoses`."""

    part: PartialDiagnosis
    evidence: Columns
    refits: Columns
    refit_entries: list[RefitSummary]


def _diagnose_drive(data: Ingested, drive: DrivePart, n_searches: int, index: Integers, loss: str) -> _DriveAnswer:
    """Search what one drive lacks; parameters as in `diagnose_drives`."""
    import numpy as np

    chosen = np.flatnonzero(drive.chosen)
    own = replace(data, states=data.states.select(drive.chosen))
    search = search_now(own, loss, RunContext(), drive.robot, n_searches)
    diagnosis = diagnosis_of(own, search)
    evidence, summaries = evidence_of(own, search)
    evidence["state"] = chosen[np.asarray(evidence["state"], dtype=np.int64)]
    refits = list(refits_of(search, diagnosis))
    observations = search.first.fit.data
    subject, text = drive.subject, diagnosis.summary
    in_words = f"{subject.title} of joint {drive.joint}: {text[:1].lower()}{text[1:]}"
    part = PartialDiagnosis(
        replace(diagnosis, evidence=summaries, summary=in_words),
        tuple(missing.judgement.fall for missing in search.found),
        len(own.states),
        (drive.joint,),
        subject,
        search.explained if search.tried else None,
    )
    columns = refit_columns(own.states, observations, refits, index[chosen][observations.index])
    return _DriveAnswer(part, evidence, columns, [refit.summary for refit in refits])


def _stacked(tables: Sequence[Columns]) -> Columns:
    """Return tables one below the other, their entries counted on."""
    import numpy as np

    result: Columns = {}
    first = np.cumsum([0, *(int(np.max(table["entry"], initial=-1)) + 1 for table in tables)])
    for name in tables[0]:
        columns = [np.asarray(table[name]) for table in tables]
        if name == "entry":
            columns = [column + offset for column, offset in zip(columns, first, strict=False)]
        result[name] = np.concatenate(columns)
    return result
