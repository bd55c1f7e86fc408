"""JSON Schemas of the store's tables: ``python -m stiffcal.schemas.tables schemas/``.

Each describes one row. Names, order and types of the columns come from the code that writes the tables, which is given
a specimen: one state of a robot whose joint is called ``<joint>`` and whose target ``<target>``. What a column means
stands in `stiffcal.schemas.table_columns`; a column without a meaning, or a meaning without a column, is a KeyError.

In the Parquet files a missing number is NaN. JSON has no NaN: there it is null, and so the schemas allow null.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from stiffcal.campaign.manifest.source import Source
from stiffcal.diagnosis.refits.effect_curves import EffectEvidence
from stiffcal.diagnosis.refits.refits import Refit, RefitSummary
from stiffcal.identification.answers.state_tables import observed_table
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import (
    GAUGE,
    LENGTH,
    MOTOR,
    ROTATION,
    TRANSLATION,
    GaugeRows,
    RowLayout,
)
from stiffcal.identification.readings.state_loads import BRANCH, LOAD, TORQUE
from stiffcal.ingest.reading.recording_tables import recording_table
from stiffcal.kinds import all_kinds
from stiffcal.measurements.load_states import Attachment, Gauge, LoadStates, MeasurementSetup, RunInfo
from stiffcal.measurements.markers import Markers
from stiffcal.measurements.rms import Rms
from stiffcal.measurements.rods import BeamProperties, rods_between
from stiffcal.measurements.table_specimens import ColumnDescription, TableSpecimen
from stiffcal.measurements.tables import states_table
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place, StateOrder
from stiffcal.model.summary import Where
from stiffcal.reduction.logs.log_rows import LogRows
from stiffcal.schemas.table_columns import (
    EVIDENCE,
    HELDOUT,
    OBSERVED,
    RECORDING,
    REFITS,
    ROW_REFITS,
    STATES,
)
from stiffcal.stages.diagnoses.stored_curves import evidence_columns, refit_columns, row_refit_columns
from stiffcal.store import table_of

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_TYPES = {"double": "number", "int64": "integer", "bool": "boolean", "string": "string"}
_ONE = np.zeros(1)
_FIRST = np.zeros(1, dtype=np.int64)
_TEXTS = {
    "states": "The table `states`: one row per load state.",
    "recording": "A table `recordings/RUN/SOURCE`: one row per reading, in SI and in the instrument's own axes.",
    "fit": "The table `fit`: one row per load state that was fitted, with what the fitted model predicts for it.",
    "unseen": "The table `unseen`: one row per load state, with the residual of a fit made without its pose.",
    "refits": "The table `refits`: one row per refit and load state, its residual by a fit made without its pose.",
    "row_refits": "The table `row_refits`: one row per refit and row of torque, of friction runs without load states.",
    "evidence": "The table `evidence`: one row per effect and load state, the residual against what drives the effect.",
}


def table_specimens() -> dict[str, TableSpecimen]:
    """Return each table of the store with one row, as its writer makes it, and what its columns mean."""
    states = _states()
    judged = (states, _observations(states), np.zeros((9, 1)), np.zeros((9, 1)))
    words = np.array([""])
    tables: dict[str, tuple[pa.Table, Mapping[str, ColumnDescription]]] = {
        "states": (states_table(states, ("<joint>",)), STATES),
        "recording": (_recording(), RECORDING),
        "fit": (observed_table(*judged), OBSERVED),
        "unseen": (observed_table(*judged, {BRANCH: words, LOAD: _ONE, TORQUE.format(1): _ONE}), HELDOUT),
        "refits": (table_of(refit_columns(states, judged[1], [_refit()], _FIRST)), REFITS),
        "row_refits": (table_of(row_refit_columns([_refit()], [_FIRST])), ROW_REFITS),
        "evidence": (table_of(evidence_columns(states, {"": _evidence()})), EVIDENCE),
    }
    specimens = {name: TableSpecimen(_TEXTS[name], *pair) for name, pair in tables.items()}
    for kind in all_kinds():
        specimens |= kind.table_specimens()
    return specimens


def table_schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a row of one of the tables.

    Examples
    --------
    >>> table_schema("states")["properties"]["Fx_N"]["unit"]
    'N'
    """
    specimen = table_specimens()[name]
    meanings = specimen.columns
    # The specimen has one channel of each kind, numbered 1.
    kinds = {re.sub(r"1(?=_|$)", "<k>", field.name): str(field.type) for field in specimen.table.schema}
    spare = set(meanings) - set(kinds)
    if spare:
        raise KeyError(f"no column of {name} is called {', '.join(sorted(spare))}")
    fixed, patterns = {}, {}
    for column, kind in kinds.items():
        description = _column(kind, meanings[column])
        if "<" in column:
            patterns[_pattern(column, list(kinds))] = {"title": column, **description}
        else:
            fixed[column] = description
    return {
        "$schema": DIALECT,
        "title": name,
        "description": f"{specimen.text} Missing numbers are NaN in the file, null here.",
        "type": "object",
        "properties": fixed,
        "patternProperties": patterns,
        # Of a device there is what it logs.
        "required": ["time_s"] if name == "recording" else list(fixed),
        "additionalProperties": False,
    }


