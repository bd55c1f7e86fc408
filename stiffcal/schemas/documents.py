"""JSON Schemas of what the commands answer with ``--json``: ``python -m stiffcal.schemas.documents schemas/``."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from stiffcal.compensation.compensate_result import CompensateResult
from stiffcal.compensation.map_result import MapResult
from stiffcal.compensation.predict_result import PredictResult
from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.ingest.checks.results import CheckResult
from stiffcal.ingest.results import IngestResult
from stiffcal.planning.results import PlanResult
from stiffcal.results.batch_results import BatchResult
from stiffcal.results.command_results import (
    EditResult,
    EffectsResult,
    ExportResult,
    InitResult,
    LiveResult,
    NewEffectResult,
    PlotResult,
    ReportResult,
    SimulateResult,
    ViewResult,
)
from stiffcal.results.doctor_result import DoctorResult
from stiffcal.results.error_result import ErrorResult
from stiffcal.results.history_results import HistoryResult
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.results.improve_results import ImproveResult
from stiffcal.results.trust_results import TrustResult
from stiffcal.results.validate_result import ValidateResult
from stiffcal.schemas.json_schema import schema_of
from stiffcal.stages.run_result import RunResult
from stiffcal.validation.compare_result import CompareResult
from stiffcal.validation.trend_result import TrendResult

DOCUMENTS: dict[str, Any] = {
    "identify": IdentifyResult,
    "validate": ValidateResult,
    "history": HistoryResult,
    "predict": PredictResult,
    "map": MapResult,
    "compensate": CompensateResult,
    "plan": PlanResult,
    "ingest": IngestResult,
    "diagnose": DiagnoseResult,
    "improve": ImproveResult,
    "compare": CompareResult,
    "trend": TrendResult,
    "check": CheckResult,
    "run": RunResult,
    "batch": BatchResult,
    "report": ReportResult,
    "plot": PlotResult,
    "live": LiveResult,
    "view": ViewResult,
    "export": ExportResult,
    "edit": EditResult,
    "trust": TrustResult,
    "effects": EffectsResult,
    "new-effect": NewEffectResult,
    "init": InitResult,
    "simulate": SimulateResult,
    "doctor": DoctorResult,
    "error": ErrorResult,
}


def schema_texts() -> dict[str, str]:
    """Return file name to JSON Schema of every document.

    Examples
    --------
    >>> sorted(schema_texts())[0]
    'batch.document.schema.json'
    """
    texts = {}
    for name, kind in DOCUMENTS.items():
        texts[f"{name}.document.schema.json"] = json.dumps(schema_of(kind), indent=2, ensure_ascii=False) + "\n"
    return texts


if __name__ == "__main__":
    for file, text in schema_texts().items():
        (Path(sys.argv[1]) / file).write_text(text, encoding="utf-8")
