"""The share of the error that goes with what is missing, in words."""

from __future__ import annotations

import math

from stiffcal.diagnosis.scans.explained import Explained


def share_in_words(explained: Explained, n_effects: int, noise_known: bool) -> str:
    """Return which share of the error goes with what is missing, with its 95 % interval.

    Parameters
    ----------
    explained : the share. n_effects : how many effects are missing.
    noise_known : whether the share is of the error beyond the noise; else of all squares.
    """
    avoidable = "avoidable error" if noise_known else "squared error"
    low, share, high = (f"{100.0 * value:.0f}" for value in (explained.low, explained.share, explained.high))
    if low == high:
        # Ends that are printed alike would look exact.
        low, high = (f"{100.0 * value:.1f}".removesuffix(".0") for value in (explained.low, explained.high))
    # Still alike to a tenth: the lower end rounded down is what the data support.
    interval = f"95 %: {low} to {high} %" if low != high else f"95 %: at least {_lower_tenth(explained.low):.1f} %"
    verb = "explain" if n_effects > 1 else "explains"
    return f"{verb} {share} % ({interval}) of the {avoidable}"


def _lower_tenth(share: float) -> float:
    """Return the percentage next below a share, in tenths: 1.0 is "at least 99.9 %", nothing is at least nothing."""
    return max(math.ceil(1000.0 * share) - 1, 0) / 10.0
