"""The whole loop on a bundled example: a robot with a hidden effect, found and added (campaigns/demo)."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from stiffcal.campaign.model_file import MODEL_FILE
from stiffcal.campaign.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.files import read_regular, replacing
from stiffcal.limits import TOML
from stiffcal.simulation.truth import TRUTH_FILE
from stiffcal.workflow.improve import improve_campaign
from stiffcal.workflow.improve_results import ImproveStep
from stiffcal.workflow.run import run_campaign
from stiffcal.workflow.run_result import RunResult
from stiffcal.workflow.simulate import simulate_campaign
from stiffcal.workflow.steps import RunContext

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
        As `run_campaign`, of the completed model, with ``folder``.

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
    _take_again(folder)
    simulate_campaign(EXAMPLE, folder, None, context.progress)
    with replacing(folder / "README.md") as temporary:  # not through a link that lies there
        shutil.copyfile(EXAMPLE / "README.md", temporary)
    improve_campaign(folder, context, notify_step=notify_step)
    return replace(run_campaign(folder, context), folder=str(folder))


def _take_again(folder: Path) -> None:
    """Remove the model file of an earlier demo, which `improve` has changed: `simulate` would refuse to replace it."""
    model = folder / MODEL_FILE
    try:
        manifest = read_regular(folder / MANIFEST_FILE, MANIFEST_FILE, limit=TOML)
    except (InputError, OSError):
        return
    if manifest == (EXAMPLE / MANIFEST_FILE).read_bytes() and (folder / TRUTH_FILE).is_file() and model.is_file():
        model.unlink()
