"""Mistakes in the data and settings that may be wrong, of load states, as members."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.setting_results import SettingKind
from stiffcal.diagnosis.suspects.influence import most_suspects
from stiffcal.judgement.discrepancy import OffRun
from stiffcal.judgement.evidence import MemberColumns
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.members import Member, off_columns
from stiffcal.judgement.numbers import ALONE, RUNS_KEPT
from stiffcal.judgement.priors import MemberKind, RobotScale, Share
from stiffcal.judgement.rows_off import Off, rows_off
from stiffcal.judgement.settings_off import GivenSettings, setting_columns
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.states.mistake import StateChange, StateMistake


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
        yield from (_of_change(mistake, change) for mistake, change in state_changes(ground))


def state_changes(
    ground: GroundOfStates, *, inside_runs_alone: bool = False
) -> Iterator[tuple[StateMistake, StateChange]]:
    """Give what each mistake of load states may have done to the readings; places show none of them.

    Parameters
    ----------
    inside_runs_alone : no search for mistakes of whole runs, which takes the square of their number.
    """
    if ground.space.data.absolute.all():
        return
    for mistake in mistakes_of(StateMistake):
        if inside_runs_alone and not mistake.inside_a_run:
            continue
        yield from ((mistake, change) for change in mistake.ways(ground.left))


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


def _of_change(mistake: StateMistake, change: StateChange) -> Member:
    """Return the member by which a mistake changed load states."""
    place = f"run {change.runs[0]}" if len(change.runs) == 1 else f"runs {' and '.join(map(str, change.runs))}"
    columns = off_columns(change.rows)
    if mistake.size_is_known:
        columns = MemberColumns(change.rows, np.ones(1, dtype=np.bool_), np.ones(1), np.ones(1))
    share = Share(place, mistake.name, MemberKind.MISTAKE, False)
    name, off = mistake.words(change.runs), tuple(map(Off, change.runs))
    return Member(name, share, None, {}, change.log_share, columns, off=off)
