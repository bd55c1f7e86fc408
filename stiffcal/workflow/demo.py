"""The whole loop on a bundled example: paper 002's robot and procedure (campaigns/irb4400)."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

from stiffcal.files import replacing
from stiffcal.workflow.predict import LoadPathRequest, predict_campaign
from stiffcal.workflow.run import run_campaign
from stiffcal.workflow.run_result import RunResult
from stiffcal.workflow.simulate import simulate_campaign
from stiffcal.workflow.steps import RunContext

EXAMPLE = Path(__file__).parent / "example"
"""A copy of campaigns/irb4400, so that an installed package has it too; `make example` renews it, a test holds it."""

FIGURE_2 = LoadPathRequest(
    corners="-100,200,-300;0,0,0;100,-200,100",
    pose="-90,30,-45,0,15,0",
    note=(
        "the pose of a 15° grid of axes 1, 2, 3 and 5 at which the tip goes down furthest on both legs "
        "(campaigns/irb4400/search_pose.py)"
    ),
)
"""Wang, Zhang and Fuhlbrigge 2009, Fig. 2, with the stiffness of its section II.C."""


def run_demo(folder: Path, context: RunContext | None = None) -> RunResult:
    """Copy the example to a folder, make its logs from their seed, and run the whole loop on it.

    Parameters
    ----------
    folder : where to; made if it does not exist, taken again if it is an earlier demo.
    context : progress and so on.

    Returns
    -------
    RunResult
        As `run_campaign`, with ``folder``.

    Raises
    ------
    InputError : the folder holds something else.
    """
    context = context or RunContext()
    folder = Path(folder)
    context.notify(f"copying the example to {folder} and making its raw logs from their seed")
    simulate_campaign(EXAMPLE, folder, None, context.progress)
    with replacing(folder / "README.md") as beside:  # not through a link that lies there
        shutil.copyfile(EXAMPLE / "README.md", beside)
    store = context.store or str(folder / "store")
    predict_campaign(EXAMPLE / "figure-2", RunContext(store=store, progress=context.progress), load_path=FIGURE_2)
    return replace(run_campaign(folder, context), folder=str(folder))
