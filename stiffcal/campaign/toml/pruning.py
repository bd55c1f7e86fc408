"""Looking past wrong keys: a file without them, so that its other faults are reported with them."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from stiffcal.campaign.toml.explain import key_path
from stiffcal.errors import Fault

Model = TypeVar("Model", bound=BaseModel)

# Cutting a key can lay bare the next fault of the same table; more than a few rounds mean that little is left.
_ROUNDS = 5


def validate_without_wrong_keys(document: dict[str, Any], model: type[Model]) -> tuple[Model | None, tuple[str, ...]]:
    """Read what is right in a document.

    Parameters
    ----------
    document : a file whose faults have been reported already.
    model : its type.

    Returns
    -------
    tuple
        The model of what is left, None where nothing is; and the places around what was cut, of which a fault may only
        be a consequence. See `unrelated_faults`.

    Examples
    --------
    >>> from stiffcal.campaign.manifest.manifest import Manifest
    >>> wrong = {"schema": "stiffcal/campaign/1", "frames": {"tool": {"parent": "flange", "xyz": [0, 0, 1]}}}
    >>> left, doubtful = validate_without_wrong_keys(wrong, Manifest)
    >>> list(left.frames), doubtful
    (['tool'], ('frames.tool',))
    """
    pruned = copy.deepcopy(document)
    doubtful: list[str] = []
    for _ in range(_ROUNDS):
        try:
            return model.model_validate(pruned), tuple(dict.fromkeys(doubtful))
        except ValidationError as error:
            details = error.errors(include_url=False)
        for detail in sorted(details, key=lambda detail: len(detail["loc"]), reverse=True):
            location = tuple(detail["loc"])
            if location == ("schema",):
                pruned["schema"] = get_args(model.model_fields["schema_id"].annotation)[0]
            elif not location:
                return None, ()
            elif detail["type"] == "missing" and len(location) > 1:
                doubtful.append(key_path(_remove_key(pruned, location[:-1]), document))
            else:
                cut = _remove_key(pruned, location)
                doubtful.append(key_path(cut[:-1] or cut, document))
    return None, ()


def unrelated_faults(doubtful: Sequence[str], faults: Sequence[Fault]) -> list[Fault]:
    """Keep the faults that the removed keys cannot have caused: elsewhere, and about other names.

    Parameters
    ----------
    doubtful : places of the removed keys, from `validate_without_wrong_keys`.
    faults : of the checks of the file without these keys.
    """
    names = {place.rsplit(".", 1)[1] for place in doubtful if "." in place}
    around = {place.rsplit(".", 1)[0] for place in doubtful if "." in place}
    return [
        fault
        for fault in faults
        if fault.place not in around
        and not any(fault.place == place or fault.place.startswith((f"{place}.", f"{place}[")) for place in doubtful)
        and not names.intersection(fault.names)
    ]


def _remove_key(document: dict[str, Any], location: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """Cut a key out and return what was cut; a list's entry takes the list with it, lest numbers shift."""
    while isinstance(location[-1], int):
        location = location[:-1]
    table: Any = document
    for key in location[:-1]:
        try:
            table = table[key]
        except (KeyError, IndexError, TypeError):
            return location  # cut with an outer table already
    if isinstance(table, dict):
        table.pop(location[-1], None)
    return location
