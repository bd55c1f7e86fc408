"""TOML that a command offers to be pasted: it parses, and the reader of one of our files takes it."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, get_args

from pydantic import BaseModel, TypeAdapter, ValidationError

from tests.laboratory.printed_toml import pairs_in

_HEADER = re.compile(r"\[\[?[\w.\"'-]+\]\]?")


def offers_in(text: str) -> Iterator[str]:
    """Yield the blocks of TOML lines of a text, and each `key = value` of its sentences."""
    block: list[str] = []
    for line in [*(line.strip() for line in text.splitlines()), ""]:
        pairs = list(pairs_in(line))
        if _HEADER.fullmatch(line) or pairs == [line]:
            block.append(line)
            continue
        if any(not _HEADER.fullmatch(own) for own in block):
            yield "\n".join(block)
        block = []
        yield from pairs


def faults_in(text: str) -> list[str]:
    """Return what of a text cannot be pasted into any of our files, and why."""
    return [f"{offer!r}: {fault}" for offer in offers_in(text) if (fault := fault_of(offer)) is not None]


@cache
def fault_of(offer: str) -> str | None:
    """Return why a piece of TOML cannot be pasted; None where it can."""
    try:
        document = tomllib.loads(offer)
    except tomllib.TOMLDecodeError as error:
        return str(error)
    for key, value in document.items():
        if not any(_takes(reader, value) for reader in _readers().get(key, ())):
            return f"no file of ours takes {key!r} with this value"
    return None


def _takes(reader: TypeAdapter[Any], value: object) -> bool:
    try:
        reader.validate_python(value)
    except ValidationError:
        return False
    return True


@cache
def _readers() -> Mapping[str, list[TypeAdapter[Any]]]:
    """Return what reads the value of a key, by every name that a key has in one of our files."""
    from stiffcal.campaign.schemas import SCHEMAS
    from stiffcal.simulation.settings import settings_type

    found: dict[str, list[TypeAdapter[Any]]] = {}
    seen: set[type[BaseModel]] = set()
    waiting: list[type[BaseModel]] = [*(model() for model in SCHEMAS.values()), settings_type()]
    while waiting:
        model = waiting.pop()
        if model in seen:
            continue
        seen.add(model)
        for name, field in model.model_fields.items():
            kind: Any = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
            for key in {name, field.alias or name}:
                found.setdefault(key, []).append(TypeAdapter(kind))
            waiting += _models_in(field.annotation)
    return found


def _models_in(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
        yield from annotation.__subclasses__()
    for part in get_args(annotation):
        yield from _models_in(part)
