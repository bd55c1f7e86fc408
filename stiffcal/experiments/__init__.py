"""The kinds of experiment, and how they are found.

In a load campaign the wrench and the joint angles are known and the deflection is measured; a clamped robot knows its
(zero) motion and measures the reaction; a drive in free motion shows its friction. A kind is one folder here, named as
in ``experiment = "clamped"`` of a run, with one `ExperimentKind` called ``KIND``. The manifest finds it by walking this
folder: nothing else has to be edited for the manifest, its JSON Schema and the default model to know it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.typed import TomlTable


@dataclass(frozen=True)
class ExperimentKind:
    """What a manifest and a model have to know of a kind of experiment.

    Attributes
    ----------
    name : the folder's.
    options : the table of options of a run, under the kind's name; None where a run has no keys of the kind's own.
    default_model : the model file of campaigns of this kind alone that have none; None: compliant drives.
    """

    name: str
    options: type[TomlTable] | None = None
    default_model: Path | None = None
