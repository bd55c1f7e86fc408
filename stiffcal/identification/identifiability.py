"""What the data can distinguish, and what not.

With columns scaled to unit length, a direction in which the whitened observation matrix is shorter than 1e-3 is one in
which two regressors agree to a tenth of a per cent: less than the model itself can be trusted, so that a number from it
would be an artefact with an error bar. A parameter whose own standard uncertainty spans all that is possible is not
known either, whatever the others do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.bounded_least_squares import column_scale
from stiffcal.identification.fit import Ambiguity
from stiffcal.identification.undetermined import Undetermined

# Regressors that agree to this are one regressor.
SAME_REGRESSOR = 1e-3
# In a direction that the data do not determine, parameters with a share above this take part.
TAKES_PART = 0.1


@dataclass(frozen=True)
class GivenBefore:
    """What is known of p parameters before any measurement."""

    tolerance: Floats
    """(p,) standard uncertainty in the parameter's unit: an estimate that is no better is none. Infinite: not known."""
    same_motion: Booleans
    """(p,) True for geometry that other parameters make up for in every pose (`stiffcal.identification.gauge`)."""
    undriven: Booleans
    """(p,) True for parameters of joints that were not driven while the flange was clamped."""
    prior: Floats | None = None
    """(p,) standard deviation that the rows hold already, infinite where they hold none: data that determine a
    parameter no better leave it free, and unknown. None: the rows hold none.
    """
    tilt_loaded: Booleans | None = None
    """(p,) True for compliances that weight loads no more than a turn of the base would
    (`stiffcal.identification.base_load`); None: none is.
    """
    common_scale: tuple[int, ...] = ()
    """Numbers of moments and compliances with one unknown scale (`stiffcal.identification.load_scale`); the first keeps
    its value.
    """


@dataclass(frozen=True)
class Identifiability:
    """Which of p parameters can be determined."""

    identifiable: Booleans
    """(p,)."""
    left_at_neutral: Booleans
    """(p,) True for those left at their neutral value, so that the others of their set carry what is known."""
    condition: float
    """Ratio of the largest to the smallest singular value, columns of unit length; infinite where a column is zero."""
    ambiguities: tuple[Ambiguity, ...]
    """Sets that cannot be distinguished."""


