"""What other programs take of a campaign: its states or readings with the fit, its model with the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.documents import Document, document_of
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.revision import REVISION
from stiffcal.stages.diagnoses.current import shifted_by_missing
from stiffcal.stages.steps import HELDOUT_STATES, Ingested

if TYPE_CHECKING:
    import pyarrow as pa


def states_with_residuals(data: Ingested) -> pa.Table:
    """Return the store's load states with measurement, prediction and residual in held-out poses as further columns.

    States that were not judged (set aside) have NaN there.
    """
    import numpy as np

    from stiffcal.measurements.columns import column_of, values_of

    table, judged = data.table, data.store.read_table(HELDOUT_STATES)
    where = values_of(judged.column("state"))
    for name in judged.column_names:
        if not name.endswith(("_measured", "_predicted", "_residual")):
            continue
        values = np.full(table.num_rows, np.nan)
        values[where] = values_of(judged.column(name))
        table = table.append_column(name, column_of(values))
    return table


def readings_with_fit(data: Ingested) -> pa.Table:
    """Return the measurements of other experiments, with the fit, of a campaign without load states."""
    from stiffcal.kinds import tables_of_fits

    for name in reversed(tables_of_fits()):
        if name in data.store.tables:
            return data.store.read_table(name)
    reason = "the campaign contains no load states, and no readings of friction or of clamped joints"
    raise InputError.at(
        FaultCode.DATA_MISSING, str(data.campaign.folder), "runs", reason, "export the model instead: -o model.json"
    )


def model_document(data: Ingested, identified: IdentifyResult) -> Document:
    """Return the fit with its model, robot and covariance, and the names of values that what it lacks shifts."""
    shifted = shifted_by_missing(data, identified)
    return {
        "schema": "stiffcal/model-export/1",
        "revision": REVISION,
        "warnings": identified.warnings,
        "campaign": data.campaign.name,
        "robot": data.campaign.robot.model_dump(mode="json", by_alias=True, exclude_none=True),
        "model": document_of(identified.model),
        "parameters": [document_of(parameter) for parameter in identified.parameters],
        "shifted": None if shifted is None else sorted(shifted),
        "free_parameters": identified.free_parameters,
        "covariance": identified.covariance,
    }
