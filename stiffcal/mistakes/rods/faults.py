"""Rods that cannot be right: loose, of swapped sign, exchanged, or with a drifting gauge; named by their own data.

Two things hold rods to each other. The link's field: rods beyond the unknowns must agree with the rest in every state.
And the load, where it is known: a beam answers it with five numbers (bending in two planes and their product, twist,
tension), so that a few rods over many states contradict themselves when one is wrong, even where none is to spare.
Each fault is tried on the readings; what is named is the one that takes most of the contradiction away for the fewest
free numbers (Schwarz' criterion), and only when it leaves little of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.links.rods import rod_design
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.measurements.varying import varies
from stiffcal.mechanics.beam import UNKNOWNS, flexibility_patterns
from stiffcal.mechanics.rods import rod_fields
from stiffcal.mistakes.deciding import DECISIVE
from stiffcal.mistakes.found import ways_of
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings, centred_by_run, count_of, left_over, squares_left
from stiffcal.mistakes.rods.words import length_in_words
from stiffcal.reduction.states.rod_temperature import smooth_in_time

# A contradiction smaller than this share of the readings may be the beam's own: sections taper, links shear. The second
# where the rods' noise is not known: then it may be that, too.
TOLERATED, TOLERATED_BLINDLY = 0.10, 0.30
# A fault is named when it takes away at least so much of the squared contradiction that is not noise (or of the whole,
# where noise is not known) …
EXPLAINED, EXPLAINED_BLINDLY = 0.75, 0.5
# … and beats no fault decisively; faults that it does not beat so are named together with it.
# Of a link's rods: with more the others hold nothing.
MOST_WRONG_RODS = 3
# What is left by less than this many times the noise is noise: of a dozen readings the rms is known to a fifth.
ABOUT_NOISE = 1.5
UNEXPLAINED = "unexplained"
"""`RodFault.kind` where something contradicts, and no single mistake explains it."""
# A swapped or exchanged rod may leave this much more, squared, than the same rod called loose.
PLAINER = 1.2


@dataclass(frozen=True)
class RodFault:
    """One fault of one rod, or of two."""

    kind: str
    """The name of a mistake in rods (`stiffcal/mistakes/catalogue`), or `UNEXPLAINED`."""
    rods: tuple[str, ...]
    """Names of the rods."""
    size: float
    """m, rms of what is wrong with these rods' readings."""
    before: float
    """m, rms of the contradiction of all rods with the fault."""
    after: float
    """m, rms of the contradiction of all rods with the fault mended."""
    alternatives: tuple[str, ...]
    """Other faults that explain the data as well, in words."""
    sentence: str
    """What was measured and what to do, in words."""


def find_rod_faults(
    rods: Rods,
    shape: BeamProperties,
    lengths: Floats,
    wrench: Floats | None = None,
    time: Floats | None = None,
    run: Integers | None = None,
    temperature: Floats | None = None,
) -> tuple[RodFault, ...]:
    """Find rods that cannot be right.

    Parameters
    ----------
    rods, shape : the rods and their link.
    lengths : (n, m) changes of length since each run's reference, m.
    wrench : (n, 6) at the link's outboard end in beam axes, since the reference; None where not known. Then at least
        one rod more than unknowns is needed to detect anything, and two to name a loose one.
    time : (n,) s, for drift.
    run : (n,) each run with an offset of its own.
    temperature : (n,) K, for rods that grow with it.

    Returns
    -------
    The faults, the plainest first; none where the rods agree.
    """
    columns = None if wrench is None else _load_columns(rods, shape, wrench)
    design = rod_design(rods, shape)
    stated = float(np.sqrt(np.mean(rods.sigma**2))) if np.isfinite(rods.sigma).all() else 0.0
    ticking = None if time is None or not np.isfinite(time).all() or not varies(time) else time - time.min()
    # Signs, exchanges and flexibilities leave a run's offset an offset: it is taken out once.
    centred = centred_by_run(run, lengths)
    columns = None if columns is None else np.stack([centred_by_run(run, column) for column in columns])
    used = np.ones(len(rods.names), dtype=np.bool_)
    readings = RodReadings(
        rods.names, centred, stated, ticking, run, columns, design, used, growth=_growth(rods, run, time, temperature)
    )
    if columns is None and design.redundancy < 1:
        return ()
    faults: list[RodFault] = []
    while len(faults) < MOST_WRONG_RODS:
        fault, readings = _next_fault(rods, readings)
        if fault is None:
            break
        faults.append(fault)
        if fault.kind == UNEXPLAINED:
            break
    return tuple(faults)