def check_identifiability(
    factor: Floats,
    names: tuple[str, ...],
    upper: Floats,
    nonlinear: Booleans | None = None,
    needed: Booleans | None = None,
    noise_dominated: Booleans | None = None,
    redundant: Booleans | None = None,
    given: GivenBefore | None = None,
) -> Identifiability:
    """Find what the whitened, triangular observation matrix cannot determine.

    Parameters
    ----------
    factor : (p, p) triangular factor of the whitened observation matrix.
    names : p full parameter names.
    upper : (p,) largest value that is possible; a standard uncertainty beyond it is no information.
    nonlinear : (p,) True for nonlinear parameters: where one of them takes part, it alone is unknown, because the
        law's size is still known with the shape at its best value.
    needed : (p,) True for those that are not to be held where another of their set can be.
    noise_dominated : (p,) True for those that only the force sensor's noise turns
        (`stiffcal.identification.noise_dominated`).
    redundant : (p,) True for gains of the whole load that all compliances together make up for
        (`stiffcal.identification.load_scale`).
    given : what is known before any measurement; None: nothing.
    """
    p = len(names)
    before = given or GivenBefore(np.full(p, np.inf), np.zeros(p, dtype=np.bool_), np.zeros(p, dtype=np.bool_))
    is_nonlinear = np.zeros(p, dtype=np.bool_) if nonlinear is None else nonlinear
    if p == 0:
        none = np.zeros(0, dtype=np.bool_)
        return Identifiability(none, none, 1.0, ())
    length = np.sqrt(np.sum(factor * factor, axis=0))
    identifiable = np.ones(p, dtype=np.bool_)
    left_out = np.zeros(p, dtype=np.bool_)
    ambiguities: list[Ambiguity] = []
    in_noise = np.zeros(p, dtype=np.bool_) if noise_dominated is None else noise_dominated
    is_redundant = np.zeros(p, dtype=np.bool_) if redundant is None else redundant
    # One standard uncertainty, all else known, is 1 / length.
    reach = np.multiply(length, upper, out=np.zeros(p), where=length > 0.0)
    by_tilt = np.zeros(p, dtype=np.bool_) if before.tilt_loaded is None else before.tilt_loaded
    open_before = in_noise | is_redundant | before.same_motion | before.undriven | by_tilt
    for i in np.flatnonzero((reach < 1.0) | open_before):
        identifiable[i], left_out[i] = False, True
        because = (
            (is_redundant, Undetermined.GAIN_OF_LOAD),
            (before.same_motion, Undetermined.SAME_MOTION),
            (before.undriven, Undetermined.UNDRIVEN),
            (by_tilt, Undetermined.TILT_LOADED),
            (in_noise, Undetermined.WRENCH_NOISE),
        )
        cause = next((cause for applies, cause in because if applies[i]), Undetermined.NO_LOAD)
        ambiguities.append(Ambiguity((names[i],), "", cause))
    if before.common_scale:
        identifiable[before.common_scale[0]], left_out[before.common_scale[0]] = False, True
        ambiguities.append(Ambiguity(tuple(names[i] for i in before.common_scale), "", Undetermined.COMMON_SCALE))
    remaining = np.flatnonzero(identifiable)
    condition = np.inf if len(remaining) < p else 1.0
    if len(remaining):
        unit = np.zeros_like(factor)
        unit[:, remaining] = factor[:, remaining] / column_scale(factor[:, remaining])
        singular = np.linalg.svd(unit[:, remaining], compute_uv=False)
        if len(remaining) == p:
            # Below this a singular value is rounding instead of zero.
            least = p * float(np.finfo(np.float64).eps) * float(singular[0])
            condition = float(singular[0] / singular[-1]) if singular[-1] > least else np.inf
        must_stay = np.zeros(p, dtype=np.bool_) if needed is None else needed
        sums = _hold_dependent(unit, left_out, is_nonlinear, must_stay, SAME_REGRESSOR * float(singular[0]))
        identifiable[left_out & is_nonlinear] = False
        for column in sums:
            null = _null_direction(unit, left_out, column)
            takes_part = np.abs(null) > TAKES_PART * np.max(np.abs(null))
            # Others that nearly agree among themselves may make it with shares far above its own.
            takes_part[column] = True
            members = np.flatnonzero(takes_part)
            identifiable[members] = False
            ambiguities.append(_name_ambiguity(null[members], length[members], [names[i] for i in members]))
        spread = _std_with_others_free(factor, remaining)
        hidden = [i for i in remaining if identifiable[i] and spread[i] > upper[i]]
        for i in hidden:
            identifiable[i], left_out[i] = False, True
            ambiguities.append(Ambiguity((names[i],), "", Undetermined.INSEPARABLE))
        for number in _no_better_than(factor, left_out, before.tolerance):
            identifiable[number], left_out[number] = False, True
            ambiguities.append(Ambiguity((names[number],), "", Undetermined.ASSEMBLY))
    identifiable[list(before.common_scale)] = False
    if before.prior is not None and not left_out.all():
        # where data alone would give the prior's deviation, both together give it divided by the root of two
        spread = _std_with_others_free(factor, np.flatnonzero(~left_out))
        for i in np.flatnonzero(identifiable & (spread * np.sqrt(2.0) > before.prior)):
            identifiable[i] = False
            ambiguities.append(Ambiguity((names[i],), "", Undetermined.ASSEMBLY))
    return Identifiability(identifiable, left_out, condition, tuple(ambiguities))


