"""What the commands around the fit answer, typed: ``init``, ``check``, ``add``, ``plot``, ``report``, ``run``."""

from __future__ import annotations

from typing import Any, Literal

from typing_extensions import TypedDict


class Run(TypedDict):
    """Answer of ``run``: the documents of the steps, the PDF, whether the thresholds hold."""

    schema: Literal["stiffcal/run/1"]
    warnings: list[str]
    check: dict[str, Any]
    identify: dict[str, Any]
    validate: dict[str, Any]
    diagnose: dict[str, Any]
    report: str
    passed: bool
