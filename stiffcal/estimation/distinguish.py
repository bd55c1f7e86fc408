"""Which directions of p parameters the columns of an observation matrix determine, and which parameters are held.

The rank is that of the columns of unit length: their singular values against the largest. As many parameters are held
as it falls short by, chosen by their shares in the directions that are open. One with a small share in all of these
closes none: held at its value, it would move the others by many times its own error. So of those with a fair share the
first of the order is taken, and the columns that stay have the rank of all: what they predict, at their best, is what
all predict at theirs, and no direction is lost. What is parallel, meets or never moves needs no rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats

SAME_REGRESSOR = 1e-3
"""Columns of unit length that agree to this are one: a robot's axes are where its model has them to a milliradian."""
TAKES_PART = 0.1
"""In what is open, parameters with a share above this, of the largest, take part."""


@dataclass(frozen=True)
class Distinguished:
    """What p columns determine."""

    singular: Floats
    """(p,) singular values of the columns scaled to unit length, largest first; a column of zeros stays one."""
    rank: int
    """How many of them are above the threshold."""
    held: tuple[int, ...]
    """p − rank parameters that are held, in the order in which they were chosen."""
    null: Floats
    """(p − rank, p) a direction without effect for each that is held: −1 at its own place, at the free ones their share
    in its column; of columns of unit length.
    """

    @property
    def free(self) -> Booleans:
        """(p,) True for those that are not held."""
        mask = np.ones(self.null.shape[1], dtype=np.bool_)
        mask[list(self.held)] = False
        return mask


def distinguish(columns: Floats, hold_first: Sequence[int], null_below: float = SAME_REGRESSOR) -> Distinguished:
    """Return the rank of columns and the parameters that are held for it.

    Parameters
    ----------
    columns : (m, p) whitened derivatives by the parameters, or their triangular factor.
    hold_first : the p parameters in the order in which they are rather held.
    null_below : share of the largest singular value below which a direction is none.
    """
    p = columns.shape[1]
    if len(columns) < p:
        columns = np.concatenate([columns, np.zeros((p - len(columns), p))])
    length = np.sqrt(np.sum(columns * columns, axis=0))
    unit = columns / np.where(length > 0.0, length, 1.0)
    _, singular, directions = np.linalg.svd(unit, full_matrices=False)
    rank = int(np.count_nonzero(singular > null_below * singular[0])) if p else 0
    held = held_for(directions[rank:], hold_first)
    free = np.delete(np.arange(p), held)
    null = np.zeros((len(held), p))
    null[np.arange(len(held)), held] = -1.0
    if held and len(free):
        null[:, free] = np.linalg.lstsq(unit[:, free], unit[:, held], rcond=None)[0].T
    return Distinguished(singular, rank, held, null)


def held_for(directions: Floats, hold_first: Sequence[int]) -> tuple[int, ...]:
    """Return k parameters without which nothing is open, in the order in which they were chosen.

    Parameters
    ----------
    directions : (k, p) orthonormal directions that are open.
    hold_first : the p parameters in the order in which they are rather held.
    """
    shares = directions.T
    held: list[int] = []
    for _ in range(shares.shape[1]):
        share = np.linalg.norm(shares, axis=1)
        closes = share > TAKES_PART * share.max()
        chosen = next(number for number in hold_first if closes[number])
        held.append(chosen)
        own = shares[chosen] / share[chosen]
        shares = shares - np.outer(shares @ own, own)
    return tuple(held)
