"""Campaigns that are diagnosed once in a session, whichever of its processes asks first."""

from __future__ import annotations

import shutil
from pathlib import Path

from stiffcal.workflow.diagnose import diagnose_campaign
from tests.laboratory.once import folder_once
from tests.laboratory.small_campaign import write_small_campaign

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
SMALL = "small"


def diagnosed_copy(name: str, target: Path) -> Path:
    """Copy a diagnosed campaign to ``target``, which is not there yet, and return that.

    Parameters
    ----------
    name : `SMALL`, four poses in which nothing is missing, or a folder of ``campaigns/``.
    """
    return Path(shutil.copytree(folder_once(_diagnose, name) / "campaign", target, symlinks=True))


def _diagnose(place: Path, name: str) -> None:
    folder = place / "campaign"
    if name == SMALL:
        write_small_campaign(folder, poses=4)
    else:
        shutil.copytree(CAMPAIGNS / name, folder, ignore=shutil.ignore_patterns("store"))
    diagnose_campaign(folder)