def _column(kind: str, meaning: ColumnDescription) -> dict[str, Any]:
    name = _TYPES[kind]
    description: dict[str, Any] = {"description": meaning.text, "type": [name, "null"] if meaning.missing else name}
    return description | ({"unit": meaning.unit} if meaning.unit else {}) | {"parquet": kind}


def _pattern(column: str, columns: list[str]) -> str:
    """Return the regular expression of a column's names: what stands in <…> is free, unless it is another column's."""
    members = _free(column)
    narrower = [_free(name) for name in columns if name != column and re.fullmatch(members, name)]
    return "^" + "".join(f"(?!{expression}$)" for expression in narrower) + members + "$"


def _free(column: str) -> str:
    """Return the expression of a column's names; <k> is a number from 1, any other <…> a name.

    Examples
    --------
    >>> _free("<target>_x_m"), _free("temperature<k>")
    ('.+_x_m', 'temperature[1-9][0-9]*')
    """
    escaped = re.sub(r"<k>", "[1-9][0-9]*", column)
    return re.sub(r"<[^>]+>", ".+", escaped)


def _states() -> LoadStates:
    """Return one load state in which everything is measured."""
    frame = Attachment(0, np.eye(4))
    rods = rods_between("", np.zeros((1, 3)), np.ones((1, 3)), names=("<rod>",))
    gauge = Gauge("<gauge>", 0, frame, np.zeros(3))
    setup = MeasurementSetup(
        frame,
        frame,
        (frame,),
        ("<target>",),
        True,
        rods=(rods,),
        beams=(BeamProperties(1.0),),
        gauges=(gauge,),
        markers=(Markers(("a",), np.zeros((1, 3))),),
    )
    return LoadStates(
        runs=(RunInfo("run"),), run=_FIRST, time=_ONE, hold=_ONE, joints=np.zeros((1, 1)), wrench=np.zeros((1, 6)),
        position=np.zeros((1, 1, 3)), rotation=np.eye(3)[None, None], deflection=np.zeros((1, 1, 6)),
        reference=np.ones(1, dtype=np.bool_), temperature=np.zeros((1, 1)), row=_FIRST, n_readings=_FIRST,
        wrench_scatter=np.zeros((1, 6)), position_scatter=np.zeros((1, 1, 3)), set_aside=np.array([""]), setup=setup,
        lengths=np.zeros((1, 1)), displacement=np.zeros((1, 1)), markers_measured=np.ones((1, 1, 1), dtype=np.bool_),
        sigma=np.ones((1, 1, 6)),
    )  # fmt: skip


def _observations(states: LoadStates) -> Observations:
    """Return the six components of that state, its gauge, its rod and its motor."""
    numbers = np.append(np.arange(6), (0, 0, 0))
    gauges = GaugeRows(np.array([6]), _FIRST, np.zeros((1, 3, 1)), np.zeros((1, 1), dtype=np.int64))
    kinds = np.array([TRANSLATION] * 3 + [ROTATION] * 3 + [GAUGE, LENGTH, MOTOR])
    return Observations(
        angles=np.zeros((1, 1)), wrench=np.zeros((6, 1)),
        order=StateOrder(_FIRST, _ONE, _ONE, np.zeros((1, 1)), _ONE, _ONE),
        measured=np.zeros((9, 1)), measured_mask=np.ones((9, 1), dtype=np.bool_),
        layout=RowLayout(kinds, np.zeros(9, dtype=np.int64), numbers, gauges),
        free_offset=True, run=_FIRST, setup=states.setup, index=_FIRST,
    )  # fmt: skip


def _recording() -> pa.Table:
    """Return one reading of a device that logs everything there is."""
    joints = {name: ["<joint>"] for name in ("position", "velocity", "torque", "current")}
    zero = np.zeros((1, 1))
    signals = {
        "joints": zero, "joints.velocity": zero, "joints.torque": zero, "joints.current": zero,
        "wrench": np.zeros((6, 1)), "mass": zero, "position.<target>": np.zeros((3, 1)),
        "quaternion.<target>": np.zeros((4, 1)), "translation": zero, "rotation": zero,
        "displacement.<gauge>": zero, "lengths.<rod>": zero, "temperature": zero, "hold": zero,
    }  # fmt: skip
    return table_of(recording_table(Source.model_validate({"joints": joints}), LogRows(_FIRST, _ONE, [], signals)))


def _evidence() -> EffectEvidence:
    effect = built_in_effects()["joint-compliance"]
    rms = Rms(0.0, 0.0)
    placed = PlacedEffect(effect, Place("joints", (1,)))
    along = np.ones((1, 3))
    return EffectEvidence(
        placed, "", "1", "translation", None, _FIRST, _ONE, _ONE, _ONE, _ONE, rms, rms, (), along
    )  # fmt: skip


def _refit() -> Refit:
    summary = RefitSummary(change="with", effect="", where=Where(), heldout_rms=Rms(0.0, 0.0), values=[])
    return Refit(summary, np.zeros((9, 1)))


def schema_texts() -> dict[str, str]:
    """Return file name to JSON Schema of every table, as they stand in `schemas/`."""
    return {
        f"{name}.table.schema.json": json.dumps(table_schema(name), indent=2, ensure_ascii=False) + "\n"
        for name in table_specimens()
    }


if __name__ == "__main__":
    for file, text in schema_texts().items():
        (Path(sys.argv[1]) / file).write_text(text, encoding="utf-8", newline="\n")
