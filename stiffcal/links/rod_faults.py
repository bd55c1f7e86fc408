"""Rods that cannot be right: loose, of swapped sign, exchanged, or with a drifting gauge; named by their own data.

Two things hold rods to each other. The link's field: rods beyond the unknowns must agree with the rest in every state.
And the load, where it is known: a beam answers it with five numbers (bending in two planes and their product, twist,
tension), so that a few rods over many states contradict themselves when one is wrong, even where none is to spare.
Each fault is tried on the readings; what is named is the one that takes most of the contradiction away for the fewest
free numbers (Schwarz' criterion), and only when it leaves little of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.links.rods import RodDesign, rod_design
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.measurements.varying import varies
from stiffcal.mechanics.beam import UNKNOWNS, flexibility_patterns
from stiffcal.mechanics.rods import rod_fields
from stiffcal.reduction.rod_temperature import smooth_in_time

FaultKind: TypeAlias = Literal["loose", "swapped-sign", "exchanged", "drifting", "warming", "unexplained"]

# A contradiction smaller than this share of the readings may be the beam's own: sections taper, links shear. The second
# where the rods' noise is not known: then it may be that, too.
TOLERATED, TOLERATED_BLINDLY = 0.10, 0.30
# A rod that is off by less than this share of what it should read is not called loose, for the same reason.
LOOSE = 0.20
# A fault is named when it takes away at least so much of the squared contradiction that is not noise (or of the whole,
# where noise is not known) …
EXPLAINED, EXPLAINED_BLINDLY = 0.75, 0.5
# … and beats no fault by this much in Schwarz' criterion ("very strong": Kass and Raftery 1995). Faults closer to the
# best than this are named together with it.
DECISIVE = 10.0
MOST_FAULTS = 3
# A swapped or exchanged rod may leave this much more, squared, than the same rod called loose.
PLAINER = 1.2


@dataclass(frozen=True)
class RodFault:
    """One fault of one rod, or of two."""

    kind: FaultKind
    """"loose", "swapped-sign", "exchanged", "drifting", "warming" (all rods grow with the logged temperature), or
    "unexplained": something contradicts, and no single fault explains it.
    """
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


@dataclass(frozen=True)
class _RodReadings:
    """The rods' readings and what holds them together."""

    lengths: Floats
    """(n, m) m, less their run's mean."""
    sigma: float
    """m, one number, or 0 where not known."""
    time: Floats | None
    """(n,) s, or None."""
    run: Integers | None
    """(n,) or None."""
    columns: Floats | None
    """(p, n, m) what the rods read per unknown of the load model; None: the field alone."""
    design: RodDesign
    """Of the field."""
    used: NDArray[np.bool_]
    """(m,) False for rods that were already found loose."""
    signed: bool = True
    """True where flexibilities cannot be negative."""
    growth: Floats | None = None
    """(n, m) m, what the rods would grow by the logged temperature if the link expanded by 1/K more than they, less its
    run's mean; None where no temperature changes.
    """


@dataclass(frozen=True)
class _Trial:
    """One fault, tried: its readings mended, the squared contradiction left, and how many numbers that took."""

    kind: FaultKind | None
    rods: tuple[int, ...]
    mended: _RodReadings
    squares: float
    numbers: int
    size: float

    def score(self, count: int, sigma: float) -> float:
        """Schwarz' criterion; noise is the least that can be left."""
        mean = max(self.squares / count, sigma**2, 1e-22)
        return count * float(np.log(mean)) + self.numbers * float(np.log(count))


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
    centred = _centred(run, lengths)
    columns = None if columns is None else np.stack([_centred(run, column) for column in columns])
    used = np.ones(len(rods.names), dtype=np.bool_)
    readings = _RodReadings(
        centred, stated, ticking, run, columns, design, used, growth=_growth(rods, run, time, temperature)
    )
    if columns is None and design.redundancy < 1:
        return ()
    faults: list[RodFault] = []
    while len(faults) < MOST_FAULTS:
        fault, readings = _next_fault(rods, readings)
        if fault is None:
            break
        faults.append(fault)
        if fault.kind == "unexplained":
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
    return _centred(run, np.outer(warm, rods.length))


