"""Campaigns of one robot with their fits, and the parameters that all of them know."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.workflow.steps import Ingested


@dataclass(frozen=True)
class FittedCampaign:
    """One campaign with its fit."""

    folder: Path
    """As it was named."""
    data: Ingested
    """Its load states."""
    fit: IdentifyResult
    """Its fit."""


@dataclass(frozen=True)
class ChartedParameter:
    """A parameter that every campaign knows, ready for the chart."""

    name: str
    """``effect.place.symbol``."""
    values: Floats
    """(n,) one a campaign, of what is estimated: logarithms where ``relative``, else amplitudes."""
    std: Floats
    """(n,) the fits' standard uncertainties of these."""
    relative: bool
    """Whether the values are logarithms."""
    inverted: bool
    """Whether people read one over it: of compliances the stiffness."""
    between: float | None
    """Standard deviation between campaigns by the manifest, of these values; None where it does not say."""


def deviation_of(charted: ChartedParameter, since: int | None) -> float:
    """Return the standard deviation of one campaign's value on an unchanged robot.

    Parameters
    ----------
    charted : the parameter.
    since : number of the first campaign after a change; the values before and after it have means of their own.
    """
    if charted.between is not None:
        return float(np.sqrt(charted.between**2 + np.mean(charted.std**2)))
    parts = [part for part in np.split(charted.values, [] if since is None else [since]) if len(part)]
    squares = sum(float(np.sum((part - part.mean()) ** 2)) for part in parts)
    return math.sqrt(squares / max(len(charted.values) - len(parts), 1))
