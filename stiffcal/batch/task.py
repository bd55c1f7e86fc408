"""One campaign of a batch: ingest, identify, validate, report, and what came of it as a small result.

Tasks and outcomes go as JSON through a pipe to another process, or to another machine.
"""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from stiffcal import __version__
from stiffcal.batch.author_choices import author_choices
from stiffcal.campaign.manifest.thresholds import ThresholdsFile
from stiffcal.commands.report import REPORT_FILE, report_campaign
from stiffcal.documents import document_of
from stiffcal.errors import Fault, InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.fault_log import write_fault_log
from stiffcal.files import read_regular
from stiffcal.model.catalogue.plugin_loading import plugin_fault
from stiffcal.results.batch_results import (
    BROKEN,
    FAULT,
    HELD,
    NOT_HELD,
    STEPS,
    AuthorChoice,
    BatchStep,
    BatchTask,
    CampaignOutcome,
    IdentifiedStiffness,
    outcome_of,
)
from stiffcal.results.error_result import FaultEntry
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.stages.diagnoses.current import shifted_by_missing
from stiffcal.stages.fit import current_fit, fit_now, store_fit
from stiffcal.stages.steps import (
    VALIDATE,
    Ingested,
    RunContext,
    key_of,
    key_of_table,
    stored_fit,
    stored_result,
    stored_validation,
    up_to_date_states,
)
from stiffcal.stages.stored_types import StoredReport
from stiffcal.stages.validation import current_validation, validate_now, with_present_verdict
from stiffcal.store.index import FOREIGN
from stiffcal.store.origin import committed_by_this_process
from stiffcal.trust.foreign_content import fault_of_foreign_content, use_own_results

REPORT = "report"


OnStep = Callable[[str, dict[str, BatchStep]], None]
"""`on_step(name, finished)`: a step begins, others have ended."""


def no_report_of_steps(name: str, finished: dict[str, BatchStep]) -> None:
    """Let a step pass; the default of `run_task`."""


@dataclass
class _Run:
    """What a task has done so far."""

    steps: dict[str, BatchStep] = field(default_factory=dict)
    """Finished steps, each with its reason ("" where nothing had to be done) and its time, s."""
    step: str = STEPS[0]
    """The step that runs now."""
    why: str = ""
    """Its reason, "" where nothing has to be done."""
    began: bool = False
    """True where the step had something to do."""
    choices: list[AuthorChoice] = field(default_factory=list)
    """Choices of the campaign's author, as soon as they are known."""
    on_step: OnStep = no_report_of_steps
    """Called at the beginning of each step."""

    def starting(self, step: str, reason: str) -> None:
        """Take note of why a step, or an earlier one that it needs, is run."""
        self.began, self.why = True, reason

    def notify(self, text: str) -> None:
        """Keep the message of a step that had nothing to do."""
        if not self.began:
            self.why = text

    @contextmanager
    def doing(self, step: str) -> Iterator[None]:
        """Time a step; what `starting` was given meanwhile is why it ran."""
        self.step, self.why, self.began, began = step, "", False, time.monotonic()
        self.on_step(step, self.steps)
        yield
        self.steps[step] = BatchStep(done=self.began, why=self.why, seconds=round(time.monotonic() - began, 3))


def run_task(task: BatchTask, on_step: OnStep = no_report_of_steps) -> CampaignOutcome:
    """Run a task; whatever goes wrong becomes part of its outcome.

    Parameters
    ----------
    task : the campaign. on_step : called at the beginning of each step.

    Returns
    -------
    CampaignOutcome
        With the digests of the generations that were committed.
    """
    began, run, before = time.monotonic(), _Run(on_step=on_step), len(committed_by_this_process())
    use_own_results()
    try:
        outcome = _all_steps(task, run)
    except InputError as error:
        first, *further = error.faults
        outcome = replace(outcome_of(task, BROKEN, first), others=[FaultEntry.of(fault) for fault in further])
    except (Exception, SystemExit) as error:
        wrong = plugin_fault(error) or (fault_of_foreign_content(error) if isinstance(error, Exception) else None)
        if wrong is not None:
            outcome = outcome_of(task, BROKEN, wrong.faults[0])
        elif isinstance(error, SystemExit):
            raise
        else:
            outcome = outcome_of(task, FAULT, _fault(error, task.folder))
    return replace(
        outcome,
        steps=run.steps,
        failed_at=None if outcome.error is None else run.step,
        seconds=round(time.monotonic() - began, 3),
        memory_bytes=_peak_memory(),
        choices=run.choices,
        generations=list(committed_by_this_process()[before:]),
    )


