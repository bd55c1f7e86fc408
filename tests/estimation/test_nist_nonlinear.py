"""NIST Statistical Reference Datasets, nonlinear regression: certified values for the solver of every fit.

National Institute of Standards and Technology, StRD: Misra1a (Misra, Dental research: monomolecular adsorption, 1978;
lower difficulty) and Rat42 (Ratkowsky, Nonlinear Regression Modeling, 1983, pasture yield; higher difficulty). What is
left of the certified values is checked too, so that a slip in copying cannot pass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import Unknowns
from tests.laboratory.function_sources import Function, FunctionSource, independent, solved


@dataclass(frozen=True)
class Certified:
    """A data set, its law, two starts, and what NIST certifies."""

    x: Floats
    y: Floats
    law: str
    starts: tuple[tuple[float, ...], tuple[float, ...]]
    estimates: tuple[float, ...]
    deviations: tuple[float, ...]
    squares: float

    def function(self) -> Function:
        if self.law == "misra1a":
            return lambda b: (b[0] * (1.0 - np.exp(-b[1] * self.x)))[None]
        return lambda b: (b[0] / (1.0 + np.exp(b[1] - b[2] * self.x)))[None]


MISRA1A = Certified(
    np.array([77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0]),
    np.array([10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78]),
    "misra1a",
    ((500.0, 0.0001), (250.0, 0.0005)),
    (2.3894212918e02, 5.5015643181e-04),
    (2.7070075241e00, 7.2668688436e-06),
    1.2455138894e-01,
)
RAT42 = Certified(
    np.array([9.0, 14.0, 21.0, 28.0, 42.0, 57.0, 63.0, 70.0, 79.0]),
    np.array([8.93, 10.80, 18.59, 22.33, 39.35, 56.11, 61.73, 64.62, 67.08]),
    "rat42",
    ((100.0, 1.0, 0.1), (75.0, 2.5, 0.07)),
    (7.2462237576e01, 2.6180768402e00, 6.7359200066e-02),
    (1.7340283401e00, 8.8295217536e-02, 3.4465663377e-03),
    8.0565229338e00,
)


@pytest.mark.parametrize("data", [MISRA1A, RAT42], ids=lambda data: data.law)
@pytest.mark.parametrize("start", [0, 1])
def test_certified_values(data: Certified, start: int) -> None:
    n, p = len(data.x), len(data.estimates)
    sigma = float(np.sqrt(data.squares / (n - p)))
    names = [f"b{number}" for number in range(1, p + 1)]
    source = FunctionSource(Unknowns.plain(names), data.function(), data.y[None], independent(sigma, (1, n)))
    certified = np.array(data.estimates)
    left = data.y - data.function()(certified)[0]
    assert left @ left == pytest.approx(data.squares, rel=1e-9)
    ended = solved(source, np.array(data.starts[start]))
    assert ended.last_step is None
    # a fit ends with a step of less than a thousandth of a standard uncertainty
    assert (np.abs(ended.values - certified) / data.deviations).max() < 1e-3
    spread = np.sqrt(np.diag(np.linalg.inv(ended.reduced.factor.T @ ended.reduced.factor)))
    np.testing.assert_allclose(spread, data.deviations, rtol=1e-3)
