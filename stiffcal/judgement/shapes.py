"""The shapes of an effect that the readings do not rule out: where a knee, a band or an order is.

A shape parameter is log-uniform over the effect's own grid. About the best value of the grid it is made finer until
next to it the evidence stays, and the sum over all shapes stands as the share of the best one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.candidates import Candidate, variants
from stiffcal.diagnosis.scans.slips import is_slip
from stiffcal.identification.fitting.regressors import Regressor
from stiffcal.judgement.ground import Ground, columns_of, is_of
from stiffcal.judgement.numbers import HOPELESS, SHAPE_ROUNDS, SHAPE_STAYS, SHAPES_TOGETHER
from stiffcal.judgement.priors import UsualSizes
from stiffcal.judgement.shared import Shared
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Effect, ParameterRole


class Shaped(NamedTuple):
    """A law in one of its shapes."""

    regressor: Regressor
    """What it does to the readings."""
    log_share: float
    """Logarithm of the share that the shape and those that read alike have of all shapes, before any reading."""
    settled: float = 1.0
    """Of an order and the like: probability of the shape among all shapes of the law."""


def shapes_of(ground: Ground, candidate: Candidate, scale: UsualSizes) -> list[Shaped]:
    """Return an effect in its best shapes: next to what the model has, and in place of what it has there."""
    placed = present_as(ground, candidate)
    if placed is not None and in_other_form(candidate, placed):
        return [Shaped(ground.state.regressor(placed.effect, placed.place, placed.shape()), 0.0)]
    if is_slip(candidate.effect):
        return _steps(ground, candidate, placed)
    tried = [
        one for one in variants(candidate, ground.state, ground.most_shapes) if len(one.symbols) or one.fixed.any()
    ]
    if placed is not None and not any(is_of(one, placed) for one in tried):
        tried.append(ground.state.regressor(placed.effect, placed.place, placed.shape()))
    if len(tried) < 2:
        return [Shaped(one, 0.0) for one in tried]
    found: dict[tuple[tuple[str, ...], tuple[float, ...]], Shaped] = {}
    for residual, shared in _without(ground, candidate, placed, scale):
        for one in _best_shapes(ground, tried, (residual, shared), scale, placed):
            key = one.regressor.symbols, tuple(one.regressor.shape.values())
            # next to what explains all, every shape reads alike; in its place fewer do
            known = found.get(key, Shaped(one.regressor, 0.0, 0.0))
            share, settled = min(one.log_share, known.log_share), max(one.settled, known.settled)
            found[key] = Shaped(one.regressor, share, settled)
    return list(found.values())


def log_share_of(ground: Ground, candidate: Candidate, placed: PlacedEffect, scale: UsualSizes) -> float:
    """Return the logarithm of the share that an effect's shape in the model, and those that read alike, have of all."""
    return next((one.log_share for one in shapes_of(ground, candidate, scale) if is_of(one.regressor, placed)), 0.0)


def in_other_form(candidate: Candidate, placed: PlacedEffect) -> bool:
    """Return whether a model has an effect in a form that is none of those in which it is tried."""
    forms = candidate.forms or (candidate.effect,)
    return not any(placed.effect.parameters == form.parameters for form in forms)


def present_as(ground: Ground, candidate: Candidate) -> PlacedEffect | None:
    """Return an effect as the model has it at its place; None where it does not."""
    for placed in ground.present:
        if (placed.effect.name, placed.place) == (candidate.effect.name, candidate.place):
            return placed
    return None


def _without(
    ground: Ground, candidate: Candidate, placed: PlacedEffect | None, scale: UsualSizes
) -> Iterator[tuple[Floats, Shared]]:
    """Give whitened residuals (r,) in which an effect's shape is sought, and what every shape has besides.

    Of an effect that the model has: without it. Of another: next to all that the model has, and in place of each at
    the same place. What the model has otherwise is refitted with each shape.
    """
    rivals = [placed] if placed else [one for one in ground.present if one.place == candidate.place]
    if placed is None:
        yield ground.white, _beside(ground, ground.present, scale)
    for rival in rivals:
        columns = columns_of(ground, ground.state.regressor(rival.effect, rival.place, rival.shape()), scale)
        back = columns.present @ columns.rows if len(columns.present) else np.zeros(columns.rows.shape[1])
        yield ground.white + back, _beside(ground, [one for one in ground.present if one is not rival], scale)


def _beside(ground: Ground, present: Sequence[PlacedEffect], scale: UsualSizes) -> Shared:
    """Return what every hypothesis has, with some effects of the model of any size; made once."""
    key = tuple((one.effect.name, one.place) for one in present)
    if key not in ground.with_present:
        shared = ground.shared
        own = [
            columns_of(ground, ground.state.regressor(one.effect, one.place, one.shape()), scale).rows
            for one in present
        ]
        columns = np.concatenate([shared.columns, *own])
        prior = np.insert(shared.prior, [len(shared.columns)] * (len(columns) - len(shared.columns)), 0.0, axis=1)
        ground.with_present[key] = replace(shared, columns=columns, prior=prior) if own else shared
    return ground.with_present[key]