def _hold_dependent(
    unit: Floats, left_out: Booleans, is_nonlinear: Booleans, stays: Booleans, null_below: float
) -> list[int]:
    """Hold one parameter after the other until the data determine every direction of those left; return them.

    Of such a set the one that came last into the model is held; the others then represent the
    set in predictions. One at a time: sets that overlap mix in the singular vectors, and two taken at once could both
    be what one set needs. Nonlinear parameters that take part are held all at once, and are not returned.

    Parameters
    ----------
    unit : (p, p) factor with columns of unit length.
    left_out : (p,) those held already; filled in place.
    is_nonlinear : (p,) True for nonlinear parameters.
    stays : (p,) True for those that are held only where no other of their set can be.
    null_below : singular values below this are null directions.
    """
    sums: list[int] = []
    while not left_out.all():
        left = np.flatnonzero(~left_out)
        _, singular, directions = np.linalg.svd(unit[:, left])
        if singular[-1] >= null_below:
            break
        share = np.abs(directions[-1]) / np.max(np.abs(directions[-1]))
        members = left[share > TAKES_PART]
        if is_nonlinear[members].any():
            left_out[members[is_nonlinear[members]]] = True
            continue
        may_leave = members[~stays[members]]
        last = int(may_leave[-1] if len(may_leave) else members[-1])
        left_out[last] = True
        sums.append(last)
    return sums


def _null_direction(unit: Floats, left_out: Booleans, column: int) -> Floats:
    """Return the (p,) null direction of a held parameter: the others' combination with its regressor, minus itself."""
    free = np.flatnonzero(~left_out)
    null = np.zeros(unit.shape[1])
    if len(free):
        null[free] = np.linalg.lstsq(unit[:, free], unit[:, column], rcond=None)[0]
    null[column] = -1.0
    return null


def _std_with_others_free(factor: Floats, remaining: NDArray[np.int64]) -> Floats:
    """Return (p,) the standard uncertainty of each parameter that remains, all of these free; 0 of the others."""
    columns = factor[:, remaining]
    scale = column_scale(columns)
    inverse = np.linalg.pinv(columns / scale, rcond=1e-13)
    spread = np.zeros(factor.shape[1])
    spread[remaining] = np.sqrt(np.sum(inverse**2, axis=1)) / scale
    return spread


def _no_better_than(factor: Floats, left_out: Booleans, tolerance: Floats) -> list[int]:
    """Return the parameters that are known no better than their tolerance, the worst first.

    One at a time: what is held where assembly put it may be all that another one lacked.
    """
    held = left_out.copy()
    worst: list[int] = []
    while not held.all():
        free = np.flatnonzero(~held)
        scale = column_scale(factor[:, free])
        inverse = np.linalg.pinv(factor[:, free] / scale, rcond=1e-13)
        ratio = np.sqrt(np.sum(inverse**2, axis=1)) / scale / tolerance[free]
        if ratio.max() <= 1.0:
            break
        worst.append(int(free[np.argmax(ratio)]))
        held[worst[-1]] = True
    return worst


def _name_ambiguity(null: Floats, length: Floats, names: list[str]) -> Ambiguity:
    """Return which combination is known, orthogonal to the null direction."""
    if len(names) == 1:
        return Ambiguity((names[0],), "", Undetermined.NO_LOAD)
    # In scaled parameters y = length × x the data determine what is across ``null``; for two, one combination.
    if len(names) == 2:
        across = np.array([-null[1], null[0]]) * length
        size = np.abs(across)
        # The first of two that only rounding distinguishes: the sign of the combination depends on it.
        across = across / across[int(np.argmax(size >= (1.0 - 1e-9) * size.max()))]
        return Ambiguity(
            tuple(names),
            combination(across.tolist(), names),
            Undetermined.PROPORTIONAL,
            tuple(across.tolist()),
        )
    return Ambiguity(tuple(names), "", Undetermined.DEPENDENT)


def combination(coefficients: list[float], names: list[str]) -> str:
    """Write a sum of parameters.

    Examples
    --------
    >>> combination([1.0, -0.5], ["a", "b"])
    'a − 0.5 × b'
    """
    text = ""
    for coefficient, name in zip(coefficients, names, strict=True):
        size = abs(coefficient)
        sign = "−" if coefficient < 0.0 else "+"
        term = name if abs(size - 1.0) < 5e-4 else f"{size:.3g} × {name}"
        text += f" {sign} {term}" if text else (f"−{term}" if coefficient < 0.0 else term)
    return text
