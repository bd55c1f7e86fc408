"""The evidence for an effect: the residual against what drives the effect, before and after adding it.

For each effect that a model gained (or would gain) the model without it is fitted again, everything else free, and both
models are judged in every pose by a fit made without it. Each residual is then read in the one direction in which
the effect moves the target in that state, so that thousands of vectors become one curve over the effect's covariate.

Where the effect turns or shifts one thing (a joint, a node), a state's residual r and the lever l of a unit turn give
the turn that r amounts to, l·r / l·l (least squares); times the mean lever this is a length at the tool that does not
depend on how far the tool happened to stand off. States whose lever is short constrain the turn little and
are left out.

Where it gives across several axes, its load (a tilting moment) has components and no sign: it is drawn with the sign
of the component along the line in which the loads mostly lie, and a residual is read as the load to which it amounts.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.diagnosis.refits.forecast import contribution_of, heldout_residual
from stiffcal.diagnosis.scans.load_scan import LoadScan
from stiffcal.estimation.unknowns import ParameterColumn
from stiffcal.identification.fitting.regressors import Linearised, Regressor
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import GAUGE, MEASURE_OF, ROTATION, TRANSLATION, RowMeasure
from stiffcal.measurements.load_states import members_of
from stiffcal.measurements.rms import Rms
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Effect
from stiffcal.quantity import of_measure
from stiffcal.validation.validate import rms_of

# A turn read off a lever four times shorter than the mean is four times as noisy.
SHORT_LEVER = 0.25
# An effect acts along one line where that accounts for nine tenths of its squares.
ONE_LINE = 0.9
# A covariate takes both signs where the lesser side reaches this share of the greater.
BOTH_SIGNS = 0.1


@dataclass(frozen=True)
class EffectEvidence:
    """The residual that one effect accounts for, over the n states of a fit."""

    placed: PlacedEffect
    """The effect, its place and the values with which it is in the model."""
    covariate: str
    """What the residual is drawn against."""
    unit: str
    """The covariate's unit, "1" for a number."""
    measure: RowMeasure
    """What is read: "translation" (m, at the tool), "rotation" (rad), "length" (m, of rods), "motor_angle" (rad)."""
    lever: float | None
    """m or 1, mean lever that turns (or shifts) were multiplied with; None where the residual itself is projected."""
    index: Integers
    """(n,) the states' indices in the campaign's load states."""
    value: Floats
    """(n,) the covariate."""
    before: Floats
    """(n,) m or rad, residual in held-out poses without the effect; NaN where nothing can be read."""
    after: Floats
    """(n,) m or rad, residual in held-out poses with the effect; NaN where nothing can be read."""
    law: Floats
    """(n,) m or rad, what the effect adds in the same direction, counted from the weight-only state."""
    rms_before: Rms
    """Rms of the residual vector in held-out poses without the effect."""
    rms_after: Rms
    """Rms of the residual vector in held-out poses with the effect."""
    by_run: tuple[tuple[int, float, float], ...]
    """(run number, rms before, rms after) of the same kind as ``before``, m or rad."""
    along: Floats
    """(n, 3) the direction, base axes: its inner product with a residual of the first target's translation (or
    rotation) is ``before``; NaN where nothing can be read, and where no such residual is read.
    """


def evidence_for(
    scan: LoadScan, chosen: Collection[str], catalogue: Mapping[str, Effect], kept_names: Collection[str] = ()
) -> Iterator[EffectEvidence]:
    """Take each chosen effect out of a fitted model in turn, and compute what it accounts for.

    Parameters
    ----------
    scan : the scan of the model that holds the effects.
    chosen : ``effect place-label`` of those to look at.
    catalogue : effects by name.
    kept_names : ``effect place-label`` that the model would hold in place of one that includes it.

    Yields
    ------
    EffectEvidence
        In the order of the model; effects without free parameters are passed over.
    """
    state = Linearised.about(scan.fit.robot, scan.fit.data)
    columns = scan.fit.columns
    for number, placed_effect in enumerate(scan.fit.robot.placed):
        if f"{placed_effect.effect.name} {placed_effect.place.label}" in chosen and any(
            column.placed == number for column in columns
        ):
            included = [
                state.regressor(catalogue[name], placed_effect.place, {})
                for name in placed_effect.effect.includes
                if f"{name} {placed_effect.place.label}" in kept_names and name in catalogue
            ]
            yield _evidence(scan, state, columns, number, included)


