"""How far estimated values moved between two recordings, in standard uncertainties, and which verdicts changed.

A change that should alter nothing lands where no value moved by more than `TOLERATED` of its uncertainty and no verdict
changed; `compare` names every digit.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

TOLERATED = 0.01
"""Shift over standard uncertainty: a tenth of what the second digit of an uncertainty can show."""
VERDICTS: Mapping[str, tuple[str, ...]] = {
    "check": ("ready", "missing", "suspects"),
    "identify": ("not_identifiable", "rejected", "suspects"),
    "validate": ("passed", "failed", "not_judged", "suspects"),
    "diagnose": (
        "adequate",
        "unexplained",
        "missing",
        "undecided",
        "could_be",
        "contradicted",
        "superfluous",
        "structure",
        "suspects",
    ),
    "improve": ("adequate", "unexplained", "missing", "structure", "suspects", "model"),
}
"""What each command decides: keys of its answer."""
NAMES = ("effect", "where", "verdict", "kind", "run", "rows", "parameter", "name", "field", "type", "joints")
"""What of a finding is the decision; the rest are numbers about it."""
ERRORS = ("rms", "noise", "heldout_rms", "reduced_chi2", "heldout_rms_with_missing")


@dataclass(frozen=True)
class Compared:
    """One campaign in two recordings.

    Attributes
    ----------
    shifts : shift over the earlier standard uncertainty, per value. errors : relative change of each stated error.
    verdicts : a line for each that changed.
    """

    name: str
    shifts: dict[str, float]
    errors: dict[str, float]
    verdicts: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether a change that should alter nothing may land."""
        return not self.verdicts and max(self.shifts.values(), default=0.0) <= TOLERATED

    def lines(self) -> list[str]:
        """Return what is printed of it."""
        shift = max(self.shifts.items(), key=lambda item: item[1], default=("no value", 0.0))
        error = max(self.errors.items(), key=lambda item: item[1], default=("no error", 0.0))
        head = f"{self.name}: {len(self.shifts)} values, at most {shift[1]:.2g} σ ({shift[0]})"
        return [f"{head}; errors to {error[1]:.2g} ({error[0]})", *(f"    {line}" for line in self.verdicts)]


def recorded(before: Path, after: Path) -> dict[str, tuple[Path, Path]]:
    """Return the folders of answers of the campaigns that both recordings have, by name."""
    roots = [folder / "answers" / "campaigns" for folder in (before, after)]
    names = [{path.parent.relative_to(root).as_posix() for path in root.rglob("check.json")} for root in roots]
    return {name: (roots[0] / name, roots[1] / name) for name in sorted(names[0] & names[1])}


def compare_campaign(name: str, before: Path, after: Path) -> Compared:
    """Compare the answers that two recordings hold of a campaign."""
    shifts: dict[str, float] = {}
    errors: dict[str, float] = {}
    verdicts = []
    for command, keys in VERDICTS.items():
        ends = [_first_line(folder / f"{command}.end.txt") for folder in (before, after)]
        if ends[0] != ends[1]:
            verdicts.append(f"{command}: {ends[0]} → {ends[1]}")
        documents = [_document(folder / f"{command}.json") for folder in (before, after)]
        for key in keys:
            old, new = (decision(document.get(key)) for document in documents)
            if old != new:
                verdicts.append(f"{command} {key}: {json.dumps(old)} → {json.dumps(new)}")
        old_values, new_values = (dict(estimates(document)) for document in documents)
        for place in old_values.keys() & new_values.keys():
            value, std = old_values[place]
            shifts[f"{command} {place}"] = abs(new_values[place][0] - value) / std
        old_errors, new_errors = (dict(_errors(document)) for document in documents)
        for place in old_errors.keys() & new_errors.keys():
            errors[f"{command} {place}"] = abs(new_errors[place] / old_errors[place] - 1.0)
    return Compared(name, shifts, errors, tuple(verdicts))


def decision(value: Any) -> Any:
    """Return what of a part of an answer is decided: names and places without the numbers about them.

    Examples
    --------
    >>> decision([{"effect": "backlash", "where": {"joints": [1]}, "size_m": 2e-5}])
    [{'effect': 'backlash', 'where': {'joints': [1]}}]
    """
    if isinstance(value, list):
        return [decision(item) for item in value]
    if isinstance(value, dict) and any(key in value for key in ("effect", "kind", "run", "parameter", "name")):
        return {key: value[key] for key in NAMES if key in value}
    return value


def estimates(document: Any, place: str = "") -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield value and standard uncertainty of everything that a document states with one, by its place in it.

    Examples
    --------
    >>> list(estimates({"parameters": [{"name": "c", "value": 2.0, "std": 0.1, "play": 1.0, "play_std": 0.2}]}))
    [('parameters.c.value', (2.0, 0.1)), ('parameters.c.play', (1.0, 0.2))]
    """
    if isinstance(document, list):
        for number, item in enumerate(document):
            named = item.get("name") if isinstance(item, dict) else None
            yield from estimates(item, f"{place}.{named if named is not None else number}".lstrip("."))
    elif isinstance(document, dict):
        for key, value in document.items():
            std = document.get("std" if key == "value" else f"{key}_std")
            if _number(value) and _number(std) and std > 0.0:
                yield f"{place}.{key}".lstrip("."), (float(value), float(std))
            else:
                yield from estimates(value, f"{place}.{key}".lstrip("."))


def _errors(document: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    for key in ERRORS:
        value = document.get(key)
        parts = value.items() if isinstance(value, dict) else [("", value)]
        for part, number in parts:
            if _number(number) and number > 0.0:
                yield f"{key} {part}".strip(), float(number)


def _number(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _document(path: Path) -> Mapping[str, Any]:
    try:
        document = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return document if isinstance(document, dict) else {}


def _first_line(path: Path) -> str:
    return path.read_text("utf-8").splitlines()[0] if path.exists() else "not recorded"
