"""Whether a stored document has the shape that its type gives."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from stiffcal.documents import Result, result_of
from stiffcal.store.origin import damaged


def has_shape(kind: Any, document: Mapping[str, Any]) -> bool:
    """Return whether a document, or an entry of one, has the shape that its type gives."""
    from pydantic import ValidationError

    try:
        result_of(kind, json.dumps(document))
    except ValidationError:
        return False
    return True


def result_from(kind: type[Result], document: Mapping[str, Any], display_name: str, name: str) -> Result:
    """Return the content of a document of a store.

    Parameters
    ----------
    kind : type of the result.
    document : as it was read.
    display_name, name : of the store and of the document, for the error.

    Raises
    ------
    DamagedError : the document has another shape.
    """
    from pydantic import ValidationError

    try:
        return result_of(kind, json.dumps(document))
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(step) for step in first["loc"])
        raise damaged(display_name, name, f"{place[:80]}: {first['msg'][:120]}") from None
