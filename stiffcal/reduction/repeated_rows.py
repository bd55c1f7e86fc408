"""Rows of a table that stand in it more than once, word for word."""

from __future__ import annotations

import numpy as np

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
    copy_texts = [f"{_place(states, used[k])} repeats {_place(states, used[original[k]])}" for k in copies[:MOST_NAMED]]
    suffix = f" and {len(copies) - MOST_NAMED} more" if len(copies) > MOST_NAMED else ""
    text = (
        "two readings never agree exactly; a copy counts twice and makes the noise appear smaller: exclude it with "
        "[[exclude]]"
    )
    return [f"identical rows: {'; '.join(copy_texts)}{suffix}: {text}"]


def _place(states: LoadStates, state: int) -> str:
    info, row = states.runs[int(states.run[state])], int(states.row[state])
    name = info.of or info.name
    return f"row {row}" if name == str(row) else f"run {name} row {row}"
