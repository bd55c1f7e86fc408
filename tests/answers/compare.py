"""Where two recordings differ: numbers to 1e-9 relative, schemas by structure, text exactly but for times and paths."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

RELATIVE, ABSOLUTE = 1e-9, 1e-14
PASSING = frozenset(
    {
        "time",
        "created",
        "seconds",
        "memory_bytes",
        "peak_memory_bytes",
        "key",
        "sha256",
        "versions",
        "fit_id",
        "output",
        "pace",
    }
)
"""Keys whose values belong to the moment, the machine or the version, not to the answer."""
_MOMENTS = (
    (re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?Z?"), "TIME"),
    (re.compile(r"\d{4}-\d\d-\d\d"), "DAY"),
    (re.compile(r"\b[0-9a-f]{12,64}\b"), "HASH"),
    (re.compile(r"\b\d+(\.\d+)? s\b"), "SECONDS"),
    (re.compile(r"\b\d+ *candidates per second"), "PACE"),
    (re.compile(r"\S*/(?:work|code|state|campaigns)/\S*"), "PATH"),
)
ROUNDED = "rounded to"
"""Key of an array that a page holds, rounded to this step: two of them may differ by one step."""
MISSING = "(nothing)"
SETS = ("enum", "required")  # lists of a schema whose order says nothing


def differences(before: Path, after: Path) -> list[str]:
    """Return a line for every difference of two folders that `record` wrote."""
    old, new = before / "answers", after / "answers"
    names = sorted(
        {path.relative_to(root).as_posix() for root in (old, new) for path in root.rglob("*") if path.is_file()}
    )
    found: list[str] = []
    for name in names:
        texts = [(root / name).read_text("utf-8") if (root / name).exists() else None for root in (old, new)]
        if texts[0] is None or texts[1] is None:
            found.append(f"{name}: only {'after' if texts[0] is None else 'before'}")
        else:
            found += [f"{name}: {line}" for line in _file_differences(name, texts[0], texts[1])]
    return found


def _file_differences(name: str, old: str, new: str) -> Iterator[str]:
    if old == new:
        return
    documents = [_parsed(text) for text in (old, new)] if name.endswith(".json") else [None, None]
    if name.endswith(".csv"):
        yield from value_differences(_cells(old), _cells(new))
    elif documents[0] is None or documents[1] is None:
        yield from _text_differences(old, new)
    elif name.startswith("schemas/"):
        yield from value_differences(resolved(documents[0], documents[0]), resolved(documents[1], documents[1]))
    else:
        yield from value_differences(documents[0], documents[1])


def _parsed(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return None


def _cells(table: str) -> list[list[float | str]]:
    """Return the cells of a CSV table, numbers as numbers."""
    return [[_number_or_text(cell) for cell in row] for row in csv.reader(table.splitlines())]


def _number_or_text(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell


def value_differences(old: Any, new: Any, place: str = "") -> Iterator[str]:
    """Yield where two JSON values differ.

    Examples
    --------
    >>> list(value_differences({"a": [1.0, 2.0]}, {"a": [1.0, 2.1], "b": None}))
    ['a[1]: 2.0 → 2.1', 'b: (nothing) → null']
    """
    if isinstance(old, dict) and isinstance(new, dict) and ROUNDED in old and ROUNDED in new:
        if not _equal_arrays(old, new):
            yield f"{place}: {_short(old)} → {_short(new)}"
    elif isinstance(old, dict) and isinstance(new, dict):
        for key in dict.fromkeys((*old, *new)):
            inside = f"{place}.{key}" if place else str(key)
            if key in PASSING:
                continue
            if key not in old or key not in new:
                yield f"{inside}: {_shown(old, key)} → {_shown(new, key)}"
            else:
                yield from value_differences(old[key], new[key], inside)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, (first, second) in enumerate(zip(old, new, strict=True)):
            yield from value_differences(first, second, f"{place}[{number}]")
    elif not _equal(old, new):
        yield f"{place}: {_short(old)} → {_short(new)}"


def _equal(old: Any, new: Any) -> bool:
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in (old, new))
    if numbers:
        return math.isclose(old, new, rel_tol=RELATIVE, abs_tol=ABSOLUTE) or (math.isnan(old) and math.isnan(new))
    if isinstance(old, str) and isinstance(new, str):
        return without_moments(old) == without_moments(new)
    return bool(old == new)


def _equal_arrays(old: dict[str, Any], new: dict[str, Any]) -> bool:
    """Whether two rounded arrays may be roundings of the same numbers."""
    values = [np.asarray(array["values"], dtype=np.float64) for array in (old, new)]
    if values[0].shape != values[1].shape:
        return False
    step = max(old[ROUNDED], new[ROUNDED])
    return bool(np.allclose(values[0], values[1], rtol=RELATIVE, atol=step * 1.01, equal_nan=True))


def without_moments(text: str) -> str:
    """Return a text without what belongs to the moment and the machine: times, durations, hashes, paths.

    Examples
    --------
    >>> without_moments("fitted 2026-11-22T09:00:00Z in 3.2 s")
    'fitted TIME in SECONDS'
    """
    for pattern, word in _MOMENTS:
        text = pattern.sub(word, text)
    return text


def _text_differences(old: str, new: str) -> Iterator[str]:
    import difflib

    before, after = (without_moments(text).splitlines() for text in (old, new))
    for line in difflib.unified_diff(before, after, lineterm="", n=0):
        if not line.startswith(("---", "+++", "@@")):
            yield line


def resolved(schema: Any, root: Any, above: tuple[str, ...] = ()) -> Any:
    """Return a JSON Schema with its references replaced by what they refer to; descriptions, titles and orders go.

    Parameters
    ----------
    schema : a part of it. root : the whole. above : references that are being replaced, so that a circle ends.
    """
    if isinstance(schema, list):
        return [resolved(part, root, above) for part in schema]
    if not isinstance(schema, dict):
        return schema
    schema = {key: _in_order(value) if key in SETS else value for key, value in schema.items()}
    reference = schema.get("$ref")
    if isinstance(reference, str) and reference.startswith("#/"):
        if reference in above:
            return {"again": reference.rpartition("/")[2]}
        part = root
        for key in reference[2:].split("/"):
            part = part[key]
        others = {key: value for key, value in schema.items() if key != "$ref"}
        return resolved({**part, **others}, root, (*above, reference))
    left_out = {"$defs", "title", "description"} if above or schema is root else {"title", "description"}
    kept = {key: value for key, value in schema.items() if key not in left_out or not isinstance(value, str | dict)}
    return {key: resolved(value, root, above) for key, value in kept.items() if key != "$defs"}


def _in_order(value: Any) -> Any:
    return sorted(value, key=json.dumps) if isinstance(value, list) else value


def _shown(values: dict[str, Any], key: str) -> str:
    return _short(values[key]) if key in values else MISSING


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 120 else f"{text[:100]}… ({len(text)} characters)"
