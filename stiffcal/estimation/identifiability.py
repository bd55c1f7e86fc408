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
from stiffcal.estimation.distinguish import TAKES_PART, distinguish
from stiffcal.estimation.triangular import scaled_inverse
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.estimation.unknowns import Unknowns
from stiffcal.natural_order import NameKey, natural_key

SPRINGS = "joint-compliance"


@dataclass(frozen=True)
class Ambiguity:
    """Parameters that these data cannot distinguish from each other, and what of them is known."""

    names: tuple[str, ...]
    """The parameters."""
    known: str
    """The combination that is known, in words; "" where nothing is."""
    cause: Undetermined
    """Why."""
    coefficients: tuple[float, ...] = ()
    """Of the known combination, one per name; empty where nothing is known."""
    value: float | None = None
    """The value of the known combination; None where there is none."""
    std: float | None = None
    """Its standard uncertainty; None where there is none."""


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


def check_identifiability(factor: Floats, unknowns: Unknowns, needed: Booleans | None = None) -> Identifiability:
    """Find what the whitened, triangular observation matrix cannot determine.

    Parameters
    ----------
    factor : (p, p) triangular factor of the whitened observation matrix.
    unknowns : the p parameters; a standard uncertainty beyond the largest possible value is no information.
    needed : (p,) True for those that are not to be held where another of their set can be.
    """
    p, names = len(unknowns), unknowns.names
    if p == 0:
        none = np.zeros(0, dtype=np.bool_)
        return Identifiability(none, none, 1.0, ())
    length = np.sqrt(np.sum(factor * factor, axis=0))
    identifiable = np.ones(p, dtype=np.bool_)
    left_out = np.zeros(p, dtype=np.bool_)
    ambiguities: list[Ambiguity] = []
    upper, is_nonlinear, before = unknowns.widest, unknowns.nonlinear, unknowns.open_before
    # One standard uncertainty, all else known, is 1 / length.
    reach = np.multiply(length, upper, out=np.zeros(p), where=length > 0.0)
    for number, name in enumerate(names):
        if reach[number] < 1.0 or name in before.causes:
            identifiable[number], left_out[number] = False, True
            ambiguities.append(Ambiguity((name,), "", before.causes.get(name, Undetermined.NO_LOAD)))
    scaled_alike = [names.index(name) for name in before.common_scale if name in names]
    if scaled_alike:
        identifiable[scaled_alike[0]], left_out[scaled_alike[0]] = False, True
        ambiguities.append(Ambiguity(tuple(names[i] for i in scaled_alike), "", Undetermined.COMMON_SCALE))
    remaining = np.flatnonzero(identifiable)
    condition = np.inf if len(remaining) < p else 1.0
    if len(remaining):
        must_stay = np.zeros(p, dtype=np.bool_) if needed is None else needed
        # of a set nonlinear parameters are held rather than amplitudes, and of these the last by the name of its entry:
        # the order of a model's entries decides nothing
        kept = np.empty(p, dtype=np.int64)
        kept[sorted(range(p), key=lambda i: _kept_first(names[i]))] = np.arange(p)
        order = np.lexsort((-kept[remaining], must_stay[remaining], ~is_nonlinear[remaining]))
        found = distinguish(factor[:, remaining], order.tolist())
        if len(remaining) == p:
            # Below this a singular value is rounding instead of zero.
            least = p * float(np.finfo(np.float64).eps) * float(found.singular[0])
            condition = float(found.singular[0] / found.singular[-1]) if found.singular[-1] > least else np.inf
        left_out[remaining[list(found.held)]] = True
        for column, null in zip(remaining[list(found.held)], found.null, strict=True):
            members = _members(null, remaining, column)
            identifiable[[column] if is_nonlinear[column] else members] = False
            if not is_nonlinear[column]:
                own = null[np.searchsorted(remaining, members)]
                ambiguities.append(_name_ambiguity(own, length[members], [names[i] for i in members]))
        limits = (
            (np.where(identifiable, upper, np.inf), Undetermined.INSEPARABLE),
            (unknowns.tolerance, Undetermined.ASSEMBLY),
        )
        for limit, cause in limits:
            for number in _no_better_than(factor, left_out, limit):
                identifiable[number], left_out[number] = False, True
                ambiguities.append(Ambiguity((names[number],), "", cause))
    identifiable[scaled_alike] = False
    if np.isfinite(unknowns.prior).any() and not left_out.all():
        # where data alone would give the prior's deviation, both together give it divided by the root of two
        spread = _std_with_others_free(factor, np.flatnonzero(~left_out))
        for i in np.flatnonzero(identifiable & (spread * np.sqrt(2.0) > unknowns.prior)):
            identifiable[i] = False
            ambiguities.append(Ambiguity((names[i],), "", Undetermined.ASSEMBLY))
    return Identifiability(identifiable, left_out, condition, tuple(ambiguities))


def _kept_first(name: str) -> tuple[bool, NameKey]:
    """Return the key by which entries are kept: springs of joints first, which models begin with, then by name."""
    return not name.startswith(f"{SPRINGS}."), natural_key(name.rpartition(".")[0])


def _members(null: Floats, remaining: NDArray[np.int64], column: int) -> NDArray[np.int64]:
    """Return the numbers of those that take part in a direction without effect.

    Parameters
    ----------
    null : the direction, of the parameters `remaining`. column : the number of the one that is held for it.
    """
    takes_part = np.abs(null) > TAKES_PART * np.max(np.abs(null))
    # Others that nearly agree among themselves may make it with shares far above its own.
    takes_part[np.searchsorted(remaining, column)] = True
    return np.asarray(remaining[takes_part])


def _std_with_others_free(factor: Floats, remaining: NDArray[np.int64]) -> Floats:
    """Return (p,) the standard uncertainty of each parameter that remains, all of these free; 0 of the others."""
    spread = np.zeros(factor.shape[1])
    spread[remaining] = np.sqrt(np.sum(scaled_inverse(factor[:, remaining]) ** 2, axis=1))
    return spread


def _no_better_than(factor: Floats, left_out: Booleans, tolerance: Floats) -> list[int]:
    """Return the parameters that are known no better than their tolerance, the worst first.

    One at a time: what is held, where assembly put it or where it does nothing, may be all that another one lacked.
    """
    held = left_out.copy()
    worst: list[int] = []
    while not held.all():
        free = np.flatnonzero(~held)
        ratio = _std_with_others_free(factor, free)[free] / tolerance[free]
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
