"""A task of a batch and what comes of it: plain JSON values, which go through a pipe or to another machine.

Who only hands tasks out does not need what works through them: this module imports nothing heavy.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

Document: TypeAlias = dict[str, Any]

HELD, NOT_HELD, BROKEN, FAULT, LOST = "held", "not held", "broken", "fault", "lost"
GENERATIONS = "generations"
"""Where an outcome carries the digests of what its task has committed, between the processes of a batch only."""
STEPS = ("ingest", "identify", "validate", "report")


def task_of(folder: Path, label: str, **options: Any) -> Document:
    """Return a task.

    Parameters
    ----------
    folder : the campaign folder. label : how it is called in the summary.
    options : ``store`` (address or None), ``report`` (file of the PDF, None for DIR/report.pdf, False for no report),
        ``thresholds`` (a file's document, or None), ``reach`` (what the user has named).
    """
    usual: Document = {"store": None, "report": None, "thresholds": None, "reach": []}
    return {"folder": str(folder), "campaign": label, **usual, **options}


def outcome_of(task: Document, state: str, error: Document | None = None) -> Document:
    """Return the outcome of a task of which nothing else is known."""
    return {
        "campaign": task["campaign"],
        "folder": task["folder"],
        "name": Path(task["folder"]).name,
        "state": state,
        "steps": {},
        "failed_at": None if error is None else STEPS[0],
        "seconds": 0.0,
        "memory_bytes": None,
        "n_states": None,
        "n_runs": None,
        "rms": None,
        "noise": None,
        "relative": None,
        "stiffness": [],
        "checks": [],
        "failed": [],
        "not_judged": [],
        "warnings": [],
        "choices": [],
        "report": None,
        "origin": None,
        "error": error,
        "others": [],
    }
