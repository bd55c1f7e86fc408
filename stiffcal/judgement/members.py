"""What may be missing from a model: effects of the catalogue at their places and laws that nobody has written down.

Each with its whitened columns about one robot at rest, in units of the size that is typical before any reading.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.errors import Progress, no_progress
from stiffcal.judgement.evidence import MemberColumns
from stiffcal.judgement.ground import Ground, columns_of
from stiffcal.judgement.numbers import EXPECTED_EFFECTS, OF_CANDIDATES, RUN_SIZES, UNLISTED_SIZES
from stiffcal.judgement.priors import MemberKind, Share, UsualSizes, log_odds, where
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.settings_off import SettingOff
from stiffcal.judgement.shapes import in_other_form, present_as, shapes_of
from stiffcal.judgement.threads import in_order
from stiffcal.judgement.unlisted import UnlistedLaw
from stiffcal.model.effect import Effect


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
    settled: float = 1.0
    """Probability of its shape among all shapes of the law, where shapes are numbers of which each is another."""
    off: tuple[Off, ...] = ()
    """Runs and states that are off or exchanged."""
    setting: SettingOff | None = None
    """The setting that is wrong."""
    symbols: tuple[str, ...] = ()
    """Of an effect the parameters that its columns are of, those of its shape left out."""

    @property
    def kind(self) -> MemberKind:
        """Effect, unlisted law or mistake."""
        return self.share.kind


def list_members(
    ground: Ground,
    candidates: Sequence[Candidate],
    scale: UsualSizes,
    unlisted: Iterable[UnlistedLaw],
    others: Iterable[Member] = (),
    expected: float = EXPECTED_EFFECTS,
    progress: Progress = no_progress,
    jobs: int = 1,
) -> list[Member]:
    """Return all members about a model, listed ones in the shapes that the readings do not rule out.

    Parameters
    ----------
    others : mistakes of data and settings.
    expected : effects and laws that are missing in all.
    progress : receives each candidate. jobs : candidates at once.
    """
    found: list[Member] = []
    # in an order of their own: which sets are weighed must not hang on the order of a catalogue
    listed = sorted((one for one in candidates if not one.effect.general), key=lambda one: one.name)
    for done, members in enumerate(in_order(lambda one: _members_of(ground, one, scale), listed, jobs), start=1):
        progress(f"comparing effects: {done} of {len(listed)}", OF_CANDIDATES * done / len(listed))
        found += members
    for law in unlisted:
        columns = unlisted_columns(ground, law.columns)
        if not columns.rows.any():
            continue
        share = Share(law.place, law.follows, MemberKind.UNLISTED, True)
        found.append(Member(f"{law.place}: {law.follows}", share, None, {}, 0.0, columns))
    found += others
    names = {member.name: member.share for member in found}
    odds = dict(zip(names, log_odds(list(names.values()), expected), strict=True))
    return [replace(one, log_prior=float(odds[one.name]) + one.log_share) for one in found]


def _members_of(ground: Ground, candidate: Candidate, scale: UsualSizes) -> list[Member]:
    """Return an effect in the shapes that the readings do not rule out."""
    kind, found = MemberKind.EFFECT, []
    place = where(candidate.effect, candidate.place)
    share = Share(place, candidate.effect.name, kind, candidate.place.kind != "setup")
    for regressor, log_share, settled in shapes_of(ground, candidate, scale):
        placed = present_as(ground, candidate)
        whole = placed is not None and in_other_form(candidate, placed)
        shape = dict(placed.values) if placed is not None and whole else dict(regressor.shape)
        as_tried = replace(candidate, effect=regressor.effect)
        columns = columns_of(ground, regressor, scale)
        member = Member(candidate.name, share, as_tried, shape, log_share, columns, settled=settled)
        found.append(replace(member, symbols=regressor.symbols))
    return found


def model_of(members: Sequence[Member]) -> frozenset[str]:
    """Return what distinguishes a model: its effects, those of their shapes that no fit changes, changed settings."""
    effects = orders_of((one.name, one.candidate.effect, one.shape) for one in members if one.candidate is not None)
    return effects | {one.name for one in members if one.setting is not None}


def orders_of(effects: Iterable[tuple[str, Effect, Mapping[str, float]]]) -> frozenset[str]:
    """Return names of effects with their discrete shapes: orders, states at which something begins."""
    return frozenset(
        " ".join((name, *(f"{values[spec.symbol]:g}" for spec in effect.parameters if spec.discrete)))
        for name, effect, values in effects
    )


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
    even, free = np.full(len(RUN_SIZES), 1.0 / len(RUN_SIZES)), np.zeros(len(rows), dtype=np.bool_)
    place = np.flatnonzero(rows.any(axis=0))
    alone = alone if len(rows) > 1 else 0.0
    return MemberColumns(rows[:, place], free, RUN_SIZES, even, alone, place=place)
