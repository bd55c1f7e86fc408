"""Suspects as results: what was found in words, with numbers, the likely cause and its cure."""

from __future__ import annotations

import math

import numpy as np

from stiffcal.diagnosis.answers.suspect_results import FitWithout, Suspect, WithoutParameter
from stiffcal.diagnosis.suspects.find import FoundSuspect, Suspicion
from stiffcal.diagnosis.thresholds import MOST_ALONG
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import fit_rms
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import work_of_load
from stiffcal.mistakes.places.mistake import MovedRows, PlacesMistake
from stiffcal.mistakes.runs.time_order import TimeOrder
from stiffcal.mistakes.suspect_kinds import SuspectKind
from stiffcal.wording import length, significant


def suspects_of(suspicion: Suspicion, states: LoadStates, chain: Chain) -> list[Suspect]:
    """Return the suspects as results, best supported first.

    Parameters
    ----------
    suspicion : what was found. states : all load states. chain : the robot's.
    """
    if not suspicion.suspects or suspicion.fit is None:
        return []
    n_others = len(np.unique(states.run[suspicion.keep(states) & states.used]))
    backwards = _backwards(suspicion, states, chain)
    elsewhere = TimeOrder.of(states, states.members()).out_of_order(max(n_others // 6, 2))
    return [
        Suspect(
            run=states.runs[suspect.run].name,
            row=None if suspect.state is None else int(states.row[suspect.state]),
            kind=suspect.kind,
            why="; ".join(
                [
                    *_why(suspect, n_others, suspect.run in backwards),
                    *_time_words(states, elsewhere.get(suspect.run, (None, None))),
                ]
            ),
            likely=_likely(suspect, states),
            factor=None if suspect.variant is None else suspect.variant.factor,
            without=fit_without(fit),
        )
        for suspect, fit in zip(suspicion.suspects, suspicion.without_each, strict=True)
    ]


def fit_without(fit: Fit | None) -> FitWithout | None:
    """Return a fit without suspects as a result, None where it was not made."""
    if fit is None:
        return None
    return FitWithout(
        rms=fit_rms(fit),
        parameters=[
            WithoutParameter(name=parameter.name, value=parameter.value, std=parameter.std)
            for parameter in fit.parameters
        ],
    )


def _backwards(suspicion: Suspicion, states: LoadStates, chain: Chain) -> set[int]:
    """Return the suspects in which the load does negative work while it does positive work in most runs."""
    used = states.select(states.used)
    if not np.any(used.wrench) or not used.setup.targets or not used.has_poses:
        return set()
    work = work_of_load(used, chain).work
    present = np.unique(used.run)
    if np.mean(work[present] > 0.0) <= MOST_ALONG:
        return set()
    return {suspect.run for suspect in suspicion.suspects if work[suspect.run] < 0.0}


def _time_words(states: LoadStates, neighbours: tuple[int | None, int | None]) -> list[str]:
    """Return that a run was measured elsewhere in time than it stands, where it was."""
    before, after = ("" if run is None else states.runs[run].name for run in neighbours)
    if before and after:
        return [f'its time stamps lie between those of runs "{before}" and "{after}", not in the order of the runs']
    if before or after:
        return [f'its time stamps lie next to those of run "{before or after}", not in the order of the runs']
    return []


def _why(suspect: FoundSuspect, n_others: int, backwards: bool) -> list[str]:
    reasons = []
    if suspect.score > suspect.next_score:
        size = f"{length(suspect.miss_m)}, " if math.isfinite(suspect.miss_m) else ""
        reasons.append(
            f"its displacements differ from the prediction of the {n_others} other runs by {size}"
            f"{significant(suspect.score)} times the uncertainty of that difference (scatter of the runs, and "
            f"uncertainty of the prediction); of the other runs none by more than {significant(suspect.next_score, 2)} "
            "times its own"
        )
    if suspect.place_m > 0.0:
        reasons.append(f"the target is {length(suspect.place_m)} from where the joint angles put it")
    if backwards:
        reasons.append("force and displacement have opposite directions in it")
    if suspect.variant is not None:
        reasons.append("corrected, it agrees with the others")
    if not reasons and suspect.kind is SuspectKind.UNKNOWN:
        reasons.append(
            "among all explanations of the error that it is off is probable; compared by itself with the other runs it "
            "does not stand apart"
        )
    return reasons


def _likely(suspect: FoundSuspect, states: LoadStates) -> str:
    if suspect.variant is not None:
        alternatives = [variant.likely for variant in suspect.also]
        return "; or: ".join([suspect.variant.likely, *alternatives])
    if suspect.copied is not None:
        name = states.runs[suspect.copied].name
        return f'its joint angles are those of run "{name}": give its own angles, or exclude it'
    if suspect.kind is SuspectKind.BUMP and suspect.offset is not None:
        size = f" by {length(suspect.offset.size_m)}" if math.isfinite(suspect.offset.size_m) else ""
        if suspect.offset.step:
            return (
                f"a lasting displacement of the target, the tracker or the base{size} before this state would explain "
                "it: add seat-shift to the model, or exclude the run"
            )
        return (
            f"an outlier of the target reading{size} would explain it (a disturbance, a typing error), and so would an "
            "effect that acts in this pose only: compare it with the log, repeat it, or exclude it"
        )
    return (
        "no single mistake of units, signs, labels or order explains it; an effect that acts in this pose only "
        "would: repeat it, or exclude it"
    )


def suspect_of_move(mistake: PlacesMistake, moved: MovedRows, states: LoadStates) -> Suspect:
    """Return a mistake from a row on as a result: the rows between which it happened."""
    rows = [int(states.row[state]) for state in (*moved.between, moved.state)]
    runs = [states.runs[int(states.run[state])] for state in (*moved.between, moved.state)]
    names = [info.of or info.name for info in runs]
    several = len(set(names)) > 1
    in_words = [f"{row} of run {name}" if several else str(row) for row, name in zip(rows, names, strict=True)]
    why, likely = mistake.words(moved, in_words)
    return Suspect(
        run=names[2],
        row=rows[2],
        kind=mistake.kind,
        why=why,
        likely=likely,
        factor=None,
        without=None,
        between=rows[:2],
        between_runs=names[:2],
        or_drift=moved.or_drift,
    )