def _evidence(
    scan: LoadScan, state: Linearised, columns: list[ParameterColumn], number: int, included: list[Regressor]
) -> EffectEvidence:
    placed_effect, data = scan.fit.robot.placed[number], scan.fit.data
    added = contribution_of(state, placed_effect)
    other_columns = np.array([column.placed != number for column in columns], dtype=np.bool_)
    before = heldout_residual(scan, other_columns, included, scan.residual + added)
    after = heldout_residual(scan, np.ones_like(other_columns), (), scan.residual)
    rows = _rows_with_largest_signal(scan, added, after)
    value, covariate, unit, has_parts = _covariate(state, placed_effect)
    if has_parts:
        direction, lever = _by_response(added, rows, value), None
    else:
        direction, lever = _directions(state, placed_effect, added, rows, value if covariate else None)
    law = _along(direction, added, rows)
    measure = MEASURE_OF[data.kind[rows[0]]]
    if not covariate:
        shown = of_measure(measure).usual
        value, covariate = law * shown.factor, f"contribution of {placed_effect.effect.name}"
        unit = shown.name
    return EffectEvidence(
        placed_effect, covariate, unit, measure, lever, data.index, value,
        _along(direction, before, rows), _along(direction, after, rows), law,
        Rms.of(rms_of(before, data)), Rms.of(rms_of(after, data)),
        _by_run(data.run, before[rows], after[rows], np.any(data.measured_mask[rows], axis=0)),
        _vectors(data, direction, rows),
    )  # fmt: skip


def _rows_with_largest_signal(scan: LoadScan, contribution: Floats, residual_after: Floats) -> Integers:
    """Return the rows of one kind of reading in which the effect is largest against what remains with it.

    Compared are translations and rotations of the first target, and gauges; where none was measured, the rods of one
    link are returned.

    Parameters
    ----------
    scan : of the model that holds the effect.
    contribution : (m, n) m and rad, what the effect adds to each reading.
    residual_after : (m, n) m and rad, the residual in held-out poses with the effect.
    """
    data = scan.fit.data
    best, best_rows = -1.0, np.flatnonzero((data.kind == data.kind[0]) & (data.body == data.body[0]))
    for kind in (TRANSLATION, ROTATION, GAUGE):
        rows = np.flatnonzero((data.kind == kind) & (data.body == 0))
        if len(rows):
            noise = float(np.sum(residual_after[rows] ** 2))
            signal = float(np.sum(scan.space.centred(contribution[None])[0][rows] ** 2)) / max(noise, 1e-300)
            if signal > best:
                best, best_rows = signal, rows
    return best_rows


def _covariate(state: Linearised, placed_effect: PlacedEffect) -> tuple[Floats, str, str, bool]:
    """Return the effect's own covariate: values, label, unit; an empty label where it names none.

    The last is True where it is the length of something with components: the values are then how far the load changes
    it, with the sign of its part along the line in which most of these changes lie; NaN where a component is no number.
    """
    covariate = placed_effect.covariate(state.robot.chain, state.loads)
    if covariate is None or not np.isfinite(covariate.value).any():
        return np.zeros(state.data.n_states), "", "", False
    if covariate.parts is None:
        return np.asarray(covariate.value, dtype=np.float64), covariate.label, covariate.unit, False
    under_weight = placed_effect.covariate(state.robot.chain, state.bare)
    assert under_weight is not None
    assert under_weight.parts is not None
    change = covariate.parts - under_weight.parts
    known = np.isfinite(change).all(axis=0)
    main_line = np.linalg.eigh(change[:, known] @ change[:, known].T)[1][:, -1]
    main_line *= np.sign(main_line[np.argmax(np.abs(main_line))])
    size = np.where(known, np.linalg.norm(change, axis=0), np.nan)
    return np.where(main_line @ change < 0.0, -size, size), f"{covariate.label} by the load", covariate.unit, True


def _by_response(added: Floats, rows: Integers, load: Floats) -> Floats:
    """Return (m, n) vectors v such that v·r is the load to which a residual r amounts, times the mean response.

    Responses, what the effect adds by unit of its load, differ with the levers of a pose: read along what is added,
    with no regard to its length, loads of one size would lie far apart. States with a short response, or hardly any
    load, say little of it and are left out, as are those whose load is not known.

    Parameters
    ----------
    added : (m, n) m and rad. rows : those that are read. load : (n,) with its sign; NaN: not known.
    """
    direction = np.full_like(added, np.nan)
    size = np.nan_to_num(np.abs(load))
    loaded = size > SHORT_LEVER**2 * float(size.max(initial=0.0))
    response = added[rows] / np.where(loaded, load, np.nan)
    squares = np.sum(response**2, axis=0)
    mean = float(np.sqrt(np.nanmean(squares))) if loaded.any() else 0.0
    clear = loaded & (np.nan_to_num(squares) > (SHORT_LEVER * mean) ** 2)
    direction[np.ix_(rows, np.flatnonzero(clear))] = response[:, clear] / squares[clear] * mean
    return direction


