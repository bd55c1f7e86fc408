"""Tables of the store that hold what was read of runs: raw load states, block averages, hashes of logs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa

from stiffcal.arrays import Floats
from stiffcal.measurements.columns import TABLE_DOCUMENT, Values, table_of, values_of
from stiffcal.measurements.set_aside import IN_USE, SetAside, SetAsideCode
from stiffcal.reduction.logs.blocks import Blocks
from stiffcal.reduction.states.raw_states import RawStates, stacked

Widths = tuple[tuple[str, int], ...]


def raw_states_table(runs: Sequence[RawStates]) -> pa.Table:
    """Return the raw states of runs, one run after the other; `RawStatesOfRuns` reads them."""
    states = stacked(runs)
    columns: dict[str, Values] = {
        "number": states.number,
        "time_s": states.time,
        "hold_s": states.hold,
        "n_readings": states.n_readings,
        "set_aside": [reason.text for reason in states.set_aside],
        "set_aside_code": [reason.code.value for reason in states.set_aside],
    }
    for kind, signals in (("mean", states.signals), ("scatter", states.scatter)):
        columns |= _columns(kind, signals)
    layout = {kind: _widths(signals) for kind, signals in (("mean", states.signals), ("scatter", states.scatter))}
    return table_of(columns).replace_schema_metadata({TABLE_DOCUMENT: json.dumps(layout)})


class RawStatesOfRuns:
    """The raw states of many runs, from a table that `raw_states_table` made."""

    def __init__(self, table: pa.Table) -> None:
        layout = json.loads(table.schema.metadata[TABLE_DOCUMENT])
        self._columns = {name: values_of(table.column(name)) for name in ("number", "time_s", "hold_s", "n_readings")}
        self._signals = {kind: _signals(table, kind, layout[kind]) for kind in ("mean", "scatter")}
        codes, texts = (table.column(name).to_pylist() for name in ("set_aside_code", "set_aside"))
        self._set_aside = [
            SetAside(SetAsideCode(code), text) if code or text else IN_USE
            for code, text in zip(codes, texts, strict=True)
        ]

    def of_run(self, name: str, first: int, stop: int, widths: tuple[Widths, Widths]) -> RawStates:
        """Return the states of one run: rows `first` to `stop`, and the signals that it has."""
        rows = slice(first, stop)
        means, scatter = (
            {signal: self._signals[kind][signal][rows] for signal, _ in own}
            for kind, own in zip(("mean", "scatter"), widths, strict=True)
        )
        return RawStates(
            [name] * (stop - first),
            self._columns["number"][rows],
            self._columns["time_s"][rows],
            self._columns["hold_s"][rows],
            means,
            scatter,
            self._columns["n_readings"][rows],
            self._set_aside[rows],
        )


def widths_of(states: RawStates | None) -> tuple[Widths, Widths]:
    """Return names and numbers of channels of the signals of states, and of their scatter."""
    if states is None:
        return (), ()
    return tuple(_widths(states.signals)), tuple(_widths(states.scatter))


def blocks_table(blocks: Blocks) -> pa.Table:
    """Return the block averages of a log as a table; `blocks_from_table` reads it."""
    columns: dict[str, Values] = {
        "time_s": blocks.time,
        "start_s": blocks.start,
        "end_s": blocks.end,
        "count": blocks.count,
    }
    columns |= _columns("mean", blocks.mean) | _columns("variance", blocks.variance)
    layout = {"signals": _widths(blocks.mean), "dropped": blocks.dropped, "excluded": blocks.excluded.tolist()}
    return table_of(columns).replace_schema_metadata({TABLE_DOCUMENT: json.dumps(layout)})


def blocks_from_table(table: pa.Table) -> Blocks:
    """Return the block averages of a table that `blocks_table` made."""
    layout = json.loads(table.schema.metadata[TABLE_DOCUMENT])
    return Blocks(
        values_of(table.column("time_s")),
        values_of(table.column("start_s")),
        values_of(table.column("end_s")),
        values_of(table.column("count")),
        _signals(table, "mean", layout["signals"]),
        _signals(table, "variance", layout["signals"]),
        layout["dropped"],
        np.array(layout["excluded"], dtype=np.float64).reshape(-1, 2),
    )


def _columns(kind: str, signals: Mapping[str, Floats]) -> dict[str, Values]:
    return {f"{kind} {name} {k}": values[:, k] for name, values in signals.items() for k in range(values.shape[1])}


def _widths(signals: Mapping[str, Floats]) -> list[tuple[str, int]]:
    return [(name, int(values.shape[1])) for name, values in signals.items()]


def _signals(table: pa.Table, kind: str, widths: Sequence[tuple[str, int]]) -> dict[str, Floats]:
    signals = {}
    for name, width in widths:
        columns = [values_of(table.column(f"{kind} {name} {k}")) for k in range(width)]
        signals[name] = np.stack(columns, axis=1) if columns else np.zeros((table.num_rows, 0))
    return signals