def _growth(rods: Rods, run: Integers | None, time: Floats | None, temperature: Floats | None) -> Floats | None:
    """Return (n, m) what the rods grow by per 1/K of expansion that the link has more than they; None where unknown."""
    if temperature is None or not np.isfinite(temperature).all() or not varies(temperature):
        return None
    warm = temperature.copy()
    if run is not None and time is not None:
        for number in np.unique(run):
            members = run == number
            warm[members] = smooth_in_time(time[members], temperature[members])
    return centred_by_run(run, np.outer(warm, rods.length))


def _load_columns(rods: Rods, shape: BeamProperties, wrench: Floats) -> Floats:
    """Return (5, n, m): what the rods read per flexibility of an even beam."""
    fields = rod_fields(rods, shape)[:, : len(UNKNOWNS)]
    return np.stack([wrench @ (fields @ per_load).T for per_load in flexibility_patterns(shape)])


def _next_fault(rods: Rods, readings: RodReadings) -> tuple[RodFault | None, RodReadings]:
    plain, tried = RodTrial((), readings, *squares_left(readings)), list(ways_of(RodMistake, readings))
    name_of = {id(trial): mistake.name for mistake, trial in tried}
    trials = [plain, *(trial for _, trial in tried)]
    count, sigma = count_of(readings), readings.sigma
    ranked = sorted(trials, key=lambda trial: trial.score(count, sigma))
    best = _closest(ranked, plain, count, sigma)
    before, after = float(np.sqrt(plain.squares / count)), float(np.sqrt(best.squares / count))
    gain = plain.score(count, sigma) - best.score(count, sigma)
    avoidable = plain.squares - count * sigma**2
    explained = 1.0 - (best.squares - count * sigma**2) / avoidable if avoidable > 1e-12 * plain.squares else 0.0
    enough = EXPLAINED if sigma > 0.0 else EXPLAINED_BLINDLY
    # What grows slowly counts as noise between repeats a cycle apart: that noise is no proof against it.
    floor, bare = sigma, min(trials, key=lambda trial: trial.score(count, 0.0))
    if bare.grows_slowly and plain.score(count, 0.0) - bare.score(count, 0.0) >= DECISIVE:
        best, gain, explained, floor, after = bare, np.inf, 1.0, 0.0, float(np.sqrt(bare.squares / count))
    if best is plain or gain < DECISIVE or explained < enough:
        lengths = readings.lengths[:, readings.used]
        tolerated = (TOLERATED if sigma > 0.0 else TOLERATED_BLINDLY) * float(np.sqrt(np.mean(lengths**2)))
        quiet = avoidable <= count * tolerated**2 or before < ABOUT_NOISE * sigma
        return (None if quiet else _unexplained_fault(rods, readings, before)), readings
    close = [
        trial
        for trial in ranked
        if trial is not plain
        and trial.rods != best.rods
        and trial.score(count, floor) - best.score(count, floor) < DECISIVE
    ]
    rivals = tuple(f"{readings.named(trial.rods)} {name_of[id(trial)]}" for trial in close)
    sentence = (
        f"{best.words}: the contradiction of the rods decreases to {length_in_words(after)} rms from "
        f"{length_in_words(before)}; {best.mend}" + (f" (or: {', '.join(rivals)})" if rivals else "")
    )
    names = tuple(rods.names[k] for k in best.rods)
    return RodFault(name_of[id(best)], names, best.size, before, after, rivals, sentence), best.mended


def _closest(ranked: list[RodTrial], plain: RodTrial, count: int, sigma: float) -> RodTrial:
    """Return the first; of faults that a stated noise cannot distinguish from it, the one that leaves least."""
    first = ranked[0]
    if first is plain:
        return first
    faults = [trial for trial in ranked if trial is not plain]
    near = [trial for trial in faults if trial.score(count, sigma) - first.score(count, sigma) < DECISIVE]
    best = min(near, key=lambda trial: trial.score(count, 0.0))
    # One that reads just what it should, turned round or in another's place, is not loose.
    exact = [trial for trial in faults if trial.reads_right and len(trial.rods) <= 2 and best.rods[0] in trial.rods]
    return exact[0] if best.leaves_out and exact and exact[0].squares <= PLAINER * best.squares else best


def _unexplained_fault(rods: Rods, readings: RodReadings, before: float) -> RodFault:
    off = np.sqrt(np.mean(left_over(readings, readings.lengths) ** 2, axis=0)) * readings.used
    names = (rods.names[int(np.argmax(off))],)
    sentence = (
        f"the rods contradict each other by {length_in_words(before)} rms, {names[0]} most, and no single fault "
        "explains it: check the fixing of each rod, and [ids] start_m and end_m"
    )
    return RodFault(UNEXPLAINED, names, float(off.max()), before, before, (), sentence)
