"""A campaign whose robot has meshes, fitted once in a session."""

from __future__ import annotations

import shutil
from pathlib import Path

from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from tests.laboratory.mesh_robot import give_meshes
from tests.laboratory.once import folder_once
from tests.laboratory.small_campaign import write_small_campaign


def copy_with_meshes(target: Path) -> Path:
    """Copy the campaign to ``target``, which is not there yet, and return that."""
    return Path(shutil.copytree(folder_once(_fitted) / "campaign", target))


def _fitted(place: Path) -> None:
    folder, context = give_meshes(write_small_campaign(place / "campaign", poses=3)), RunContext()
    data = up_to_date_states(folder, context)
    up_to_date_validation(data, up_to_date_fit(data, context), context)
