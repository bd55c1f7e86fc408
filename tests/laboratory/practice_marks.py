"""Which of many alike stand in the suite; `make practice` judges all."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from _pytest.mark import ParameterSet


def with_practice(names: Iterable[str], *here: str) -> list[ParameterSet]:
    """Return the parameters of a test; those that are not ``here``, one of each kind, for `make practice` alone."""
    return [pytest.param(name, marks=[pytest.mark.practice] * (name not in here)) for name in names]
