"""Mistakes in the data and settings that may be wrong, of load states, as members."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.setting_results import SettingKind
from stiffcal.diagnosis.suspects.influence import most_suspects
from stiffcal.judgement.discrepancy import OffRun
from stiffcal.judgement.evidence import MemberColumns
from stiffcal.judgement.exchanged import Exchange, ExchangedPart, exchanges
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.members import Member, off_columns
from stiffcal.judgement.numbers import ALONE, RUNS_KEPT
from stiffcal.judgement.priors import MemberKind, RobotScale, Share
from stiffcal.judgement.rows_off import Off, rows_off
from stiffcal.judgement.settings_off import GivenSettings, setting_columns
from stiffcal.judgement.within_run import InRun, mistakes_in_runs


def mistakes_and_settings(
    ground: GroundOfStates, given: GivenSettings, scale: RobotScale, doubt: bool = True
) -> Iterator[Member]:
    """Give the settings that the data may contradict, and what may be off.

    Parameters
    ----------
    given : settings of model file and manifest.
    doubt : whether runs and single readings may be off.
    """
    for setting in given.listed():
        changes = setting_columns(ground, setting, given, scale)
        if changes is not None:
            kind = MemberKind.SETUP if setting.kind is SettingKind.TOOL else MemberKind.SETTING
            share = Share("settings", setting.label, kind, False)
            yield Member(setting.label, share, None, {}, 0.0, changes, setting=setting)
    if not doubt:
        return
    yield from what_is_off(ground)
    if most_suspects(len(np.unique(ground.space.data.run))):
        yield from (_exchanged(ground, one) for one in exchanges(ground))
        yield from (_in_run(one) for one in mistakes_in_runs(ground))


def what_is_off(ground: Ground) -> Iterator[Member]:
    """Give the single readings and the runs that may be off."""
    yield from (_row_off(off, rows) for off, rows in rows_off(ground))
    if most_suspects(len(np.unique(ground.space.data.run))):
        yield from (_run_off(one, len(ground.white)) for one in _furthest(ground))


def _furthest(ground: Ground) -> list[OffRun]:
    """Return the runs that are off most.

    Of the others none is more probable than before: what they could explain is less.
    """
    gains, kept = list[float](), list[OffRun]()
    for one in ground.runs_off():
        basis, _ = np.linalg.qr(one.moved)
        gains.append(float(np.sum((ground.white[one.place] @ basis) ** 2)) - one.moved.shape[1])
        kept.append(one)
        if len(kept) > 2 * RUNS_KEPT:
            best = np.argsort(-np.array(gains), kind="stable")[:RUNS_KEPT]
            gains, kept = [gains[k] for k in best], [kept[k] for k in best]
    best = np.argsort(-np.array(gains), kind="stable")[:RUNS_KEPT]
    return sorted((kept[k] for k in best), key=lambda one: one.run)


def _run_off(one: OffRun, n_rows: int) -> Member:
    """Return the member by which a run is off."""
    share = Share(f"run {one.run}", "off", MemberKind.MISTAKE, False)
    return Member(f"run {one.run} off", share, None, {}, 0.0, off_columns(one.rows(n_rows)), off=(Off(one.run),))


def _row_off(off: Off, rows: Floats) -> Member:
    """Return the member by which a state is off; rows of one noise each."""
    share = Share(f"state {off.state}", "off", MemberKind.ROW, False)
    return Member(f"state {off.state} off", share, None, {}, 0.0, off_columns(rows, ALONE), off=(off,))


def _in_run(one: InRun) -> Member:
    """Return the member by which something went wrong inside a run."""
    share = Share(f"run {one.run}", one.kind.value, MemberKind.MISTAKE, False)
    return Member(one.name, share, None, {}, one.log_share, off_columns(one.rows), off=(Off(one.run),))


def _exchanged(ground: GroundOfStates, one: Exchange) -> Member:
    """Return the member by which two runs are exchanged: with any of the others, in any part, as soon as off."""
    share = Share(f"runs {one.runs[0]} and {one.runs[1]}", one.part.value, MemberKind.MISTAKE, False)
    columns = MemberColumns(ground.space.rows(one.column[None]), np.ones(1, dtype=np.bool_), np.ones(1), np.ones(1))
    of_all = -float(np.log(len(ExchangedPart) * max(len(ground.of_loads.runs) - 1, 1)))
    return Member(one.name, share, None, {}, of_all, columns, off=tuple(map(Off, one.runs)))
