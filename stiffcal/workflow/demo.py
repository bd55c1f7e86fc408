"""The whole loop on a bundled example."""

from __future__ import annotations

import shutil
from pathlib import Path

import stiffcal
from stiffcal.errors import InputError
from stiffcal.workflow.run import run_campaign
from stiffcal.workflow.simulate import simulate_campaign
from stiffcal.workflow.steps import Document, Means

EXAMPLE = "irb4400"


def run_demo(folder: Path, means: Means | None = None) -> Document:
    """Copy the example to a folder, make its logs from their seed, and run the whole loop on it.

    Parameters
    ----------
    folder : where to; made if it does not exist, taken again if it is an earlier demo.
    means : progress and so on.

    Returns
    -------
    dict
        As `run_campaign`, with ``folder``.

    Raises
    ------
    InputError : the example is not there, or the folder holds something else.
    """
    means = means or Means()
    folder = Path(folder)
    example = example_folder()
    means.say(f"copying {EXAMPLE} to {folder} and making its raw logs from their seed")
    simulate_campaign(example, folder, None, means.progress)
    readme = example / "README.md"
    if readme.exists():
        shutil.copyfile(readme, folder / "README.md")
    document = run_campaign(folder, means)
    return document | {"folder": str(folder)}


def example_folder() -> Path:
    """Return where the example lies: in a checkout beside the package, else within it.

    Raises
    ------
    InputError : it is in neither.
    """
    package = Path(stiffcal.__file__).parent
    for place in (package.parent / "campaigns" / EXAMPLE, package / "campaigns" / EXAMPLE):
        if (place / "campaign.toml").is_file():
            return place
    raise InputError.at(f"campaigns/{EXAMPLE}", "", "the example is not installed", "run stiffcal in a checkout of it")
