"""Runs that disagree with all the others: first which, then what is wrong with them.

Why the runs are judged before any effect: a model that lacks an effect misses many runs by a little, a run that is
mislabelled or in another unit is missed alone and by much, and drags every parameter with it. A run is reported only
where it stands clear of all the others, by the deleted residual or by its place, so that an effect that shows in some
poses more than in others makes no suspect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.answers.suspect_results import RunsNotChecked
from stiffcal.diagnosis.suspects.additive import Offset, best_offset
from stiffcal.diagnosis.suspects.influence import standing_apart
from stiffcal.diagnosis.suspects.places import place_misses, place_scores
from stiffcal.diagnosis.suspects.rival_effects import RunFault, explaining_effect
from stiffcal.diagnosis.suspects.selection import RUNS_FOR_ALL_KINDS, Selection, select_states
from stiffcal.diagnosis.suspects.whitened_runs import Bench, WhitenedRuns, first_order
from stiffcal.errors import Progress, no_progress
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.readings.starting import starting_runs
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.places.mistake import MovedRows, PlacesMistake
from stiffcal.mistakes.runs.found import trial_states, variants_of
from stiffcal.mistakes.runs.mistake import RunRead, Variant
from stiffcal.mistakes.suspect_kinds import SuspectKind
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import NoBalanceError

# Of a run whose readings are right the root mean square of the deleted residual is one; among fifty runs of three
# readings one above three comes once in three thousand campaigns.
LOOKED_AT, LOOKED_AT_GAP = 3.0, 1.7
# What no single mistake explains has to stand clearer: an effect in one pose looks like it.
UNEXPLAINED_LEVEL, UNEXPLAINED_GAP = 4.0, 2.0
# Where the others are beyond their noise too, the model lacks something, and what it lacks may show most in one run.
WITHIN_NOISE, UNEXPLAINED_GAP_BEYOND = 2.6, 4.0
# Two runs of which each has what belongs to the other are far more likely than a displacement that happens to agree.
MUTUAL = 20.0
# Of two runs that are exchanged both are wrong; where the other one is right, another mistake that fits goes first.
ONE_SIDED = 12.0
# Squared misfits that differ by less are distinguished by one reading more: odds of twenty to one (2 log 20).
NEARLY_AS_LIKELY = 6.0
# A run's place stands apart beyond five times what the runs have in common, and twice the next one's.
PLACE_LEVEL, PLACE_GAP = 5.0, 2.0
# With the mistake taken back a run is like the others: no worse than this, in noise and in the worst of the others.
CURED, CURED_AGAINST_OTHERS, CURED_SHARE = 2.2, 1.3, 0.5
ROUNDS = 4
# N, N·m: beyond it no reading of a robot's load is, in any unit.
LARGEST_LOAD = 1e5
# So many states give the noise to two per cent; about a fit of them the deflections of all are linear within that.
NEAR_STATES = 1500
# Of more suspects than these the fit without each alone is not made: the fit without all of them is what counts then.
MOST_REFITTED = 12


@dataclass(frozen=True)
class FoundSuspect:
    """A run that disagrees with all the others."""

    run: int
    """Number of the run."""
    state: int | None
    """Index of the state that is off, among all states; None where the whole run is."""
    kind: SuspectKind
    """What is wrong."""
    variant: Variant | None
    """The mistake that explains it, None where none does."""
    also: tuple[Variant, ...]
    """Other mistakes that explain it nearly as well."""
    offset: Offset | None
    """The displacement that explains it, None where something else does."""
    score: float
    """Root mean square of the deleted residual over its uncertainty."""
    next_score: float
    """That of the worst run that is not a suspect."""
    miss_m: float
    """Rms of the residual's translation; NaN where none is measured."""
    place_m: float
    """How far the place is from where the joint angles put it, m; 0 where that is as in other runs."""
    copied: int | None = None
    """Number of the run whose joint angles this one has word for word, None where there is none."""
    cured_cost: float | None = None
    """With ``variant``: the squared misfit with it, and what its choice costs."""


