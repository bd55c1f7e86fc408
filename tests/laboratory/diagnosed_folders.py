"""Campaigns that are diagnosed once in a session, whichever of its processes asks first."""

from __future__ import annotations

import shutil
from pathlib import Path

from stiffcal.commands.diagnose import diagnose_campaign
from tests.laboratory.once import folder_once
from tests.laboratory.small_campaign import write_small_campaign

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
SMALL = "small"
"""Four poses of a robot whose model lacks nothing …"""
WITHOUT_6 = "small, without joint 6"
"""… and of one whose model lacks the spring of joint 6."""


def diagnosed_copy(name: str, target: Path) -> Path:
    """Copy a diagnosed campaign to ``target``, which is not there yet, and return that.

    Parameters
    ----------
    name : `SMALL`, `WITHOUT_6`, or a folder of ``campaigns/``.
    """
    return Path(shutil.copytree(folder_once(_diagnose, name) / "campaign", target, symlinks=True))


def _diagnose(place: Path, name: str) -> None:
    folder = place / "campaign"
    if name in (SMALL, WITHOUT_6):
        write_small_campaign(folder, poses=4)
        if name == WITHOUT_6:
            model = folder / "model.toml"
            model.write_text(model.read_text(encoding="utf-8").replace("4, 5, 6]", "4, 5]"), encoding="utf-8")
    else:
        shutil.copytree(CAMPAIGNS / name, folder, ignore=shutil.ignore_patterns("store"))
    diagnose_campaign(folder)