def _load_columns(rods: Rods, shape: BeamProperties, wrench: Floats) -> Floats:
    """Return (5, n, m): what the rods read per flexibility of an even beam."""
    fields = rod_fields(rods, shape)[:, : len(UNKNOWNS)]
    return np.stack([wrench @ (fields @ per_load).T for per_load in flexibility_patterns(shape)])


def _next_fault(rods: Rods, readings: _RodReadings) -> tuple[RodFault | None, _RodReadings]:
    trials = [trial for trial in _trials(readings) if _is_large(trial, readings)]
    count, sigma = max(_count(readings), 2), readings.sigma
    ranked = sorted(trials, key=lambda trial: trial.score(count, sigma))
    plain, best = trials[0], _closest(ranked, count, sigma)
    before, after = float(np.sqrt(plain.squares / count)), float(np.sqrt(best.squares / count))
    gain = plain.score(count, sigma) - best.score(count, sigma)
    avoidable = plain.squares - count * sigma**2
    explained = 1.0 - (best.squares - count * sigma**2) / avoidable if avoidable > 1e-12 * plain.squares else 0.0
    enough = EXPLAINED if sigma > 0.0 else EXPLAINED_BLINDLY
    # What grows slowly counts as noise between repeats a cycle apart: that noise is no proof against it.
    floor, bare = sigma, min(trials, key=lambda trial: trial.score(count, 0.0))
    remaining = float(np.sqrt(bare.squares / count))
    slow = bare.kind == "warming" or (bare.kind == "drifting" and bare.size > remaining)
    if slow and plain.score(count, 0.0) - bare.score(count, 0.0) >= DECISIVE:
        best, gain, explained, floor, after = bare, np.inf, 1.0, 0.0, remaining
    if best.kind is None or gain < DECISIVE or explained < enough:
        lengths = readings.lengths[:, readings.used]
        tolerated = (TOLERATED if sigma > 0.0 else TOLERATED_BLINDLY) * float(np.sqrt(np.mean(lengths**2)))
        quiet = avoidable <= count * tolerated**2 or before < 1.5 * sigma
        return (None if quiet else _unexplained(rods, readings, before)), readings
    close = [
        trial
        for trial in ranked
        if trial.kind is not None
        and trial.rods != best.rods
        and trial.score(count, floor) - best.score(count, floor) < DECISIVE
    ]
    rivals = tuple(_label(trial, rods) for trial in close)
    names = tuple(rods.names[i] for i in best.rods)
    fault = RodFault(
        best.kind, names, _size(best, readings), before, after, rivals, _sentence(best, names, before, after, rivals)
    )  # fmt: skip
    return fault, best.mended


def _closest(ranked: list[_Trial], count: int, sigma: float) -> _Trial:
    """Return the first; of faults that a stated noise cannot distinguish from it, the one that leaves least."""
    first = ranked[0]
    if first.kind is None:
        return first
    near = [
        trial for trial in ranked if trial.kind and trial.score(count, sigma) - first.score(count, sigma) < DECISIVE
    ]
    best = min(near, key=lambda trial: trial.score(count, 0.0))
    # One that reads just what it should, turned round or in another's place, is not loose.
    exact = [trial for trial in ranked if trial.kind in ("swapped-sign", "exchanged") and len(trial.rods) <= 2]
    plain = [trial for trial in exact if best.rods[0] in trial.rods]
    return plain[0] if best.kind == "loose" and plain and plain[0].squares <= PLAINER * best.squares else best


def _size(trial: _Trial, readings: _RodReadings) -> float:
    """Return the rms of what is wrong, m; of rods that grow, their growth."""
    if trial.kind != "warming":
        return trial.size
    return float(np.sqrt(np.mean((trial.mended.lengths - readings.lengths) ** 2)))


def _is_large(trial: _Trial, readings: _RodReadings) -> bool:
    """Return whether a fault is large enough to be one."""
    if trial.kind != "loose":
        return True
    (rod,) = trial.rods
    should = np.sqrt(np.mean((readings.lengths - _left(trial.mended, readings.lengths))[:, rod] ** 2))
    return bool(trial.size > max(LOOSE * should, 2.0 * readings.sigma))