@dataclass(frozen=True)
class Suspicion:
    """What was found."""

    suspects: tuple[FoundSuspect, ...] = ()
    """Best supported first."""
    fit: Fit | None = None
    """The present model without them; None where there are none."""
    without_each: tuple[Fit | None, ...] = ()
    """For each suspect the present model without that run alone; None after the first few of many suspects."""
    not_checked: RunsNotChecked | None = None
    """What was not compared with the other runs, and why; None where all was."""
    moved: tuple[PlacesMistake, MovedRows] | None = None
    """A mistake between two rows of absolute runs, as that the base was moved, and where; None where there is none."""

    @property
    def shorter_side(self) -> Booleans | None:
        """(n,) True for the rows on the shorter side of a move of the base, which are left out.

        None where there is no move, or where it may be a drift: an effect explains that, from both sides.
        """
        moved = None if self.moved is None else self.moved[1]
        return None if moved is None or moved.or_drift else moved.leave_out

    def keep(self, states: LoadStates) -> Booleans:
        """Return (n,) True for the states that are not a suspect's, and on the longer side of a move of the base."""
        kept = ~np.isin(states.run, [suspect.run for suspect in self.suspects])
        return kept if self.shorter_side is None else kept & ~self.shorter_side


def find_suspects(
    states: LoadStates,
    robot: CompliantRobot,
    settings: Settings | None = None,
    progress: Progress = no_progress,
    present: Fit | None = None,
) -> Suspicion:
    """Return the runs that disagree with all the others.

    Parameters
    ----------
    states : load states; those set aside, and runs of other experiments, are not looked at.
    robot : the present model; values that are set are where the fit starts.
    settings : as for a fit.
    progress : called with what is being done.
    present : the fit of all these states with these settings, where it is at hand; it is made otherwise.

    Raises
    ------
    NoBalanceError, InputError : the model cannot be fitted to the other runs either.
    """
    settings = settings or Settings()
    selection = select_states(states, robot)
    if not selection.most:
        return Suspicion(not_checked=selection.not_checked)
    progress("comparing each run with the others", None)
    index = selection.index
    chosen = states.select(index)
    # a fit of more states of the same runs will do; one that other experiments take part in will not
    compares_all = len(np.unique(chosen.run)) == len(np.unique(states.run))
    search = _Search(chosen, robot, settings, selection.most, present if compares_all else None)
    suspects = [suspect for suspect in search.suspects() if selection.admits(suspect.kind)]
    return _with_refits(suspects, states, search, selection)


def find_misplaced(states: LoadStates, robot: CompliantRobot, settings: Settings) -> Suspicion:
    """Return the runs whose places are not where their joint angles put them, which displacements do not show.

    Parameters
    ----------
    states, robot, settings : as of `find_suspects`.

    Raises
    ------
    NoBalanceError, InputError : the model cannot be fitted to the other runs.
    """
    selection = select_states(states, robot)
    if not selection.most:
        return Suspicion(not_checked=selection.not_checked)
    search = _Search(states.select(selection.index), robot, settings, selection.most, None)
    suspects = [suspect for suspect in search.misplaced() if selection.admits(suspect.kind)]
    return _with_refits(suspects, states, search, selection)


def _with_refits(
    suspects: Sequence[FoundSuspect], states: LoadStates, search: _Search, selection: Selection
) -> Suspicion:
    """Return suspects of the selected states in the whole campaign, with the fits without them."""
    if not suspects:
        return Suspicion(not_checked=selection.not_checked)
    index, robot, settings = selection.index, search.robot, search.settings
    placed = [_in_campaign(suspect, index) for suspect in sorted(suspects, key=lambda entry: -entry.score)]
    loads = np.isin(states.run, np.unique(search.states.run))

    def without(left_out: Sequence[FoundSuspect]) -> Fit:
        keep = loads & ~np.isin(states.run, [suspect.run for suspect in left_out])
        return identify_parameters(states.select(np.flatnonzero(keep)), robot, settings)

    all_without = without(placed)
    refits = [all_without] if len(placed) == 1 else [without([suspect]) for suspect in placed[:MOST_REFITTED]]
    refitted = (*refits, *(None for _ in placed[MOST_REFITTED:]))
    return Suspicion(tuple(placed), all_without, refitted, selection.not_checked)


