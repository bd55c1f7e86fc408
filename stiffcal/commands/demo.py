"""The whole loop on a bundled example: a robot with a hidden effect, found and added (campaigns/demo)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from stiffcal.commands.history import read_history
from stiffcal.commands.improve import improve_campaign
from stiffcal.commands.report import REPORT_FILE
from stiffcal.commands.run import run_campaign
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.commands.view import VIEW_FILE
from stiffcal.results.improve_results import ImproveStep
from stiffcal.stages.run_result import RunResult
from stiffcal.stages.steps import RunContext
from stiffcal.trust.output_kinds import PAGE, REPORT
from stiffcal.trust.output_kinds import README as EXPLANATION
from stiffcal.trust.outputs import check_not_foreign, write_output

README = "README.md"
EXAMPLE = Path(__file__).parent / "example"
"""A copy of campaigns/demo, so that an installed package has it too; `make example` renews it, a test holds it."""


def run_demo(
    folder: Path, context: RunContext | None = None, notify_step: Callable[[ImproveStep], None] | None = None
) -> RunResult:
    """Copy the example to a folder, make its logs from their seed, find and add what its model lacks, and report.

    Parameters
    ----------
    folder : where to; made if it does not exist, taken again if it is an earlier demo.
    context : progress and so on.
    notify_step : called with each model once its error in held-out poses is known.

    Returns
    -------
    RunResult
        As `run_campaign`, of the completed model, with ``folder`` and ``history``.

    Raises
    ------
    InputError : the folder holds something else.
    """
    context = context or RunContext()
    folder = Path(folder)
    context.notify(
        f"copying the example to {folder} and simulating its raw logs: the simulated robot has an effect that "
        f"model.toml lacks"
    )
    for name, kind in ((README, EXPLANATION), (REPORT_FILE, REPORT), (VIEW_FILE, PAGE)):
        check_not_foreign(folder / name, kind, context.overwrite)
    simulate_campaign(EXAMPLE, folder, None, context.progress, overwrite=context.overwrite)
    write_output(folder / README, (EXAMPLE / README).read_bytes(), EXPLANATION, context.overwrite)
    improve_campaign(folder, context, notify_step=notify_step)
    done = run_campaign(folder, context)
    return replace(done, folder=str(folder), history=read_history(folder, context))
