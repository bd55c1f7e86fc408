"""Where whole steps lead nowhere the fit goes back to the lowest place that it has met."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.estimation.rows import Rows
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.unknowns import Unknowns
from tests.laboratory.function_sources import FunctionSource, Unchanging, independent, solved


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


class OtherWeights(Unchanging):
    """Weights under which no sum of squares compares with one before."""

    def sums_as(self, other: Unchanging) -> bool:
        return False


@dataclass(frozen=True)
class Reweighed(FunctionSource):
    """Each step has weights of its own, under which the step before looks a thousand times better."""

    def reduced(self, values: Floats, weights: Unchanging | None, renew: bool) -> tuple[Reduced, Unchanging]:
        return self.about(values).reduced(), OtherWeights()

    def squares(self, values: Floats, reduced: Reduced, weights: Unchanging) -> float:
        return 1e3 * reduced.cost(np.zeros_like(values))


def test_slow_steps_near_the_solution_under_changing_weights_go_on() -> None:
    """Each takes away two fifths of what is left, from one standard uncertainty: no sum says that they led nowhere."""

    def steeper(rows: Rows) -> Rows:
        return replace(rows, derivative=2.5 * rows.derivative)

    source = Reweighed(
        Unknowns.plain(("x",)), lambda values: values[None], np.array([[7.0]]), independent(1.0, (1, 1)), change=steeper
    )
    ended = solved(source, np.array([6.8]))
    assert ended.last_step is None
    assert ended.iterations < 16
    assert ended.values == pytest.approx([7.0], abs=1e-2)
