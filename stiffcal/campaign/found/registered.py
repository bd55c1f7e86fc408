"""Names of a user's file that stand for something found by walking a folder: log formats, kinds of experiment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticKnownError, core_schema


@dataclass(frozen=True)
class OneOf:
    """Marks a text as one of names that are known only when a file is read: ``Annotated[str, OneOf(names)]``.

    What is not among them is refused as a `Literal` would be, and the JSON Schema lists them as one.
    """

    names: Callable[[], tuple[str, ...]]
    """Returns the names that may be written."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the check."""
        return core_schema.no_info_plain_validator_function(self._check)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the choices."""
        return {"enum": list(self.names()), "type": "string"}

    def _check(self, value: object) -> str:
        names = self.names()
        if isinstance(value, str) and value in names:
            return value
        quoted = [f"'{name}'" for name in names]
        expected = " or ".join([", ".join(quoted[:-1]), quoted[-1]] if len(quoted) > 1 else quoted)
        raise PydanticKnownError("literal_error", {"expected": expected})
