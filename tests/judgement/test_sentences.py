"""What is said where nothing is missing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.judgement.sentences import _left_out_is_worse


@pytest.mark.parametrize(("ratio", "is_worse"), [(1.3, False), (15.0, True)])
def test_an_error_of_many_noises_is_not_that_of_the_instruments(ratio: float, is_worse: bool) -> None:
    """Of four poses: the fit was as good as the noise, poses that it was not made from were 0.244 of 0.0165 mm off."""
    found: Any = SimpleNamespace(before=SimpleNamespace(ratio=ratio))
    assert _left_out_is_worse(found) == is_worse
