"""Some answers on bundled campaigns, to notice a change of numbers: `python -m tests.fingerprint` writes them anew.

A change of numbers on purpose raises `REVISION` in stiffcal/revision.py first. What is written does not
depend on the order in which a processor adds: values to seven digits, names of effects, verdicts.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.documents import document_of
from stiffcal.revision import REVISION

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "tests" / "fingerprint.json"
CAMPAIGNS = {"hidden/01": True, "hidden/03": False, "hidden/07": False, "hidden/10": False}
"""Each with whether it is diagnosed too."""
RELATIVE = 1e-6
FLOORS = {"translation": 1e-10, "rotation": 1e-10, "value": 1e-15, "std": 1e-15}
"""What a difference is allowed to be however small the value is, by key: m, rad, rad/(N·m)."""
OF_STD = 1e-4
"""A parameter may differ by this share of its standard uncertainty: a badly known one moves easily."""

Document = dict[str, Any]


def fingerprint() -> Document:
    """Return the answers as they are now."""
    with tempfile.TemporaryDirectory() as place:
        return {"revision": REVISION, **{name: _answers(name, Path(place)) for name in CAMPAIGNS}}


def _answers(name: str, place: Path) -> Document:
    folder = place / name.replace("/", "-")
    shutil.copytree(ROOT / "campaigns" / name, folder, ignore=shutil.ignore_patterns("store"))
    fit, judged = document_of(identify_campaign(folder)), document_of(validate_campaign(folder))
    answers: Document = {
        "identify": {
            **{key: fit[key] for key in ("n_states", "n_runs", "rms", "noise", "expected_rms", "noise_source")},
            "reduced_chi2": fit["reduced_chi2"],
            "parameters": [{key: one[key] for key in ("name", "value", "std")} for one in fit["parameters"]],
            "rejected": len(fit["rejected"]),
        },
        "validate": {
            **{key: judged[key] for key in ("scheme", "rms", "max", "noise", "relative", "zero_model")},
            "by_run": [{key: part[key] for key in ("label", "n", "rms")} for part in judged["by_run"]],
        },
    }
    if CAMPAIGNS[name]:
        found = document_of(diagnose_campaign(folder))
        answers["diagnose"] = {
            **{key: found[key] for key in ("adequate", "unexplained", "rms")},
            "missing": [{key: one[key] for key in ("effect", "where")} for one in found["missing"]],
            "findings": [
                {key: one[key] for key in ("effect", "where", "verdict", "heldout_rms_after")}
                for one in found["findings"][:5]
            ],
        }
    return answers


def rounded(value: Any) -> Any:
    """Return JSON values with numbers to seven digits."""
    if isinstance(value, dict):
        return {key: rounded(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [rounded(inner) for inner in value]
    return float(f"{value:.6e}") if isinstance(value, float) else value


def differences(then: Any, now: Any, place: str = "", std: float = 0.0) -> Iterator[str]:
    """Yield where two fingerprints differ by more than the arithmetic of processors explains."""
    if isinstance(then, dict) and isinstance(now, dict) and then.keys() == now.keys():
        for key in then:
            inner = OF_STD * float(then.get("std") or 0.0) if key in ("value", "std") else 0.0
            yield from differences(then[key], now[key], f"{place}.{key}", inner)
    elif isinstance(then, list) and isinstance(now, list) and len(then) == len(now):
        for number, (one, other) in enumerate(zip(then, now, strict=True)):
            yield from differences(one, other, f"{place}[{number}]")
    elif isinstance(then, float) and isinstance(now, int | float) and not isinstance(now, bool):
        floor = max(FLOORS.get(place.rsplit(".", 1)[-1], 0.0), std)
        if not math.isclose(then, now, rel_tol=RELATIVE, abs_tol=floor):
            yield f"{place.lstrip('.')}: {then!r} was, {now!r} is"
    elif then != now:
        yield f"{place.lstrip('.')}: {then!r} was, {now!r} is"


def main() -> None:
    """Write the answers."""
    FILE.write_text(json.dumps(rounded(fingerprint()), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    sys.stdout.write(f"{FILE.relative_to(ROOT)}: revision {REVISION}, {FILE.stat().st_size} bytes\n")


if __name__ == "__main__":
    main()
