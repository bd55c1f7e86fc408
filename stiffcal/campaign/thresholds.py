"""What `validate` and `batch` hold a campaign to: the manifest's [thresholds], or a file for many campaigns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from stiffcal.campaign.toml_reading import read_toml, validate
from stiffcal.campaign.typed import Name, Positive, Table

_NUMBER = {"type": "number"}
ALL_JOINTS = "all"


def _by_joint(value: object) -> object:
    return value if isinstance(value, dict) else {ALL_JOINTS: value}


ByJoint = Annotated[
    dict[str, Positive],
    BeforeValidator(_by_joint),
    WithJsonSchema({"anyOf": [_NUMBER, {"type": "object", "additionalProperties": _NUMBER}]}),
]
"""One number for all joints, or a table by joint name ("all": those that are not named)."""


class Thresholds(Table):
    """What `validate` and `batch` hold the campaign to.

    Attributes
    ----------
    max_rms_m : m, of the translation residual in unseen poses. max_rms_rad : rad, of the rotation residual.
    max_relative : rms error over rms deflection.
    max_over_noise : rms error in unseen poses over the noise; a perfect model has 1.
    min_stiffness : N·m/rad, one number for all joints, or a table by joint name.
    baseline : the earlier fit of this robot that the stiffness must not have drifted from: a campaign folder, or a
        model written by `stiffcal export DIR -o baseline.json`.
    max_drift : share by which a joint's stiffness may differ from the baseline's, one number or a table by joint name;
        without it no change that is more than chance is allowed.
    """

    max_rms_m: Positive | None = None
    max_rms_rad: Positive | None = None
    max_relative: Positive | None = None
    max_over_noise: Positive | None = None
    min_stiffness: ByJoint = Field(default_factory=dict)
    baseline: Name | None = None
    max_drift: ByJoint = Field(default_factory=dict)

    look_alikes: ClassVar[dict[str, str]] = {
        "max_rms": "max_rms_m", "max_rms_mm": "max_rms_m", "drift": "max_drift", "stiffness": "min_stiffness",
    }  # fmt: skip

    def written(self) -> dict[str, object]:
        """Return what is asked for, without what was left out."""
        return {name: value for name, value in self.model_dump(mode="json").items() if value not in (None, {})}


class CampaignThresholds(Table):
    """Thresholds of one campaign; they go before those for all."""

    limits: Thresholds = Field(default_factory=Thresholds, alias="validate")


class ThresholdsFile(Table):
    """Thresholds of many campaigns in one file.

    Attributes
    ----------
    validate : for every campaign, before what its manifest says.
    campaigns : by a campaign's name, or its folder's: for that one, before everything else.
    """

    schema_id: Literal["stiffcal/thresholds/1"] = Field(alias="schema")
    limits: Thresholds = Field(default_factory=Thresholds, alias="validate")
    campaigns: dict[str, CampaignThresholds] = Field(default_factory=dict)

    def limits_for(self, names: Sequence[str], manifest: Thresholds) -> Thresholds:
        """Return the thresholds of one campaign: key by key its own here, else those for all, else the manifest's.

        Examples
        --------
        >>> document = {"schema": "stiffcal/thresholds/1", "validate": {"max_rms_m": 2e-4}}
        >>> file = ThresholdsFile.model_validate(document | {"campaigns": {"b": {"validate": {"max_rms_m": 3e-4}}}})
        >>> [file.limits_for([name], Thresholds(max_relative=0.3)).written() for name in "ab"]
        [{'max_rms_m': 0.0002, 'max_relative': 0.3}, {'max_rms_m': 0.0003, 'max_relative': 0.3}]
        """
        written = manifest.written() | self.limits.written()
        own = next((self.campaigns[name] for name in names if name in self.campaigns), None)
        return Thresholds.model_validate(written | (own.limits.written() if own is not None else {}))

    def baselines(self) -> tuple[Path, ...]:
        """Return every baseline that the file names."""
        named = [self.limits, *(held.limits for held in self.campaigns.values())]
        return tuple(Path(limits.baseline) for limits in named if limits.baseline is not None)


def strange_joints(limits: Thresholds, joint_names: Sequence[str]) -> list[tuple[str, str]]:
    """Return (key, name) of every joint in the tables by joint that the robot does not have."""
    tables = {"min_stiffness": limits.min_stiffness, "max_drift": limits.max_drift}
    known = (ALL_JOINTS, *joint_names)
    return [(key, name) for key, table in tables.items() for name in table if name not in known]


def load_thresholds(path: Path) -> ThresholdsFile:
    """Read a file of thresholds; the baselines in it become paths from where the program runs.

    Raises
    ------
    InputError : it cannot be read, or a key is wrong.
    """
    file = validate(read_toml(path, str(path), from_user=True), str(path), ThresholdsFile)
    campaigns = {
        name: held.model_copy(update={"limits": _from(path.parent, held.limits)})
        for name, held in file.campaigns.items()
    }
    return file.model_copy(update={"limits": _from(path.parent, file.limits), "campaigns": campaigns})


def _from(folder: Path, limits: Thresholds) -> Thresholds:
    if limits.baseline is None:
        return limits
    return limits.model_copy(update={"baseline": str((folder / limits.baseline).resolve())})