def _directions(
    state: Linearised, placed_effect: PlacedEffect, added: Floats, rows: Integers, covariate: Floats | None
) -> tuple[Floats, float | None]:
    """Return (m, n) vectors v such that v·r is the component of residual r along the effect, and the mean lever.

    Along the lever of the node that turns, where that is one; else along one fixed line, where the effect keeps to it;
    else along what it adds in each state, the sign that of its covariate.
    """
    lever = _common_lever(state, placed_effect, rows)
    direction = np.full_like(added, np.nan)
    measured_mask = state.data.measured_mask[rows]
    if lever is not None:
        lever = np.where(measured_mask, lever[rows], 0.0)
        squares = np.sum(lever**2, axis=0)
        mean = float(np.sqrt(squares[squares > 0.0].mean())) if (squares > 0.0).any() else 0.0
        long = squares > (SHORT_LEVER * mean) ** 2
        direction[np.ix_(rows, np.flatnonzero(long))] = lever[:, long] / squares[long] * mean
        return direction, mean
    added_rows = added[rows]
    values, vectors = np.linalg.eigh(added_rows @ added_rows.T)
    if values[-1] > ONE_LINE * values.sum():
        line = vectors[:, -1] * np.sign(vectors[np.argmax(np.abs(vectors[:, -1])), -1])
        direction[rows] = line[:, None]
        return direction, None
    size = np.sqrt(np.sum(added_rows**2, axis=0))
    sign = np.ones(len(size))
    if covariate is not None:
        low, high = np.nanmin(covariate), np.nanmax(covariate)
        if low < 0.0 < high and min(-low, high) > BOTH_SIGNS * max(-low, high):
            sign = np.where(covariate < 0.0, -1.0, 1.0)
    clear = size > SHORT_LEVER**2 * float(size.max(initial=0.0))
    direction[np.ix_(rows, np.flatnonzero(clear))] = added_rows[:, clear] / size[clear] * sign[clear]
    return direction, None


def _common_lever(state: Linearised, placed_effect: PlacedEffect, rows: Integers) -> Floats | None:
    """Return (m, n) the lever of the one thing that the effect turns or shifts; None where it moves several."""
    displacements: dict[tuple[int, int], Floats] = {}
    chain = state.robot.chain
    for loads, sign in ((state.loads, 1.0), (state.bare, -1.0)):
        for term in placed_effect.terms(chain, loads):
            value = sign * placed_effect.amplitude(term.symbol) * term.value
            key = (term.node, term.component)
            displacements[key] = displacements[key] + value if key in displacements else value
    projections = {
        key: (lever, value)
        for key, value in displacements.items()
        if (lever := state.lever(*key)) is not None and value.any()
    }
    if not projections:
        return None
    size = {key: float(np.sum((lever * value)[rows] ** 2)) for key, (lever, value) in projections.items()}
    lead = max(size, key=lambda key: size[key])
    whole, drive = projections[lead]
    covered = whole * drive
    for key, (lever, value) in projections.items():
        # A drive on mechanically coupled axes turns several joints, in fixed proportion.
        factor = float(value @ drive) / float(drive @ drive)
        if key != lead and np.allclose(value, factor * drive, atol=1e-6 * float(np.abs(drive).max())):
            whole, covered = whole + factor * lever, covered + lever * value
    total = np.asarray(sum(lever * value for lever, value in projections.values()))[rows]
    left = float(np.sum((total - covered[rows]) ** 2))
    return whole if left <= (1.0 - ONE_LINE) * float(np.sum(total**2)) else None


def _along(direction: Floats, residual: Floats, rows: Integers) -> Floats:
    return np.asarray(np.sum(direction[rows] * residual[rows], axis=0))


def _vectors(data: Observations, direction: Floats, rows: Integers) -> Floats:
    """Return (n, 3) directions in base axes; NaN where they are not of the first target's translation or rotation."""
    vectors = np.full((data.n_states, 3), np.nan)
    if set(data.kind[rows]) <= {TRANSLATION, ROTATION}:
        vectors[:] = 0.0
        for row in rows:
            vectors[:, int(data.component[row]) % 3] = direction[row]
    return vectors


def _by_run(run: Integers, before: Floats, after: Floats, measured: Booleans) -> tuple[tuple[int, float, float], ...]:
    """Return (run, rms before, rms after), lengths of vectors, of runs in which the kind was read."""
    rms_by_run = []
    for members in members_of(run):
        if not measured[members].any():
            continue
        first, second = (
            float(np.sqrt(np.mean(np.sum(residual[:, members] ** 2, axis=0)))) for residual in (before, after)
        )
        rms_by_run.append((int(run[members[0]]), first, second))
    return tuple(rms_by_run)
