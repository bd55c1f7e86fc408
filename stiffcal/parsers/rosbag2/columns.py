"""What of a message is a column, by its path, and how its value is taken."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

RECORDED = "time"
# Arrays of a joint state, whose elements go by the names in `name`.
NAMED = ("position", "velocity", "effort")


def paths_of(item: Any, path: str) -> Iterator[str]:
    """Yield the path of every number and word in a message."""
    names = list(getattr(item, "name", ())) if not isinstance(getattr(item, "name", ""), str) else []
    for field in fields(item):
        value = getattr(item, field.name)
        field_path = f"{path}{field.name}"
        if field.name.startswith("__"):
            continue
        if is_dataclass(value):
            if _is_time(value):
                yield field_path
            else:
                yield from paths_of(value, f"{field_path}.")
        elif isinstance(value, np.ndarray | list | tuple):
            if field.name in NAMED and names and len(value) == len(names):
                yield from (f"{field_path}.{name}" for name in names)
                continue
            for index, element in enumerate(value):
                if is_dataclass(element):
                    yield from paths_of(element, f"{field_path}[{index}].")
                elif isinstance(element, int | float | str | np.generic):
                    yield f"{field_path}[{index}]"
        elif isinstance(value, int | float | str | np.generic):
            yield field_path


def _seconds(value: Any) -> float:
    return float(value.sec + value.nanosec * 1e-9)


def _is_time(value: Any) -> bool:
    return {"sec", "nanosec"} <= {field.name for field in fields(value)}


def taker(column: str) -> Callable[[int, Any], Any]:
    """Return the function that takes a column's value out of (recorded, message)."""
    if column == RECORDED:
        return lambda recorded, message: recorded * 1e-9
    # A joint's name may hold points itself, and the order of the names may change between messages.
    pieces = column.split(".")
    place = next((k for k, name in enumerate(pieces[:-1]) if name in NAMED), None)
    if place is None:
        return _by_path(pieces)
    by_name = _by_name(pieces[: place + 1], ".".join(pieces[place + 1 :]))
    by_path = _by_path(pieces)
    inside = _steps(pieces[: place + 1])

    def take(recorded: int, message: Any) -> Any:
        # `position` is an array in a joint's state, three members in a pose.
        value = message
        for step in inside:
            value = step(value)
        return (by_path if is_dataclass(value) else by_name)(recorded, message)

    return take


def _by_path(parts: list[str]) -> Callable[[int, Any], Any]:
    steps = _steps(parts)

    def take(_: int, message: Any) -> Any:
        for step in steps:
            message = step(message)
        return _seconds(message) if is_dataclass(message) else message

    return take


def _by_name(parts: list[str], joint: str) -> Callable[[int, Any], Any]:
    steps, array = _steps(parts[:-1]), parts[-1]

    def take(_: int, message: Any) -> Any:
        for step in steps:
            message = step(message)
        return getattr(message, array)[list(message.name).index(joint)]

    return take


def _steps(parts: list[str]) -> list[Callable[[Any], Any]]:
    return [_step(piece) for joined in parts for piece in joined.replace("[", ".[").split(".")]


def _step(piece: str) -> Callable[[Any], Any]:
    if piece.startswith("["):
        index = int(piece[1:-1])
        return lambda item: item[index]
    return lambda item: getattr(item, piece)
