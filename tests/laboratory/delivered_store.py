"""What a stranger may do to the store of a campaign folder before delivering it."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow.parquet as parquet

from stiffcal.batch.task import run_task
from stiffcal.results.batch_results import BatchTask, CampaignOutcome

STRICT = "\n[thresholds]\nmax_rms_m = 1e-9\n"

NOT_YOURS = "running ingest: the store was not written by you: recomputed"


def forge(folder: Path, name: str, change: Callable[[dict[str, Any]], None]) -> None:
    """Rewrite a document of the store together with its entry in the index, as somebody might who knows the format."""
    current = (folder / "store" / "current").resolve()
    document = json.loads((current / f"{name}.json").read_text("utf-8"))
    change(document)
    content = json.dumps(document).encode()
    (current / f"{name}.json").write_bytes(content)
    index = json.loads((current / "generation.json").read_text("utf-8"))
    index["documents"][name] |= {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (current / "generation.json").write_text(json.dumps(index), "utf-8")


def hold(document: dict[str, Any]) -> None:
    """Make a validation say that all is well."""
    document.update(passed=True, failed=[], rms={"translation": 1e-12, "rotation": 1e-12})
    for check in document["checks"]:
        check.update(held=True, value=1e-12)


def batch(folder: Path) -> CampaignOutcome:
    return run_task(BatchTask(folder=str(folder), campaign="small", report=False))


def without_logs(folder: Path) -> Path:
    shutil.rmtree(folder / "raw")
    return folder


def forge_table(folder: Path, name: str, table: Any) -> None:
    """Put another table in the place of one of the store, together with its entry in the index."""
    current = (folder / "store" / "current").resolve()
    parquet.write_table(table, current / f"{name}.parquet")
    content = (current / f"{name}.parquet").read_bytes()
    index = json.loads((current / "generation.json").read_text("utf-8"))
    index["tables"][name] |= {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (current / "generation.json").write_text(json.dumps(index), "utf-8")
