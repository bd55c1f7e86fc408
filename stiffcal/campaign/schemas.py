"""JSON Schemas of what a person writes, made from the types: ``python -m stiffcal.campaign.schemas schemas/``.

An editor that is given them (``#:schema`` in a TOML file's first line) completes keys and marks mistakes.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from stiffcal.campaign.manifest.manifest_type import manifest_type
from stiffcal.campaign.manifest.thresholds import ThresholdsFile
from stiffcal.campaign.model.model_file import ModelFile
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.campaign.robot.robot_file import RobotFile

SCHEMAS: dict[str, Callable[[], type[BaseModel]]] = {
    "campaign.schema.json": manifest_type,
    "robot.schema.json": lambda: RobotFile,
    "model.schema.json": lambda: ModelFile,
    "plan.schema.json": lambda: PlanFile,
    "thresholds.schema.json": lambda: ThresholdsFile,
}
"""File to what returns its type: the manifest's depends on the log formats that are found."""

_ATTRIBUTE = re.compile(r"((?:\w+, )*\w+) : ")
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema_document(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON Schema of one of the files.

    Examples
    --------
    >>> schema_document(ModelFile)["properties"]["schema"]["const"]
    'stiffcal/model/1'
    """
    document = {"$schema": DIALECT, **model.model_json_schema(by_alias=True, mode="validation")}
    for table in (document, *document.get("$defs", {}).values()):
        _describe(table)
    return document


def _describe(table: dict[str, Any]) -> None:
    """Move a docstring's descriptions of attributes to the properties; leave out what TOML does not have (null)."""
    properties: dict[str, Any] = table.get("properties", {})
    summary, _, attributes = str(table.get("description", "")).partition("Attributes\n----------\n")
    if summary.strip():
        table["description"] = summary.strip()
    for name, value in properties.items():
        value.pop("title", None)
        if value.get("default", 0) is None:
            del value["default"]
        choices = [choice for choice in value.get("anyOf", []) if choice != {"type": "null"}]
        if len(choices) == 1:
            del value["anyOf"]
            properties[name] = {**choices[0], **value}
        elif choices:
            value["anyOf"] = choices
    places = [match for match in _ATTRIBUTE.finditer(attributes) if set(match[1].split(", ")) <= set(properties)]
    ends = [match.start() for match in places[1:]] + [len(attributes)]
    for match, end in zip(places, ends, strict=False):
        text = " ".join(attributes[match.end() : end].split())
        for name in match[1].split(", "):
            properties[name]["description"] = text


def schema_text(model: type[BaseModel]) -> str:
    """Return the JSON Schema as it stands in `schemas/`."""
    return json.dumps(schema_document(model), indent=2, ensure_ascii=False) + "\n"


def write_schemas(folder: Path) -> list[Path]:
    """Write all schemas of this package into a folder and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, model_type in SCHEMAS.items():
        path = folder / name
        path.write_text(schema_text(model_type()), encoding="utf-8", newline="\n")
        written.append(path)
    return written


if __name__ == "__main__":
    write_schemas(Path(sys.argv[1] if len(sys.argv) > 1 else "schemas"))
