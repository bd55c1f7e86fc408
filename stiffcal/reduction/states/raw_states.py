"""States signal by signal, as tables and recordings give them, before they become load states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.set_aside import SetAside


@dataclass(frozen=True)
class RawStates:
    """n states of one campaign, signal by signal, before they become load states."""

    run: list[str]
    """n names of runs, states of one run side by side and in order."""
    number: Integers
    """(n,) row in the table, or the hold's number in its run, from 1."""
    time: Floats
    """(n,) s, NaN where not known."""
    hold: Floats
    """(n,) s, NaN where not known."""
    signals: dict[str, Floats]
    """Name to (n, c), as in `stiffcal.reduction.logs.log_rows.LogRows` but states first."""
    scatter: dict[str, Floats]
    """Name to (n, c), standard deviation of single readings within the hold; signals without one are left out."""
    n_readings: Integers
    """(n,) readings averaged."""
    set_aside: list[SetAside]
    """Why each of the n states is not used; `IN_USE` where it is."""


def no_states() -> RawStates:
    """Return the states of a campaign that holds none: its runs are of other kinds."""
    nothing = np.zeros(0)
    return RawStates([], np.zeros(0, dtype=np.int64), nothing, nothing, {}, {}, np.zeros(0, dtype=np.int64), [])


def pick(gathered: RawStates, chosen: Integers | Booleans) -> RawStates:
    """Return the states at the indices, or where the mask is True."""
    indices = np.arange(len(gathered.run))[chosen]
    return RawStates(
        run=[gathered.run[k] for k in indices],
        number=gathered.number[indices],
        time=gathered.time[indices],
        hold=gathered.hold[indices],
        signals={name: values[indices] for name, values in gathered.signals.items()},
        scatter={name: values[indices] for name, values in gathered.scatter.items()},
        n_readings=gathered.n_readings[indices],
        set_aside=[gathered.set_aside[k] for k in indices],
    )


def of_run(gathered: RawStates, name: str) -> RawStates:
    """Return the states of one run alone."""
    return pick(gathered, np.array([run == name for run in gathered.run], dtype=np.bool_))


def concatenated(tables: Sequence[RawStates]) -> RawStates:
    """Return the states of several tables, one after the other."""
    if len(tables) == 1:
        return tables[0]
    return RawStates(
        run=[name for states in tables for name in states.run],
        number=np.concatenate([states.number for states in tables]),
        time=np.concatenate([states.time for states in tables]),
        hold=np.concatenate([states.hold for states in tables]),
        signals=_stacked_signals([states.signals for states in tables], [len(states.run) for states in tables]),
        scatter=_stacked_signals([states.scatter for states in tables], [len(states.run) for states in tables]),
        n_readings=np.concatenate([states.n_readings for states in tables]),
        set_aside=[reason for states in tables for reason in states.set_aside],
    )


def stacked(tables: Sequence[RawStates]) -> RawStates:
    """Return the states of several runs one after the other; a signal that one of them lacks is NaN there."""
    return concatenated(tables)


def _stacked_signals(tables: Sequence[Mapping[str, Floats]], counts: Sequence[int]) -> dict[str, Floats]:
    widths = {name: values.shape[1] for signals in tables for name, values in signals.items()}
    return {
        name: np.concatenate(
            [
                signals[name] if name in signals else np.full((n, width), np.nan)
                for signals, n in zip(tables, counts, strict=True)
            ]
        )
        for name, width in widths.items()
    }


def joined_side_by_side(first: RawStates, second: RawStates, source: str) -> RawStates:
    """Put the signals of a second table next to the first's, row by row; below it where it holds other runs."""
    if not set(first.run) & set(second.run):
        return concatenated([first, second])
    if first.run != second.run:
        reason = f"has {len(second.run)} states in other runs than the first table's {len(first.run)}"
        raise InputError.at(
            FaultCode.SHAPE_MISMATCH, "campaign.toml", f"[sources.{source}]", reason, "tables of states go row by row"
        )
    return replace(
        first,
        signals=first.signals | second.signals,
        time=np.where(np.isfinite(first.time), first.time, second.time),
        hold=np.where(np.isfinite(first.hold), first.hold, second.hold),
        set_aside=[a if a.code else b for a, b in zip(first.set_aside, second.set_aside, strict=True)],
    )
