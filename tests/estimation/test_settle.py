"""Where whole steps lead nowhere the fit goes back to the lowest place that it has met."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.estimation.unknowns import Unknowns
from tests.laboratory.function_sources import FunctionSource, independent, solved


@pytest.mark.parametrize("start", [1.393, 1.4, 1.42])
def test_after_whole_steps_that_grow_without_end_they_are_shortened(start: float) -> None:
    """Each whole step on the arctangent from beyond 1.39 ends further away on the other side."""
    source = FunctionSource(
        Unknowns.plain(("x",)), lambda values: np.array([[10.0 * np.arctan(values[0] - 50.0)]]), np.zeros((1, 1)),
        independent(0.1, (1, 1)),
    )  # fmt: skip
    ended = solved(source, np.array([50.0 + start]))
    assert ended.last_step is None
    assert ended.values == pytest.approx([50.0], abs=1e-4)