def described_runs(states: LoadStates, robot: CompliantRobot, settings: Settings, runs: Sequence[int]) -> Suspicion:
    """Return what is wrong with runs that are known to be off.

    Parameters
    ----------
    states : all load states. robot : the model with all that is missing. settings : as for a fit.
    runs : their numbers.
    """
    loads = np.flatnonzero(~states.absolute & ~states.clamped & states.used)
    others = [run for run in runs if not np.isin(run, states.run[loads])]
    found: list[FoundSuspect] = []
    chosen = states.select(loads)
    own = [run for run in runs if run not in others]
    if own:
        found += _Search(chosen, robot, settings, len(own), None).of(own)
    found += [_unknown(run) for run in others]

    def without(left_out: Sequence[int]) -> Fit:
        return identify_parameters(states.select(np.flatnonzero(~np.isin(states.run, left_out))), robot, settings)

    refits = tuple(without([run]) for run in runs[:MOST_REFITTED])
    return Suspicion(tuple(found), without(runs), (*refits, *(None for _ in runs[MOST_REFITTED:])))


def _unknown(run: int) -> FoundSuspect:
    """Return a run that is off, of which nothing more is known."""
    return FoundSuspect(run, None, SuspectKind.UNKNOWN, None, (), None, 0.0, 0.0, np.nan, 0.0)


def _in_campaign(suspect: FoundSuspect, index: Integers) -> FoundSuspect:
    return suspect if suspect.state is None else replace(suspect, state=int(index[suspect.state]))


