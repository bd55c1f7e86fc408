"""What `diagnose` answers on settings of model file and manifest, and on a robot file, that the data contradict."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from stiffcal.documents import Number
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt


class SettingKind(Enum):
    """What a model file or the manifest sets."""

    FIXED = "fixed parameter"
    BALANCE = "first-order balance"
    FRAME = "given frame"
    TOOL = "tool not stated"


@dataclass(frozen=True, slots=True, kw_only=True)
class ContradictedSetting:
    """What model.toml or campaign.toml sets and the data contradict."""

    setting: SettingKind
    parameter: str | None
    """Full name of the fixed parameter, ``frame.NAME`` of a frame; null for the balance."""
    fixed_at: Number
    """The value in model.toml, as a compliance where it is one; null for a frame, which has six."""
    free_value: Number
    """Its estimate where it is free, in the same unit; null for a frame."""
    free_std: Number
    """Standard uncertainty of that."""
    probability: float
    """That the setting is wrong."""
    heldout_rms_before: Rms
    """In poses left out of the fit, with all settings as they are."""
    heldout_rms_after: Rms
    """The same without those that are contradicted, and with what is missing."""
    alternatives: list[EffectAt]
    """Effects that these data cannot distinguish from a wrong setting."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WrongGeometry:
    """A robot file that absolute places contradict."""

    misfit: float
    """How many times the geometry's tolerance (0.5 mm per length, 0.02° per angle, or as stated) the places miss by."""
    explains: float
    """Share of the avoidable error that errors of the geometry of that size explain, 0 to 1."""
