"""model.toml, typed: which effects the model holds now; this package names none of them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema

from stiffcal.campaign.found.experiment_kinds import experiment_kind
from stiffcal.campaign.toml.reach import check_own
from stiffcal.campaign.toml.toml_reading import parse_toml, read_toml, validate
from stiffcal.campaign.toml.typed import Counting, Name, TomlTable, WrongValueError
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

MODEL_FILE = "model.toml"

_PAIR = re.compile(r"^\s*(\d+)\s*-\s*(\d+)\s*$")


def _pair(value: object) -> tuple[int, int]:
    if isinstance(value, str) and (match := _PAIR.match(value)):
        value = [int(match[1]), int(match[2])]
    if (
        isinstance(value, list | tuple)
        and len(value) == 2
        and all(isinstance(item, int) and not isinstance(item, bool) and item >= 1 for item in value)
        and value[0] != value[1]
    ):
        return int(value[0]), int(value[1])
    raise WrongValueError(f"{value!r} is not a pair of joints", 'write [5, 6] or "5-6"')


Pair: TypeAlias = Annotated[
    tuple[int, int],
    BeforeValidator(_pair),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "pattern": r"^\d+-\d+$"},
                {"type": "array", "items": {"type": "integer", "minimum": 1}, "minItems": 2, "maxItems": 2},
            ]
        }
    ),
]


def _joint_numbers(value: object) -> object:
    if value == "all":
        return ()
    return value


JointNumbers: TypeAlias = Annotated[
    tuple[Counting, ...],
    Field(strict=False),
    BeforeValidator(_joint_numbers),
    WithJsonSchema({"anyOf": [{"const": "all"}, {"type": "array", "items": {"type": "integer", "minimum": 1}}]}),
]
"""Joints from 1, or "all"."""


class ParameterSetting(TomlTable):
    """A parameter's start, in SI; with `fixed` its value for good."""

    value: float
    fixed: bool = False

    look_alikes: ClassVar[dict[str, str]] = {"start": "value", "fix": "fixed"}


class EffectEntry(TomlTable):
    """One effect and where it sits; set-up effects have no place.

    Attributes
    ----------
    type : the effect's name in the catalogue. joints : from 1, or "all" (written out when loaded). links : names.
    pairs : of joints. parameters : full name (effect.place.symbol) to start or fixed value.
    """

    type: Name
    joints: JointNumbers | None = None
    links: Annotated[tuple[Name, ...], Field(strict=False)] | None = None
    pairs: Annotated[tuple[Pair, ...], Field(strict=False)] | None = None
    parameters: dict[str, ParameterSetting] = Field(default_factory=dict)

    look_alikes: ClassVar[dict[str, str]] = {"name": "type", "effect": "type", "joint": "joints", "link": "links"}

    @property
    def places(self) -> tuple[str, ...]:
        """Return the places by name, as in parameter names: ``j2``, ``swing``, ``j5-j6``; ``setup`` where none."""
        return place_names(self.joints or (), self.links or (), self.pairs or ())


class ModelFile(TomlTable):
    """model.toml.

    Attributes
    ----------
    balance : "deformed": the wrench acts on the deformed, weight-sagged robot; "first-order": the papers' linear form.
    effects : what the model holds.
    """

    schema_id: Literal["stiffcal/model/1"] = Field(alias="schema")
    balance: Literal["deformed", "first-order"] = "deformed"
    effects: Annotated[tuple[EffectEntry, ...], Field(strict=False)] = ()

    look_alikes: ClassVar[dict[str, str]] = {"effect": "effects"}

    def parameter_settings(self) -> dict[str, ParameterSetting]:
        """Return all settings of parameters, by full name."""
        return {name: setting for entry in self.effects for name, setting in entry.parameters.items()}


def place_names(
    joints: Iterable[int] = (), links: Iterable[str] = (), pairs: Iterable[tuple[int, int]] = ()
) -> tuple[str, ...]:
    """Name places as parameter names do.

    Examples
    --------
    >>> place_names(joints=[2], pairs=[(5, 6)]), place_names()
    (('j2', 'j5-j6'), ('setup',))
    """
    names = (*(f"j{joint}" for joint in joints), *links, *(f"j{a}-j{b}" for a, b in pairs))
    return names or ("setup",)


def load_model(folder: Path, n_joints: int, experiments: Collection[str] = ()) -> ModelFile:
    """Load a campaign's model file, or the default model where there is none.

    Parameters
    ----------
    folder : the campaign folder.
    n_joints : J, for ``joints = "all"``.
    experiments : the kinds of experiment of its runs.

    Raises
    ------
    InputError
        With every fault of the file.
    """
    path = folder / MODEL_FILE
    if path.is_symlink() and not path.exists():
        raise InputError.at(
            FaultCode.FILE_KIND,
            MODEL_FILE,
            "",
            "this link leads to no file",
            "remove it, or replace it by the model file",
        )
    if not path.exists():
        return default_model(n_joints, experiments)
    check_own(folder, MODEL_FILE)
    document = read_toml(path, MODEL_FILE)
    return _with_all_joints(check_model(document), document, n_joints)


def default_model(n_joints: int, experiments: Collection[str] = ()) -> ModelFile:
    """Return the model of a campaign without a model file.

    Examples
    --------
    >>> default_model(7).effects[0].joints
    (1, 2, 3, 4, 5, 6, 7)
    >>> [effect.type for effect in default_model(6, {"load", "friction"}).effects]
    ['joint-compliance', 'joint-friction']
    """
    document = parse_toml(default_model_text(experiments), "default_model.toml")
    return _with_all_joints(validate(document, "default_model.toml", ModelFile), document, n_joints)


def default_model_text(experiments: Collection[str] = ()) -> str:
    """Return the default model as a model file: compliant drives, and for friction runs drives with friction.

    Parameters
    ----------
    experiments : the kinds of experiment of the campaign's runs; none of them: load.
    """
    drives = Path(__file__).with_name("default_model.toml")
    kinds = [experiment_kind(name) for name in sorted(experiments)]
    files = [kind.default_model or drives if kind is not None else drives for kind in kinds] or [drives]
    ordered = sorted(dict.fromkeys(files), key=lambda file: file != drives)
    first, *further = (file.read_text(encoding="utf-8") for file in ordered)
    return first + "".join("\n" + text[text.index("[[effects]]") :] for text in further)


def model_of_text(text: str, n_joints: int) -> ModelFile:
    """Return the model that a text in the form of model.toml holds.

    Raises
    ------
    InputError : the text is no model file.
    """
    document = parse_toml(text, MODEL_FILE)
    return _with_all_joints(check_model(document), document, n_joints)


def check_model(document: dict[str, Any]) -> ModelFile:
    """Return a document of model.toml as its type; raises `InputError` with one fault per wrong key."""
    return validate(document, MODEL_FILE, ModelFile)


def _with_all_joints(model: ModelFile, document: dict[str, Any], n_joints: int) -> ModelFile:
    """Replace ``joints = "all"`` by all joints."""
    effects = [
        entry.model_copy(update={"joints": tuple(range(1, n_joints + 1))}) if raw.get("joints") == "all" else entry
        for entry, raw in zip(model.effects, document.get("effects", []), strict=True)
    ]
    return model.model_copy(update={"effects": tuple(effects)})
