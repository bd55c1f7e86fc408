"""Rows of a table that stand in it more than once, word for word."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.measurements.load_states import LoadStates

MOST_NAMED = 10


def repeated_rows(states: LoadStates) -> list[str]:
    """Return a warning for rows whose angles, loads and readings are all those of an earlier row.

    Two readings of instruments never agree in every digit: one of the rows is a copy, and counts twice. Rows of load
    runs without a load may be zeros that were written down, and are left alone.

    Parameters
    ----------
    states : load states; those set aside do not count.
    """
    loaded = np.any(np.nan_to_num(states.wrench) != 0.0, axis=1)
    used = np.flatnonzero(states.used & (loaded | states.absolute))
    n = len(used)
    if n < 2:
        return []
    readings = (states.position, states.rotation, states.deflection, states.lengths, states.displacement)
    measured = np.concatenate([values[used].reshape(n, -1) for values in readings], axis=1)
    used = used[np.isfinite(measured).any(axis=1)]
    if len(used) < 2:
        return []
    values = (states.joints, states.wrench, *readings)
    table = np.nan_to_num(np.concatenate([signal[used].reshape(len(used), -1) for signal in values], axis=1))
    _, first, group = np.unique(table, axis=0, return_index=True, return_inverse=True)
    original = first[group.ravel()]
    copies = np.flatnonzero(original != np.arange(len(used)))
    if not len(copies):
        return []
    pairs = np.stack([used[copies], used[original[copies]]], axis=1)
    # of absolute runs each row is one of its own
    names = np.array([info.of or info.name for info in states.runs])[states.run[pairs]]
    # copies that stand as many rows behind their originals are one entry: rows without a load stand between them
    behind = states.row[pairs[:, 0]] - states.row[pairs[:, 1]]
    blocks: dict[tuple[str, str, int], list[Integers]] = {}
    for (copy, source), distance, pair in zip(names.tolist(), behind.tolist(), pairs, strict=True):
        blocks.setdefault((copy, source, distance), []).append(pair)
    copy_texts = [_sentence(states, np.stack(block)) for block in blocks.values()]
    suffix = f" and {len(blocks) - MOST_NAMED} more" if len(blocks) > MOST_NAMED else ""
    text = (
        "two readings never agree exactly; a copy counts twice and makes the noise appear smaller: exclude it with "
        "[[exclude]]"
    )
    return [f"identical rows: {'; '.join(copy_texts[:MOST_NAMED])}{suffix}: {text}"]


def _sentence(states: LoadStates, block: Integers) -> str:
    """Say which rows repeat which; block (n, 2): copies and their originals."""
    rows = states.row[block[:, 0]]
    gaps = rows[-1] - rows[0] + 1 > len(rows)
    some = f" ({len(rows)} of them)" if gaps else ""
    verb = "repeats" if len(rows) == 1 else "repeat"
    return f"{_place(states, block[:, 0])}{some} {verb} {_place(states, block[:, 1])}"


def _place(states: LoadStates, block: Integers) -> str:
    """Return the run and the rows of some of its states, from the first to the last."""
    info, rows = states.runs[int(states.run[block[0]])], states.row[block]
    name = info.of or info.name
    if len(block) == 1:
        return f"row {rows[0]}" if name == str(rows[0]) else f"run {name} row {rows[0]}"
    return f"run {name} rows {rows[0]} to {rows[-1]}"