@dataclass
class _Search:
    """One campaign's search: the states looked at, the model, how many runs may be faulty, and the fit of all."""

    states: LoadStates
    robot: CompliantRobot
    settings: Settings
    most: int
    present: Fit | None
    members: list[Integers] = field(init=False)
    place_scores: Floats = field(init=False)
    place_centre: Floats = field(init=False)
    place_unit: float = field(init=False)

    def __post_init__(self) -> None:
        self.members = self.states.members()
        misses = np.where(self.states.used[:, None], place_misses(self.states, self.robot.chain), np.nan)
        self.place_scores, self.place_centre, self.place_unit = place_scores(misses, self.members)

    def suspects(self) -> list[FoundSuspect]:
        """Return the runs that stand apart and what is wrong with them, in the order of the runs."""
        displaced = self._displaced()
        start = first_order(self.states, self.robot, self.settings.fixed)
        if start.blocks.gram.shape[1] == 0:
            # No load turns anything of the model: there is nothing that one run could contradict.
            return []
        left_out = tuple(sorted({*self._apart(start, start.blocks.best_pair(), relative=True), *displaced}))
        bench, whitened, scores = self._whitened_without(left_out)
        for _ in range(ROUNDS):
            apart = self._apart(whitened, left_out, relative=not bench.noise_known)
            wanted = tuple(sorted({*apart, *displaced}))
            if wanted == left_out:
                break
            left_out = wanted
            bench, whitened, scores = self._whitened_without(left_out)
        exchanged = self._exchanged(start.blocks.best_pair(), whitened) if len(left_out) < 2 else ()
        if not set(exchanged) <= set(left_out):
            left_out = tuple(sorted({*left_out, *exchanged}))
            bench, whitened, scores = self._whitened_without(left_out)
        if not left_out:
            return []
        unit = _unit_of(bench, scores, left_out)
        found_of_run = self._judged_together(left_out, bench, whitened, scores / unit)
        found = [suspect for suspect in found_of_run.values() if suspect is not None]
        # Where the model lacks an effect that shows in these runs alone, that is for the diagnosis to find.
        in_place = [suspect for suspect in found if suspect.copied is None and suspect.place_m == 0.0]
        unexplained = [suspect for suspect in in_place if suspect.variant is None]
        for chosen in (in_place, unexplained):
            faults = [RunFault(suspect.run, suspect.offset, suspect.cured_cost) for suspect in chosen]
            if faults and explaining_effect(bench, whitened, self.states, faults, unit) is not None:
                return [suspect for suspect in found if suspect not in chosen]
            if len(unexplained) == len(in_place):
                break
        return found

    def of(self, runs: Sequence[int]) -> list[FoundSuspect]:
        """Return what is wrong with runs that are known to be off, in their order."""
        left_out = tuple(sorted(runs))
        bench, whitened, scores = self._whitened_without(left_out)
        scores = scores / _unit_of(bench, scores, left_out)
        next_score = float(np.delete(scores, left_out).max(initial=0.0))
        found = self._judged_together(left_out, bench, whitened, scores)
        unknown = partial(self._suspect, kind=SuspectKind.UNKNOWN, whitened=whitened, scores=scores)
        return [found[run] or unknown(run, next_score=next_score) for run in runs]

    def misplaced(self) -> list[FoundSuspect]:
        """Return the runs whose places stand apart and what is wrong with them, in the order of the runs."""
        displaced = self._displaced()
        if not displaced or first_order(self.states, self.robot, self.settings.fixed).blocks.gram.shape[1] == 0:
            return []
        return self.of(displaced)

    def _displaced(self) -> tuple[int, ...]:
        return standing_apart(self.place_scores, PLACE_LEVEL, PLACE_GAP, self.most)

    def _exchanged(self, pair: tuple[int, ...], whitened: WhitenedRuns) -> tuple[int, ...]:
        """Return the two runs without which the rest agrees best, where each has what belongs to the other; else none.

        Two at once are more than may be faulty of six or seven runs, and next to an effect that the model lacks they
        stand out less: here the readings of the other one, which cure both, are the evidence.
        """
        if len(pair) < 2 or sum(own.size > 0 for own in self.members) < RUNS_FOR_ALL_KINDS:
            return ()
        scores = whitened.scores(pair)
        if scores[list(pair)].min() < max(LOOKED_AT, LOOKED_AT_GAP * float(np.delete(scores, pair).max())):
            return ()
        bench, whitened, scores = self._whitened_without(pair)
        found = self._judged_together(pair, bench, whitened, scores / _unit_of(bench, scores, pair))
        others = [None if one is None or one.variant is None else one.variant.other for one in found.values()]
        return pair if others == [pair[1], pair[0]] else ()

    def _judged_together(
        self, left_out: Sequence[int], bench: Bench, whitened: WhitenedRuns, scores: Floats
    ) -> dict[int, FoundSuspect | None]:
        """Return the fault of each run that is left out, as of `_judged`; the two of an exchange support each other."""
        found = {run: self._judged(run, left_out, bench, whitened, scores) for run in left_out}
        for run, suspect in list(found.items()):
            other = None if suspect is None or suspect.variant is None else suspect.variant.other
            if suspect is not None and other in found:
                found[other] = self._judged(other, left_out, bench, whitened, scores, (suspect.kind, run))
        return found

    def _apart(self, whitened: WhitenedRuns, left_out: Sequence[int], relative: bool) -> tuple[int, ...]:
        """Return the runs that stand apart, starting without some of them, until they stay the same."""
        for _ in range(ROUNDS):
            scores = whitened.scores(left_out)
            other_scores = np.delete(scores, list(left_out))
            median = float(np.median(other_scores[other_scores > 0.0])) if (other_scores > 0.0).any() else 1.0
            unit = median if relative else max(1.0, median)
            standing_out = standing_apart(scores / max(unit, 1e-300), LOOKED_AT, LOOKED_AT_GAP, self.most)
            if standing_out == tuple(left_out):
                break
            left_out = standing_out
        return tuple(left_out)

    def _whitened_without(self, left_out: Sequence[int]) -> tuple[Bench, WhitenedRuns, Floats]:
        keep = ~np.isin(self.states.run, list(left_out))
        fit = None if left_out else self.present
        bench, whitened = Bench.of(fit or self._near(self.states.select(keep)), self.settings.fixed, self.states)
        return bench, whitened, whitened.scores(left_out)

    def _near(self, states: LoadStates) -> Fit:
        """Return a fit about which all runs are linear; of many, of some, as long as these determine everything.

        What runs are compared with is solved for by all of them (`RunBlocks`).
        """
        some = starting_runs(states.run, NEAR_STATES)
        fit = None if some is None else identify_parameters(states.select(some), self.robot, self.settings)
        if fit is None or fit.left_at_neutral:
            fit = identify_parameters(states, self.robot, self.settings)
        return fit

    def _judged(
        self,
        run: int,
        left_out: Sequence[int],
        bench: Bench,
        whitened: WhitenedRuns,
        scores: Floats,
        partner: tuple[SuspectKind, int] | None = None,
    ) -> FoundSuspect | None:
        """Return the fault of a run, None where it does not stand clear enough for what explains it.

        Parameters
        ----------
        scores : (R,) in units of what the other runs have. partner : the run that has this one's readings, and which.
        """
        next_score = float(np.delete(scores, list(left_out)).max())
        limit = max(CURED, CURED_AGAINST_OTHERS * next_score)
        unit = whitened.scores(left_out)[run] / scores[run] if scores[run] > 0.0 else 1.0
        freedom = max(int(whitened.blocks.freedom(left_out)[run]), 1)
        variants = variants_of(RunRead(self.states, self.members, run, self.robot.chain, left_out))
        misfits = self._misfits(run, left_out, bench, whitened, variants) / unit**2
        cured = np.sqrt(misfits / freedom)
        misplaced = self.place_scores[run] >= PLACE_LEVEL
        good = (cured <= limit) & ((cured <= CURED_SHARE * scores[run]) | misplaced)
        worth = misfits + np.array([_prior(variant, left_out, partner) for variant in variants])
        order = [int(k) for k in np.argsort(worth, kind="stable") if good[k]]
        offset = best_offset(whitened, run, left_out)
        explained = offset is not None and self._offset_explains(offset, scores[run], freedom, unit, limit)
        if order and not (explained and offset is not None and self._offset_wins(
            offset, worth[order[0]], scores[run], freedom, unit
        )):  # fmt: skip
            first = variants[order[0]]
            alternatives: dict[SuspectKind, Variant] = {}
            for k in order[1:]:
                if worth[k] < worth[order[0]] + NEARLY_AS_LIKELY and variants[k].kind is not first.kind:
                    alternatives.setdefault(variants[k].kind, variants[k])
            suspect = self._suspect(
                run, first.kind, whitened, scores, next_score, variant=first, also=tuple(alternatives.values())
            )
            return replace(suspect, cured_cost=float(worth[order[0]]))
        gap = UNEXPLAINED_GAP if next_score <= WITHIN_NOISE else UNEXPLAINED_GAP_BEYOND
        clear = scores[run] >= UNEXPLAINED_LEVEL and scores[run] >= gap * next_score
        if not clear and not misplaced:
            return None
        copied = self._copied_angles(run)
        if copied is not None:
            return self._suspect(run, SuspectKind.MISLABELLED, whitened, scores, next_score, copied=copied)
        if misplaced or not explained:
            return self._suspect(run, SuspectKind.UNKNOWN, whitened, scores, next_score)
        return self._suspect(run, SuspectKind.BUMP, whitened, scores, next_score, offset=offset)

    def _suspect(
        self,
        run: int,
        kind: SuspectKind,
        whitened: WhitenedRuns,
        scores: Floats,
        next_score: float,
        variant: Variant | None = None,
        also: tuple[Variant, ...] = (),
        offset: Offset | None = None,
        copied: int | None = None,
    ) -> FoundSuspect:
        run_states = whitened.members[run]
        rows = whitened.data.rows_of(0)
        residual = whitened.residual[rows][:, run_states]
        if whitened.data.free_offset and len(run_states):
            residual = residual - residual.mean(axis=1, keepdims=True)
        miss = float(np.sqrt(np.mean(np.sum(residual**2, axis=0)))) if len(rows) and len(run_states) else np.nan
        place = float(self.place_scores[run] * self.place_unit) if self.place_scores[run] >= PLACE_LEVEL else 0.0
        single = len(run_states) == 1
        state = int(whitened.data.index[run_states[0]]) if single else None
        if offset is not None and not single:
            state = int(whitened.data.index[offset.state])
        return FoundSuspect(
            run, state, kind, variant, also, offset, float(scores[run]), next_score, miss, place, copied
        )

    def _misfits(
        self, run: int, left_out: Sequence[int], bench: Bench, whitened: WhitenedRuns, variants: Sequence[Variant]
    ) -> Floats:
        """Return (V,) the squared misfit of the run with each mistake taken back; infinite where that cannot be."""
        result = np.full(len(variants), np.inf)
        usable = [k for k, variant in enumerate(variants) if _possible(variant)]
        pending = [usable] if usable else []
        while pending:
            batch = pending.pop()
            trial = trial_states(self.states, self.members[run], [variants[k] for k in batch])
            try:
                readings = bench.whiten(trial)
            except NoBalanceError:
                half = len(batch) // 2
                pending += [batch[:half], batch[half:]] if half else []
                continue
            misses = np.where(trial.used[:, None], place_misses(trial, self.robot.chain), np.nan)
            per_variant = misses.reshape(len(batch), -1, 3)
            for place, k in enumerate(batch):
                if self._placed(per_variant[place]):
                    result[k] = whitened.blocks.with_run(run, readings.blocks, place, left_out)
        return result

    def _placed(self, misses: Floats) -> bool:
        """Return whether the first measured place is where the joint angles put it, as in the other runs."""
        measured = misses[np.isfinite(misses).all(axis=1)]
        if not len(measured):
            return True
        away = float(np.linalg.norm(measured[0] - self.place_centre)) / self.place_unit
        usual = float(np.sort(self.place_scores)[: max(len(self.place_scores) - self.most, 1)].max())
        return away <= max(PLACE_LEVEL, 2.0 * usual)

    def _offset_explains(self, offset: Offset, score: float, freedom: int, unit: float, limit: float) -> bool:
        remaining_dof = freedom - offset.dof
        remaining = max(score**2 * freedom - offset.gain / unit**2, 0.0)
        return remaining_dof <= 0 or float(np.sqrt(remaining / remaining_dof)) <= limit

    def _offset_wins(self, offset: Offset, worth: float, score: float, freedom: int, unit: float) -> bool:
        remaining = max(score**2 * freedom - offset.gain / unit**2, 0.0)
        return remaining + offset.penalty < worth

    def _copied_angles(self, run: int) -> int | None:
        """Return a run with the same joint angles to the last digit, where more runs have them than share others."""
        first = np.array([own[0] if len(own) else -1 for own in self.members])
        present = np.flatnonzero(first >= 0)
        angles = self.states.joints[first[present]]
        _, group, counts = np.unique(angles, axis=0, return_inverse=True, return_counts=True)
        group_of_run = group.ravel()[np.flatnonzero(present == run)[0]]
        usual = int(np.median(counts))
        if counts[group_of_run] <= usual:
            return None
        return int(next(k for k in present[group.ravel() == group_of_run] if k != run))


def _unit_of(bench: Bench, scores: Floats, left_out: Sequence[int]) -> float:
    """Return what one is in the scores: the noise, or what the other runs have where that is more or it is unknown."""
    kept = np.delete(scores, list(left_out))
    usual = float(np.median(kept[kept > 0.0])) if (kept > 0.0).any() else 1.0
    return max(1.0, usual) if bench.noise_known else usual


def _prior(variant: Variant, left_out: Sequence[int], partner: tuple[SuspectKind, int] | None) -> float:
    """Return how much less likely a mistake is before any look at the numbers, as a difference of squared misfits."""
    if variant.other is None:
        return variant.penalty
    mutual = (variant.kind, variant.other) == partner
    return variant.penalty - MUTUAL * mutual + ONE_SIDED * (variant.other not in left_out)


def _possible(variant: Variant) -> bool:
    wrench = variant.wrench
    return wrench is None or bool(np.abs(np.nan_to_num(wrench)).max(initial=0.0) < LARGEST_LOAD)
