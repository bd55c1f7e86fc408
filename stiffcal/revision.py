"""The number of what stiffcal computes: results of another one are computed again."""

REVISION = 80
"""Raised by one with every change after which the same logs give other numbers: another reduction, another physics,
another weight, a default, a bound of a solver. Not for new keys, words or speed. A result whose revision is not this
one is stale, whatever the version of the package is. `tests/fingerprint.json` holds some answers of this revision; the
test that compares them fails when it was forgotten, and ``make fingerprint`` writes them anew.
"""