def _best_shapes(
    ground: Ground,
    tried: Sequence[Regressor],
    without: tuple[Floats, Shared],
    scale: UsualSizes,
    placed: PlacedEffect | None,
) -> list[Shaped]:
    """Return the best shape, or that of the model, its share that of all that read alike.

    A fit does not change an order: where another is better than the model's, that and all others are a member too.

    Parameters
    ----------
    without : as of `_without`.
    placed : the effect as in the model, whose shape stands for all: its part is what is taken back. None: it is not
        in the model.
    """
    known = list(tried)
    values = _evidence(ground, known, without, scale)
    symbol = _continuous(known[0].effect)
    none = ground.evidence((), *without).normal(())
    for _ in range(SHAPE_ROUNDS):
        if symbol is None or values.max() < none - HOPELESS:
            break
        new = _between(known, values, symbol)
        if not new:
            break
        first = known[0]
        made = [ground.state.regressor(first.effect, first.place, {symbol: value}) for value in new]
        values = np.append(values, _evidence(ground, made, without, scale))
        known += made
    own = next((k for k, one in enumerate(known) if placed is not None and is_of(one, placed)), None)
    best = int(np.argmax(values)) if own is None else own
    if symbol is None:
        return _of_grid(known, values, best)
    place = np.log([one.shape[symbol] for one in known])
    order = np.argsort(place)
    width = np.gradient(place[order]) if len(order) > 1 else np.ones(1)
    if not width.any():
        return [Shaped(known[best], 0.0)]
    density = values[order] - values[best] + np.log(np.maximum(width, 1e-300))
    share = float(np.logaddexp.reduce(density) - np.log(np.sum(width)))
    return [Shaped(known[best], share if own is not None else min(share, 0.0))]


def _of_grid(known: Sequence[Regressor], values: Floats, own: int) -> list[Shaped]:
    """Return a shape by its number, which stands for all; where another is better, that one for all others."""
    best, each, whole = int(np.argmax(values)), -float(np.log(len(known))), float(np.logaddexp.reduce(values))
    shapes = [spec for spec in known[0].effect.parameters if spec.role is ParameterRole.NONLINEAR]
    settled = np.exp(values - whole) if all(spec.discrete for spec in shapes) else np.ones(len(values))
    if values[own] >= values[best]:
        return [Shaped(known[own], each + whole - float(values[own]), float(settled[own]))]
    others = float(np.logaddexp.reduce(np.delete(values, own)))
    return [
        Shaped(known[own], each, float(settled[own])),
        Shaped(known[best], each + others - float(values[best]), float(settled[best])),
    ]


def _continuous(effect: Effect) -> str | None:
    """Return the symbol of an effect's one shape parameter that can have any value; None without one."""
    shapes = [spec for spec in effect.parameters if spec.role is ParameterRole.NONLINEAR]
    return shapes[0].symbol if len(shapes) == 1 and not shapes[0].discrete else None


def _between(known: Sequence[Regressor], values: Floats, symbol: str) -> list[float]:
    """Return shapes half way from the best to its neighbours, where the evidence changes on the way."""
    place = np.log([one.shape[symbol] for one in known])
    order = np.argsort(place)
    best = int(np.flatnonzero(order == np.argmax(values))[0])
    found = []
    for other in (best - 1, best + 1):
        if 0 <= other < len(order) and abs(values[order[other]] - values[order[best]]) > SHAPE_STAYS:
            between = float(np.exp(0.5 * (place[order[other]] + place[order[best]])))
            if known[0].effect.impossible({symbol: between}) is None:
                found.append(between)
    return found


def _evidence(ground: Ground, tried: Sequence[Regressor], without: tuple[Floats, Shared], scale: UsualSizes) -> Floats:
    """Return (k,) the log evidence of each shape alone."""
    columns = [replace(columns_of(ground, one, scale), present=np.zeros(0)) for one in tried]
    found = []
    for first in range(0, len(columns), SHAPES_TOGETHER):
        evidence = ground.evidence(columns[first : first + SHAPES_TOGETHER], *without)
        found += [evidence.normal([k]) for k in range(len(evidence.members))]
    return np.array(found)


def _steps(ground: Ground, candidate: Candidate, placed: PlacedEffect | None) -> list[Shaped]:
    """Return the step where it explains most, and that of the model; each state is as probable before."""
    count, first = ground.steps()
    places = [] if first is None else [first]
    if placed is not None:
        places.append(float(placed.values["state"]))
    shapes: list[Mapping[str, float]] = [{"state": number} for number in dict.fromkeys(places)]
    share = -float(np.log(max(count, 1)))
    return [Shaped(ground.state.regressor(candidate.effect, candidate.place, shape), share) for shape in shapes]
