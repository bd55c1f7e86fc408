"""Forms of a law that replace others at its place: the model that members are compared about has the better one.

In the states of clamped motors friction lies before the spring, and a curve is one of torque over angle: in the form in
which the catalogue adds the law it is a part of what it stands for, and what is left reads like another law.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.diagnosis.refits.whole_form import with_whole_form
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.diagnosis.scans.load_scan import weights_of
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.no_balance import NoBalanceError
from stiffcal.model.effect import Effect
from stiffcal.model.forms import TorqueCurve, WholeForm


def in_best_form(states: LoadStates, fit: Fit, refit: Callable[[CompliantRobot], Fit]) -> Fit:
    """Return the fit of the same laws, each in the form that leaves less; both forms have as many parameters.

    Parameters
    ----------
    states : the campaign's load states. fit : of a model. refit : fits another model to the same readings.
    """
    whitening = weights_of(fit)
    for placed in fit.robot.placed:
        whole = with_whole_form(states, fit, placed)
        if whole is None:
            continue
        try:
            other = refit(whole)
        except (NoBalanceError, ArithmeticError):
            # a curve that turns over within the loads is no curve of a spring
            continue
        if _squares(other, whitening) < _squares(fit, whitening):
            fit = other
    return fit


def as_added(chosen: Candidate, candidates: Sequence[Candidate], shape: Mapping[str, float]) -> PlacedEffect:
    """Return a law from which a fit starts: in the form in which the catalogue adds it.

    The form in place of others is that of the model about which the law was chosen; next to one law more, the other
    may leave less.

    Parameters
    ----------
    chosen : the law, in any form. candidates : of the catalogue. shape : of its shape parameters in that form.
    """
    effect = chosen.effect
    if isinstance(effect, WholeForm):
        effect, shape = next(one.effect for one in candidates if one.name == chosen.name), {}
    return PlacedEffect(effect, chosen.place, dict(shape))


def _squares(fit: Fit, whitening: Whitening) -> float:
    """Return the weighted squares that a fit leaves, its runs' offsets taken out."""
    space = Projection.of(fit.data, whitening)
    rows = space.rows(np.where(fit.data.measured_mask, fit.data.measured - fit.predicted, 0.0)[None])
    return float(np.sum(rows**2))


def is_whole(placed: PlacedEffect) -> bool:
    """Return whether a law holds what others of its place would: its curve is that of the spring too."""
    return isinstance(placed.effect, TorqueCurve)


def spring_symbol(placed: PlacedEffect) -> str | None:
    """Return the symbol by which a law is the spring that it holds; None where it holds none."""
    return placed.effect.parameters[0].symbol if is_whole(placed) else None


def spring_of(placed: PlacedEffect, spring: Effect | None) -> PlacedEffect | None:
    """Return the spring that a curve of torque holds, as a law of its own; None where it holds none."""
    symbol = spring_symbol(placed)
    if symbol is None or spring is None or not placed.values.get(symbol):
        return None
    return PlacedEffect(spring, placed.place, {spring.parameters[0].symbol: 1.0 / placed.values[symbol]})


def replaced(robot: CompliantRobot, added: PlacedEffect) -> CompliantRobot:
    """Return a robot with one effect more, without those at its place that it holds."""
    kept = (
        placed
        for placed in robot.placed
        if not (placed.place == added.place and placed.effect.name in added.effect.includes)
    )
    return replace(robot, placed=(*kept, added))
