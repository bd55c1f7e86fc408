"""`stiffcal run`: check to report in one go."""

from __future__ import annotations

from stiffcal.cli.answers import answering
from stiffcal.cli.endings import NOT_HELD, OK
from stiffcal.cli.options import HERE, AsJson, Folder, Overwrite, StoreAt
from stiffcal.commands.next_step import following
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.presentation.values import NextStep
from stiffcal.results.next_step import Step
from stiffcal.show.options import ShowOptions


def run(folder: Folder = HERE, as_json: AsJson = False, store: StoreAt = None, overwrite: Overwrite = False) -> int:
    """Check, ingest, identify, validate, diagnose, report and view in one go.

    Example: stiffcal run demo
    """
    with answering(as_json) as answer:
        from stiffcal.commands.run import run_campaign
        from stiffcal.stages.steps import RunContext

        context = RunContext(store=store, progress=answer.progress, notify=answer.notify, overwrite=overwrite)
        try:
            result = run_campaign(folder, context)
        except InputError as error:
            logs = ("sources", "runs")
            if all(fault.code is FaultCode.FILE_MISSING and fault.place.startswith(logs) for fault in error.faults):
                # nothing is wrong but that the logs are not there yet
                error.add_note(NextStep(command_line("check", folder, store=store)).text)
            raise
        then = following(folder, store, Step.DIAGNOSE, done={Step.REPORT})
        answer.show(result, then, ShowOptions(folder=folder, store=store))
    return OK if result.passed else NOT_HELD