def _unexplained(rods: Rods, readings: _RodReadings, before: float) -> RodFault:
    off = np.sqrt(np.mean(_left(readings, readings.lengths) ** 2, axis=0)) * readings.used
    names = (rods.names[int(np.argmax(off))],)
    sentence = (
        f"the rods contradict each other by {1e6 * before:.3g} µm rms, most of all {names[0]}, and no single fault "
        "explains it: look at how each rod is fixed, and at [ids] start_m and end_m"
    )
    return RodFault("unexplained", names, float(off.max()), before, before, (), sentence)


def _trials(readings: _RodReadings) -> Iterator[_Trial]:
    """Try no fault first, then each fault at each place."""
    count = np.flatnonzero(readings.used)
    known = 0 if readings.columns is None else len(readings.columns)
    yield _Trial(None, (), readings, *_squares(readings), 0.0)
    flips = [(int(i),) for i in count] + ([tuple(int(i) for i in count)] if known else [])
    for rods in flips:
        sign = np.ones(readings.lengths.shape[1])
        sign[list(rods)] = -1.0
        yield _mended("swapped-sign", rods, readings, readings.lengths * sign)
    if known and readings.growth is not None:
        yield _warming(readings)
    for a, b in combinations(count, 2):
        order = np.arange(readings.lengths.shape[1])
        order[[a, b]] = order[[b, a]]
        yield _mended("exchanged", (int(a), int(b)), readings, readings.lengths[:, order])
    for i in count:
        if readings.time is not None:
            yield _drifting(int(i), readings)
        used = readings.used.copy()
        used[i] = False
        without_rod = replace(readings, used=used)
        if readings.columns is not None or int(used.sum()) > len(readings.design.carried):
            yield from _loose(int(i), readings, without_rod)


def _loose(rod: int, readings: _RodReadings, left: _RodReadings) -> Iterator[_Trial]:
    """Leave a rod out; or, where the load is known, let it answer the load in its own way, for fewer free numbers."""
    squares, numbers = _squares(left)
    off = _left(left, readings.lengths)[:, rod]
    size = float(np.sqrt(np.mean(off**2)))
    yield _Trial("loose", (rod,), left, squares, numbers + len(off), size)
    if readings.columns is not None:
        only_rod = np.zeros(len(readings.used), dtype=np.bool_)
        only_rod[rod] = True
        alone, more = _squares(replace(readings, used=only_rod, signed=False))
        yield _Trial("loose", (rod,), left, squares + alone, numbers + more, size)


def _mended(kind: FaultKind, rods: tuple[int, ...], readings: _RodReadings, lengths: Floats) -> _Trial:
    mended = replace(readings, lengths=lengths)
    size = float(np.sqrt(np.mean((lengths - readings.lengths)[:, list(rods)] ** 2)))
    return _Trial(kind, rods, mended, *_squares(mended), size)


def _drifting(rod: int, readings: _RodReadings) -> _Trial:
    """Take out of one rod what grows with the time since each run began, bent by a square."""
    time = _since_start(readings)
    span = max(float(time.max()), 1e-12)
    columns = np.zeros((2, *readings.lengths.shape))
    columns[0, :, rod], columns[1, :, rod] = time / span, (time / span) ** 2
    centred = np.stack([_centred(readings.run, column) for column in columns])
    drifts = [_left(readings, column)[:, readings.used].ravel() for column in centred]
    target = _left(readings, readings.lengths)[:, readings.used].ravel()
    rate = np.linalg.lstsq(np.stack(drifts, axis=1), target, rcond=None)[0]
    mended = replace(readings, lengths=readings.lengths - np.einsum("p,pnm->nm", rate, centred))
    squares, numbers = _squares(mended)
    size = float(np.sqrt(np.mean((rate @ columns[:, :, rod]) ** 2)))
    return _Trial("drifting", (rod,), mended, squares, numbers + 2, size)


def _warming(readings: _RodReadings) -> _Trial:
    """Take out of all rods what they grow by with the temperature, at one expansion for all."""
    assert readings.growth is not None
    expected = _left(readings, readings.growth)[:, readings.used].ravel()
    target = _left(readings, readings.lengths)[:, readings.used].ravel()
    expansion = float(expected @ target / max(float(expected @ expected), np.finfo(float).tiny))
    mended = replace(readings, lengths=readings.lengths - expansion * readings.growth)
    squares, numbers = _squares(mended)
    rods = tuple(int(i) for i in np.flatnonzero(readings.used))
    return _Trial("warming", rods, mended, squares, numbers + 1, expansion)