def _all_steps(task: BatchTask, run: _Run) -> CampaignOutcome:
    context = RunContext(
        store=task.store,
        notify=run.notify,
        on_step=run.starting,
        reach=tuple(Path(path) for path in task.allowed_paths),
        thorough=True,
        overwrite=task.overwrite,
    )
    file = None if task.thresholds is None else ThresholdsFile.model_validate(task.thresholds)
    with run.doing("ingest"):
        data = up_to_date_states(Path(task.folder), context)
        run.choices = author_choices(data.campaign, file, _earlier_thresholds(data))
    with run.doing("identify"):
        stored = stored_fit(data.store)
        # A fit with the robust loss counts as present too: the user asked for it.
        loss = stored.loss if stored else "linear"
        identified, fit = current_fit(data, loss), None
        if identified is None:
            run.starting("identify", "the model or the load states have changed" if stored else "nothing is fitted yet")
            fit = fit_now(data, loss, context)
            identified = store_fit(data, fit, loss)
    with run.doing("validate"):
        current = current_validation(data, identified)
        if current is None:
            run.starting("validate", "the present fit is not validated yet")
            current = validate_now(data, identified, context, fit)
        validation = with_present_verdict(data, identified, current, context, file)
    outcome = _with_numbers(outcome_of(task, HELD), data, identified, validation)
    if task.report:
        with run.doing("report"):
            outcome = replace(outcome, report=_report(data, task, context, run))
    return outcome


def _earlier_thresholds(data: Ingested) -> dict[str, object] | None:
    """Return the campaign's own thresholds at its last validation; None where that is nobody's whom the user trusts."""
    stored = stored_validation(data.store)
    return None if stored is None or data.store.origin_of(VALIDATE) == FOREIGN else stored.thresholds


def _with_numbers(
    outcome: CampaignOutcome, data: Ingested, identified: IdentifyResult, validation: ValidateResult
) -> CampaignOutcome:
    shifted = shifted_by_missing(data, identified)
    return replace(
        outcome,
        name=data.campaign.name,
        state=HELD if validation.passed else NOT_HELD,
        n_states=identified.n_states,
        n_runs=identified.n_runs,
        rms=validation.rms,
        noise=validation.noise,
        relative=validation.relative,
        stiffness=[
            IdentifiedStiffness(
                name=parameter.name,
                where=parameter.where,
                stiffness=parameter.known_stiffness,
                stiffness_std=parameter.known_stiffness_std,
                shifted=None if shifted is None else parameter.name in shifted,
            )
            for parameter in identified.parameters
            if parameter.is_compliance
        ],
        checks=validation.checks,
        failed=validation.failed,
        not_judged=validation.not_judged,
        warnings=list(dict.fromkeys([*identified.warnings, *validation.warnings])),
        suspects=identified.suspects,
        origin=data.store.origin_of(VALIDATE),
    )


def _report(data: Ingested, task: BatchTask, context: RunContext, run: _Run) -> str:
    """Write the PDF where it is not there, or not of what the store holds now; return its file."""
    folder = data.campaign.folder
    file = Path(task.report_file) if task.report_file else folder / REPORT_FILE
    key = _report_key(data)
    # A stranger can compute the key too, and deliver a PDF of their own with it.
    foreign = data.store.origin_of(REPORT) == FOREIGN
    then = None if foreign else stored_result(data.store, REPORT, StoredReport)
    if then is not None and then.key == key and then.sha256 == _digest(file):
        return str(file)
    run.starting("report", "there is no report yet" if not file.exists() else "the report belongs to an earlier result")
    file.parent.mkdir(parents=True, exist_ok=True)
    report_campaign(
        folder, RunContext(store=context.store, reach=context.reach, overwrite=context.overwrite), output=file
    )
    data.commit({}, {REPORT: document_of(StoredReport(key=key, sha256=_digest(file)))}, command="batch")
    return str(file)


def _report_key(data: Ingested) -> str:
    """Return a hash of all that a report is made of."""
    campaign = data.campaign
    with data.store.snapshot() as snapshot:
        documents = {name: snapshot.read_document(name) for name in snapshot.documents if name != REPORT}
    files = [campaign.manifest.model_dump(mode="json"), campaign.robot.model_dump(mode="json")]
    return key_of(key_of_table(data.table), documents, files)


def _digest(file: Path) -> str | None:
    return hashlib.sha256(read_regular(file)).hexdigest() if file.is_file() else None


def _fault(error: Exception, folder: str) -> Fault:
    """Write the traceback of an internal fault to a log file; return the fault."""
    reason = f"internal fault, not your input: {type(error).__name__}: {' '.join(str(error).split())}"
    log = write_fault_log(error, __version__, f"stiffcal batch {folder}")
    mend = (
        f"please report it with the log file {log}"
        if log
        else f"{command_line('run', Path(folder), '--debug')} shows where"
    )
    return Fault(FaultCode.INTERNAL_FAULT, folder, "", reason, mend)


def _peak_memory() -> int | None:
    """Return the largest size that this process has had in memory, bytes; None where the system does not provide it."""
    if sys.platform == "win32":
        return None
    # The value of getrusage on Linux begins with the size of the process that started this one.
    status = Path("/proc/self/status")
    if status.exists():
        lines = status.read_text(encoding="ascii", errors="replace").splitlines()
        line_of_peak = next((line for line in lines if line.startswith("VmHWM:")), None)
        return None if line_of_peak is None else 1024 * int(line_of_peak.split()[1])
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
