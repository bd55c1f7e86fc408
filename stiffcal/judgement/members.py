"""What may be missing from a model: effects of the catalogue at their places and laws that nobody has written down.

Each with its whitened columns about one robot at rest, in units of the size that is typical before any reading.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.setting_results import SettingKind
from stiffcal.diagnosis.suspects.influence import most_suspects
from stiffcal.judgement.evidence import MemberColumns
from stiffcal.judgement.exchanged import Exchange, ExchangedPart, exchanges
from stiffcal.judgement.ground import Ground, columns_of
from stiffcal.judgement.priors import (
    ALONE,
    RUN_SIZES,
    UNLISTED_SIZES,
    MemberKind,
    RobotScale,
    Share,
    log_odds,
    where,
)
from stiffcal.judgement.rows_off import Off, rows_off
from stiffcal.judgement.settings_off import GivenSettings, SettingOff, setting_columns
from stiffcal.judgement.shapes import in_other_form, present_as, shapes_of
from stiffcal.judgement.unlisted import UnlistedLaw
from stiffcal.judgement.within_run import InRun, mistakes_in_runs

RUNS_KEPT = 8
"""Runs that may be off and are compared with all else: those that explain most by being so."""


@dataclass(frozen=True)
class Member:
    """One hypothesis of what is missing, in one of its shapes."""

    name: str
    """``effect place``, or the law's place and what it follows; the same for all its shapes."""
    share: Share
    """What it is before any reading."""
    candidate: Candidate | None
    """The effect; None of a law that nobody has written down."""
    shape: Mapping[str, float]
    """Values of its shape parameters, or all values of a form that the catalogue does not add by itself."""
    log_share: float
    """Logarithm of the share that the shape and those that read alike have of all shapes, before any reading."""
    columns: MemberColumns
    """What it does to the readings."""
    log_prior: float = 0.0
    """Log odds of the member in this shape, before any reading."""

    off: tuple[Off, ...] = ()
    """Runs and states that are off or exchanged."""
    setting: SettingOff | None = None
    """The setting that is wrong."""

    @property
    def kind(self) -> MemberKind:
        """Effect, unlisted law or mistake."""
        return self.share.kind


def list_members(
    ground: Ground,
    candidates: Sequence[Candidate],
    scale: RobotScale,
    unlisted: Sequence[UnlistedLaw],
    given: GivenSettings,
    doubt: bool = True,
) -> list[Member]:
    """Return all members about a model, listed ones in the shapes that the readings do not rule out.

    Parameters
    ----------
    given : settings of model file and manifest.
    doubt : whether runs and single readings may be off.
    """
    found: list[Member] = []
    # in an order of their own: which sets are weighed must not hang on the order of a catalogue
    for candidate in sorted(candidates, key=lambda one: one.name):
        if candidate.effect.general or candidate.effect.in_motion:
            continue
        share = Share(
            where(candidate.effect, candidate.place),
            candidate.effect.name,
            MemberKind.EFFECT,
            candidate.place.kind != "setup",
        )
        for regressor, log_share in shapes_of(ground, candidate, scale):
            placed = present_as(ground, candidate)
            whole = placed is not None and in_other_form(candidate, placed)
            shape = dict(placed.values) if placed is not None and whole else dict(regressor.shape)
            as_tried = replace(candidate, effect=regressor.effect)
            columns = columns_of(ground, regressor, scale)
            found.append(Member(candidate.name, share, as_tried, shape, log_share, columns))
    for law in unlisted:
        columns = unlisted_columns(ground, law.columns)
        if not columns.rows.any():
            continue
        share = Share(law.place, law.follows, MemberKind.UNLISTED, True)
        found.append(Member(f"{law.place}: {law.follows}", share, None, {}, 0.0, columns))
    for setting in given.listed():
        changes = setting_columns(ground, setting, given, scale)
        if changes is not None:
            kind = MemberKind.SETUP if setting.kind is SettingKind.TOOL else MemberKind.SETTING
            share = Share("settings", setting.label, kind, False)
            found.append(Member(setting.label, share, None, {}, 0.0, changes, setting=setting))
    if doubt:
        found += [_row_off(off, rows) for off, rows in rows_off(ground)]
    if doubt and most_suspects(len(np.unique(ground.space.data.run))):
        found += [_run_off(run, rows) for run, rows in _furthest(ground)]
        found += [_exchanged(ground, one) for one in exchanges(ground)]
        found += [_in_run(one) for one in mistakes_in_runs(ground)]
    names = {member.name: member.share for member in found}
    odds = dict(zip(names, log_odds(list(names.values())), strict=True))
    return [replace(one, log_prior=float(odds[one.name]) + one.log_share) for one in found]