def _since_start(readings: _RodReadings) -> Floats:
    """Return (n,) seconds since each run's first state: gauges are zeroed with each run."""
    time = np.zeros(len(readings.lengths)) if readings.time is None else readings.time
    if readings.run is None:
        return time
    begun = time.copy()
    for run in np.unique(readings.run):
        begun[readings.run == run] = time[readings.run == run].min()
    return np.asarray(time - begun)


def _count(readings: _RodReadings) -> int:
    """Return how many numbers hold the rods to each other."""
    n, rods = len(readings.lengths), readings.lengths.shape[1]
    return int(n * (rods if readings.columns is not None else max(rods - len(readings.design.carried), 1)))


def _squares(readings: _RodReadings) -> tuple[float, int]:
    """Return the squared contradiction of the rods in use, and how many numbers the explanation took."""
    contradiction = _left(readings, readings.lengths)[:, readings.used]
    offsets = 0 if readings.run is None else len(np.unique(readings.run)) * int(readings.used.sum())
    numbers = 0 if readings.columns is None else len(readings.columns)
    return float(np.sum(contradiction**2)), numbers + offsets


def _centred(run: Integers | None, lengths: Floats) -> Floats:
    """Return (n, m) readings less their run's mean."""
    if run is None:
        return lengths
    result = lengths.copy()
    for number in np.unique(run):
        members = run == number
        result[members] -= result[members].mean(axis=0)
    return result


def _left(readings: _RodReadings, read: Floats) -> Floats:
    """Return (n, m) what the load model, or the field alone, leaves of readings; all rods, fitted to those in use."""
    used = readings.used
    if readings.columns is None:
        matrix = readings.design.matrix
        return np.asarray(read - read[:, used] @ np.linalg.pinv(matrix[used]).T @ matrix.T)
    columns = readings.columns
    rows = columns[:, :, used].reshape(len(columns), -1).T
    size = np.linalg.norm(rows, axis=0)
    size[size == 0.0] = 1.0
    flexible = np.linalg.lstsq(rows / size, read[:, used].ravel(), rcond=1e-9)[0] / size
    # A link does not bend against its load: that is a sign, not a flexibility.
    if readings.signed:
        flexible[[0, 1, 3, 4]] = np.maximum(flexible[[0, 1, 3, 4]], 0.0)
    return np.asarray(read - np.einsum("p,pnm->nm", flexible, columns))


def _label(trial: _Trial, rods: Rods) -> str:
    return f"{' and '.join(rods.names[i] for i in trial.rods)} {trial.kind}"


def _sentence(best: _Trial, names: tuple[str, ...], before: float, after: float, alternatives: tuple[str, ...]) -> str:
    rods = " and ".join(names)
    rms = f"the rods then contradict each other by {1e6 * after:.3g} µm rms instead of {1e6 * before:.3g} µm"
    sentences = {
        "swapped-sign": f"{rods} reads with the wrong sign: {rms}; swap it in the log or exchange start_m and end_m",
        "exchanged": f"{rods} are exchanged: {rms}; swap their columns or their places in [ids]",
        "drifting": f"{rods} drifts by {1e6 * best.size:.3g} µm rms within a run: {rms}; let the gauge warm up, or "
        "zero it more often",
        "warming": f"all rods grow with the logged temperature, {1e6 * best.size:.3g} µm per metre and kelvin: {rms}; "
        "write expansion_per_K of the link ([links] in robot.toml) and of each rod ([ids])",
        "loose": f"{rods} does not follow the link ({1e6 * best.size:.3g} µm rms off): without it {rms}; look at how "
        "it is fixed",
    }
    if len(names) > 2:
        sentences["swapped-sign"] = f"all rods read with the wrong sign, or the load does: {rms}; look at acts_on"
    text = sentences[str(best.kind)]
    return text + (f" (or: {', '.join(alternatives)})" if alternatives else "")
