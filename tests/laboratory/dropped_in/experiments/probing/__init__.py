"""Runs that touch a plate of known place."""

from __future__ import annotations

from stiffcal.campaign.typed import Name, TomlTable
from stiffcal.experiments import ExperimentKind


class ProbingOptions(TomlTable):
    """What is touched.

    Attributes
    ----------
    plate : its name.
    """

    plate: Name


KIND = ExperimentKind("probing", options=ProbingOptions)