def unlisted_columns(ground: Ground, columns: Floats) -> MemberColumns:
    """Return the whitened columns of an unlisted law, together of rms one, from displacements (q, m, n)."""
    rows = ground.space.rows(columns)
    size = float(np.sqrt(np.sum(rows**2) / rows.shape[1]))
    even = np.full(len(UNLISTED_SIZES), 1.0 / len(UNLISTED_SIZES))
    return MemberColumns(rows / max(size, 1e-300), np.zeros(len(rows), dtype=np.bool_), UNLISTED_SIZES, even)


def off_columns(rows: Floats, alone: float = 0.0) -> MemberColumns:
    """Return the columns by which a run or a state is off, in any way and without bound.

    Parameters
    ----------
    rows : (q, r) of rms one over the run, or of one noise each.
    alone : probability that it is off in one component alone.
    """
    even = np.full(len(RUN_SIZES), 1.0 / len(RUN_SIZES))
    return MemberColumns(rows, np.zeros(len(rows), dtype=np.bool_), RUN_SIZES, even, alone if len(rows) > 1 else 0.0)


def _furthest(ground: Ground) -> list[tuple[int, Floats]]:
    """Return the runs that are off most, with their columns as `Ground.runs_off` gives them.

    Of the others none is more probable than before: what they could explain is less.
    """
    gains, kept = list[float](), list[tuple[int, Floats]]()
    for run, rows in ground.runs_off():
        basis, _ = np.linalg.qr(rows.T)
        gains.append(float(np.sum((ground.white @ basis) ** 2)) - len(rows))
        kept.append((run, rows))
        if len(kept) > 2 * RUNS_KEPT:
            best = np.argsort(-np.array(gains), kind="stable")[:RUNS_KEPT]
            gains, kept = [gains[k] for k in best], [kept[k] for k in best]
    best = np.argsort(-np.array(gains), kind="stable")[:RUNS_KEPT]
    return sorted((kept[k] for k in best), key=lambda one: one[0])


def _run_off(run: int, rows: Floats) -> Member:
    """Return the member by which a run is off; rows as of `off_columns`."""
    share = Share(f"run {run}", "off", MemberKind.MISTAKE, False)
    return Member(f"run {run} off", share, None, {}, 0.0, off_columns(rows), off=(Off(run),))


def _row_off(off: Off, rows: Floats) -> Member:
    """Return the member by which a state is off; rows of one noise each."""
    share = Share(f"state {off.state}", "off", MemberKind.ROW, False)
    return Member(f"state {off.state} off", share, None, {}, 0.0, off_columns(rows, ALONE), off=(off,))


def _in_run(one: InRun) -> Member:
    """Return the member by which something went wrong inside a run."""
    share = Share(f"run {one.run}", one.kind.value, MemberKind.MISTAKE, False)
    return Member(one.name, share, None, {}, one.log_share, off_columns(one.rows), off=(Off(one.run),))


def _exchanged(ground: Ground, one: Exchange) -> Member:
    """Return the member by which two runs are exchanged: with any of the others, in any part, as soon as off."""
    share = Share(f"runs {one.runs[0]} and {one.runs[1]}", one.part.value, MemberKind.MISTAKE, False)
    columns = MemberColumns(ground.space.rows(one.column[None]), np.ones(1, dtype=np.bool_), np.ones(1), np.ones(1))
    of_all = -float(np.log(len(ExchangedPart) * max(len(ground.of_loads.runs) - 1, 1)))
    return Member(one.name, share, None, {}, of_all, columns, off=tuple(map(Off, one.runs)))
