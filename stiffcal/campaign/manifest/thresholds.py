"""What `validate` and `batch` hold a campaign to: the manifest's [thresholds], or a file for many campaigns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from stiffcal.campaign.toml.toml_reading import read_toml, validate
from stiffcal.campaign.toml.typed import Name, Positive, TomlTable

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


class Thresholds(TomlTable):
    """What `validate` and `batch` hold the campaign to.

    Attributes
    ----------
    max_rms_m : m, of the translation residual in held-out poses. max_rms_rad : rad, of the rotation residual.
    max_relative : rms error over rms deflection.
    max_over_noise : rms error in held-out poses over the noise; a perfect model has 1.
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
        """Return the thresholds that are set, by key."""
        return {name: value for name, value in self.model_dump(mode="json").items() if value not in (None, {})}


class CampaignThresholds(TomlTable):
    """Thresholds of one campaign; they go before those for all."""

    limits: Thresholds = Field(default_factory=Thresholds, alias="validate")


class ThresholdsFile(TomlTable):
    """Thresholds of many campaigns in one file. What a campaign sets itself may be tighter than these, never looser.

    Attributes
    ----------
    validate : for every campaign.
    campaigns : by a campaign's folder: for that one, before those for all. By the name in its manifest: only where
        they are tighter, as the author of the manifest chooses the name.
    """

    schema_id: Literal["stiffcal/thresholds/1"] = Field(alias="schema")
    limits: Thresholds = Field(default_factory=Thresholds, alias="validate")
    campaigns: dict[str, CampaignThresholds] = Field(default_factory=dict)

    def own_limits(self, name: str, folder: str) -> Thresholds:
        """Return the thresholds of one campaign.

        Parameters
        ----------
        name : in its manifest.
        folder : the name of its folder.
        """
        limits = self.limits
        if folder in self.campaigns:
            limits = Thresholds.model_validate(limits.written() | self.campaigns[folder].limits.written())
        by_name = self.campaigns.get(name) if name != folder else None
        return tighter(limits, by_name.limits) if by_name is not None else limits

    def limits_for(self, name: str, folder: str, manifest: Thresholds) -> Thresholds:
        """Return the thresholds of one campaign: those of this file, or the manifest's where they are tighter.

        Examples
        --------
        >>> document = {"schema": "stiffcal/thresholds/1", "validate": {"max_rms_m": 2e-4}}
        >>> file = ThresholdsFile.model_validate(document | {"campaigns": {"b": {"validate": {"max_rms_m": 3e-4}}}})
        >>> manifest = Thresholds(max_rms_m=2.5e-4, max_relative=0.3)
        >>> [file.limits_for("", folder, manifest).written() for folder in "ab"]
        [{'max_rms_m': 0.0002, 'max_relative': 0.3}, {'max_rms_m': 0.00025, 'max_relative': 0.3}]
        """
        return tighter(self.own_limits(name, folder), manifest)

    def baselines(self) -> tuple[Path, ...]:
        """Return every baseline that the file names."""
        named = [self.limits, *(settings.limits for settings in self.campaigns.values())]
        return tuple(Path(limits.baseline) for limits in named if limits.baseline is not None)


def tighter(first: Thresholds, second: Thresholds) -> Thresholds:
    """Return thresholds that hold where both hold: of each the tighter one; the baseline is that of the first, if any.

    Without `max_drift` a baseline allows no change that is more than chance, which no other number may loosen.

    Examples
    --------
    >>> tighter(Thresholds(max_rms_m=2e-4), Thresholds(max_rms_m=1e-3, min_stiffness={"all": 1e5})).written()
    {'max_rms_m': 0.0002, 'min_stiffness': {'all': 100000.0}}
    """
    merged: dict[str, object] = {}
    for name in ("max_rms_m", "max_rms_rad", "max_relative", "max_over_noise"):
        limits = [value for value in (getattr(first, name), getattr(second, name)) if value is not None]
        merged[name] = min(limits, default=None)
    merged["min_stiffness"] = _by_joint_tighter(first.min_stiffness, second.min_stiffness, max)
    merged["baseline"] = first.baseline or second.baseline
    strict = {ALL_JOINTS: 0.0} if first.baseline is not None else {}
    drift = _by_joint_tighter({**strict, **first.max_drift}, second.max_drift, min)
    merged["max_drift"] = {name: value for name, value in drift.items() if value > 0.0}
    return Thresholds.model_validate({name: value for name, value in merged.items() if value not in (None, {})})


def _by_joint_tighter(
    first: dict[str, float], second: dict[str, float], choose: Callable[[list[float]], float]
) -> dict[str, float]:
    """Return one table by joint of two; a joint that a table does not name has its value for all."""
    names = dict.fromkeys((*first, *second))
    tables = [table for table in (first, second) if table]
    return {
        name: choose([limit for table in tables if (limit := table.get(name, table.get(ALL_JOINTS))) is not None])
        for name in names
    }


def strange_joints(limits: Thresholds, joint_names: Sequence[str]) -> list[tuple[str, str]]:
    """Return (key, name) of every joint in the tables by joint that the robot does not have."""
    tables = {"min_stiffness": limits.min_stiffness, "max_drift": limits.max_drift}
    allowed_names = (ALL_JOINTS, *joint_names)
    return [(key, name) for key, table in tables.items() for name in table if name not in allowed_names]


def load_thresholds(path: Path) -> ThresholdsFile:
    """Read a file of thresholds; the baselines in it become paths from where the program runs.

    Raises
    ------
    InputError : it cannot be read, or a key is wrong.
    """
    file = validate(read_toml(path, str(path), from_user=True), str(path), ThresholdsFile)
    campaigns = {
        name: settings.model_copy(update={"limits": _from(path.parent, settings.limits)})
        for name, settings in file.campaigns.items()
    }
    return file.model_copy(update={"limits": _from(path.parent, file.limits), "campaigns": campaigns})


def _from(folder: Path, limits: Thresholds) -> Thresholds:
    if limits.baseline is None:
        return limits
    return limits.model_copy(update={"baseline": str((folder / limits.baseline).resolve())})
