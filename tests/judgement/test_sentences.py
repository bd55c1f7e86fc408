"""What is said where nothing is missing, and where something is that follows nothing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.judgement.reading import ShownDiscrepancy
from stiffcal.judgement.sentences import _left_out_is_worse, _unexplained
from stiffcal.measurements.rms import Rms


@pytest.mark.parametrize(("ratio", "is_worse"), [(1.3, False), (15.0, True)])
def test_an_error_of_many_noises_is_not_that_of_the_instruments(ratio: float, is_worse: bool) -> None:
    """Of four poses: the fit was as good as the noise, poses that it was not made from were 0.244 of 0.0165 mm off."""
    found: Any = SimpleNamespace(before=SimpleNamespace(ratio=ratio))
    assert _left_out_is_worse(found) == is_worse


@pytest.mark.parametrize(("noise", "size"), [(Rms(2e-5, None), " by 0.0800 mm rms"), (None, "")])
@pytest.mark.parametrize(("in_time", "words"), [(False, "from pose to pose"), (True, "in the course of runs")])
def test_a_scatter_that_follows_nothing_is_stated_with_its_size(
    noise: Rms | None, size: str, in_time: bool, words: str
) -> None:
    """Of places that scattered by four noises the answer was that something is missing, and nothing else."""
    shown = ShownDiscrepancy(in_time, 0.81, 4.0)
    reading = SimpleNamespace(unlisted=(), p_unknown=0.81, failed=(), discrepancy=shown)
    found: Any = SimpleNamespace(reading=reading, found=(), differ_between="pose to pose")
    (text,) = _unexplained(found, [], noise)
    assert f"{words}{size}" in text
    assert "81 %" in text
