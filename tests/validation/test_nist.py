"""NIST Statistical Reference Datasets, linear least squares: certified values for our solver.

National Institute of Standards and Technology, Statistical Reference Datasets (StRD), linear regression:
Longley (higher difficulty; Longley, J. Amer. Statist. Assoc. 62, 1967), Norris (lower), Pontius (lower; a load cell's
deflection under load), NoInt1 and NoInt2 (average), Wampler1 to 3 (higher; polynomials of fifth degree). Every data
set is first solved here in exact fractions, which must give its certified values to fourteen digits: a slip in copying
cannot pass.

The solver is asked twice: through blocks of rows, and with the intercept as a run's free offset, which it eliminates.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.estimation.triangular import Reduced
from stiffcal.identification.derivatives.observation import Evaluation, Observations
from stiffcal.identification.fitting.least_squares import reduce_blocks
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.readings.row_layout import layout_of
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.model.effect import StateOrder


@dataclass(frozen=True)
class Certified:
    """A data set and what NIST certifies.

    Attributes
    ----------
    x : predictors in rows (k, n) as typed; ``powers`` turns one predictor into a polynomial.
    y : (n,) responses.
    intercept : True where the model has one; its values then come first.
    estimates, deviations : certified estimates and their standard deviations.
    residual : certified residual standard deviation.
    digits : decimal digits that we hold ourselves to.
    """

    x: list[list[str]]
    y: list[str]
    intercept: bool
    estimates: list[float]
    deviations: list[float]
    residual: float
    digits: float


def columns(text: str) -> list[list[str]]:
    return [list(column) for column in zip(*(line.split() for line in text.strip().splitlines()), strict=True)]


def powers(x: list[str], degree: int) -> list[list[str]]:
    return [[str(Fraction(value) ** k) for value in x] for k in range(1, degree + 1)]


LONGLEY = columns("""
60323 83.0 234289 2356 1590 107608 1947
61122 88.5 259426 2325 1456 108632 1948
60171 88.2 258054 3682 1616 109773 1949
61187 89.5 284599 3351 1650 110929 1950
63221 96.2 328975 2099 3099 112075 1951
63639 98.1 346999 1932 3594 113270 1952
64989 99.0 365385 1870 3547 115094 1953
63761 100.0 363112 3578 3350 116219 1954
66019 101.2 397469 2904 3048 117388 1955
67857 104.6 419180 2822 2857 118734 1956
68169 108.4 442769 2936 2798 120445 1957
66513 110.8 444546 4681 2637 121950 1958
68655 112.6 482704 3813 2552 123366 1959
69564 114.2 502601 3931 2514 125368 1960
69331 115.7 518173 4806 2572 127852 1961
70551 116.9 554894 4007 2827 130081 1962
""")

NORRIS = columns("""
0.1 0.2
338.8 337.4
118.1 118.2
888.0 884.6
9.2 10.1
228.1 226.5
668.5 666.3
998.5 996.3
449.1 448.6
778.9 777.0
559.2 558.2
0.3 0.4
0.1 0.6
778.1 775.5
668.8 666.9
339.3 338.0
448.9 447.5
10.8 11.6
557.7 556.0
228.3 228.1
998.0 995.8
888.8 887.6
119.6 120.2
0.3 0.3
0.6 0.3
557.6 556.8
339.3 339.1
888.0 887.2
998.5 999.0
778.9 779.0
10.2 11.1
117.6 118.3
228.9 229.2
668.4 669.1
449.2 448.9
0.2 0.5
""")

PONTIUS = columns("""
.11019 .21956 .32949 .43899 .54803 .65694 .76562 .87487 .98292 1.09146
1.20001 1.30822 1.41599 1.52399 1.63194 1.73947 1.84646 1.95392 2.06128 2.16844
.11052 .22018 .32939 .43886 .54798 .65739 .76596 .87474 .98300 1.09150
1.20004 1.30818 1.41613 1.52408 1.63159 1.73965 1.84696 1.95445 2.06177 2.16829
""")
PONTIUS_DEFLECTION = [value for line in zip(*PONTIUS, strict=True) for value in line]
PONTIUS_LOAD = [str(150_000 * k) for k in range(1, 21)] * 2

TO_20 = [str(k) for k in range(21)]
WAMPLER3_LINES = columns("""
760 -2042 2111 -1684 3888 1858 11379
17560 39287 64382 113159 175108 273291 400186
581243 811568 1121004 1506550 2002767 2611612 3369180
""")
WAMPLER3 = [value for line in zip(*WAMPLER3_LINES, strict=True) for value in line]

SETS = {
    "Longley": Certified(
        LONGLEY[1:],
        LONGLEY[0],
        True,
        [
            -3482258.63459582, 15.0618722713733, -0.358191792925910e-01, -2.02022980381683, -1.03322686717359,
            -0.511041056535807e-01, 1829.15146461355,
        ],
        [
            890420.383607373, 84.9149257747669, 0.334910077722432e-01, 0.488399681651699, 0.214274163161675,
            0.226073200069370, 455.478499142212,
        ],
        304.854073561965,
        9.0,
    ),
    "Norris": Certified(
        NORRIS[1:],
        NORRIS[0],
        True,
        [-0.262323073774029, 1.00211681802045],
        [0.232818234301152, 0.429796848199937e-03],
        0.884796396144373,
        11.0,
    ),
    "Pontius": Certified(
        powers(PONTIUS_LOAD, 2),
        PONTIUS_DEFLECTION,
        True,
        [0.673565789473684e-03, 0.732059160401003e-06, -0.316081871345029e-14],
        [0.107938612033077e-03, 0.157817399981659e-09, 0.486652849992036e-16],
        0.205177424076185e-03,
        10.0,
    ),
    "NoInt1": Certified(
        [[str(k) for k in range(60, 71)]],
        [str(k) for k in range(130, 141)],
        False,
        [2.07438016528926],
        [0.165289256198347e-01],
        3.56753034006338,
        12.0,
    ),
    "NoInt2": Certified(
        [["4", "5", "6"]],
        ["3", "4", "4"],
        False,
        [0.727272727272727],
        [0.420827318078432e-01],
        0.369274472937998,
        12.0,
    ),
    "Wampler1": Certified(
        powers(TO_20, 5),
        [str(sum(k**power for power in range(6))) for k in range(21)],
        True,
        [1.0] * 6,
        [0.0] * 6,
        0.0,
        7.0,
    ),
    "Wampler2": Certified(
        powers(TO_20, 5),
        [str(sum((Fraction(k, 10) ** power for power in range(6)), Fraction(0))) for k in range(21)],
        True,
        [1.0, 0.1, 0.01, 0.001, 0.0001, 0.00001],
        [0.0] * 6,
        0.0,
        10.0,
    ),
    "Wampler3": Certified(
        powers(TO_20, 5),
        WAMPLER3,
        True,
        [1.0] * 6,
        [
            2152.32624678170, 2363.55173469681, 779.343524331583, 101.475507550350, 5.64566511170752,
            0.112324854679312,
        ],
        2360.14502379268,
        6.5,
    ),
}  # fmt: skip


@pytest.fixture(params=sorted(SETS))
def case(request: pytest.FixtureRequest) -> Certified:
    return SETS[request.param]


def exact_fit(case: Certified) -> tuple[list[Fraction], Fraction]:
    """Solve the normal equations in fractions: estimates and residual sum of squares, exact for the typed data."""
    rows = [[Fraction(value) for value in row] for row in case.x]
    if case.intercept:
        rows.insert(0, [Fraction(1)] * len(case.y))
    y = [Fraction(value) for value in case.y]
    p = len(rows)
    system = [[_dot(a, b) for b in rows] + [_dot(a, y)] for a in rows]
    for pivot in range(p):
        system[pivot] = [value / system[pivot][pivot] for value in system[pivot]]
        for other in range(p):
            if other != pivot:
                factor = system[other][pivot]
                system[other] = [a - factor * b for a, b in zip(system[other], system[pivot], strict=True)]
    solution = [row[p] for row in system]
    left = [v - sum((b * row[i] for b, row in zip(solution, rows, strict=True)), Fraction(0)) for i, v in enumerate(y)]
    return solution, _dot(left, left)


def _dot(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def as_observations(x: Floats, y: Floats, free_offset: bool) -> Observations:
    """Dress a regression as one observed component of one run."""
    n = len(y)
    base, one_run = Attachment(0, np.eye(4)), np.zeros(n, dtype=np.int64)
    return Observations(
        angles=np.zeros((1, n)),
        wrench=np.zeros((6, n)),
        order=StateOrder(one_run, np.zeros(n), np.zeros(n), np.zeros((1, n)), np.zeros(n), np.zeros(n)),
        measured=y[None],
        measured_mask=np.ones((1, n), dtype=np.bool_),
        layout=layout_of([0], [0], [0]),
        free_offset=free_offset,
        run=one_run,
        setup=MeasurementSetup(base, base, (base,), ("",), True),
        index=np.arange(n),
    )  # fmt: skip


def solve(x: Floats, y: Floats, block: int, free_offset: bool = False) -> Reduced:
    """Run the solver on (k, n) predictors in blocks of states."""
    n = len(y)
    data = as_observations(x, y, free_offset)
    blocks = [
        Evaluation(part, np.zeros((1, part.stop - part.start)), x[:, None, part], None)
        for part in (slice(start, min(start + block, n)) for start in range(0, n, block))
    ]
    return reduce_blocks(blocks, data, Whitening(np.ones((1, n))))


def standard_deviations(reduced: Reduced) -> Floats:
    inverse = np.linalg.inv(reduced.factor)
    variance = reduced.remainder / (reduced.dof - len(reduced.target))
    return np.asarray(np.sqrt(np.sum(inverse**2, axis=1) * variance), dtype=np.float64)


def assert_digits(found: Floats, certified: list[float], digits: float) -> None:
    np.testing.assert_allclose(found, certified, rtol=10.0**-digits, atol=10.0**-digits if not any(certified) else 0.0)


def test_typed_data_give_the_certified_values(case: Certified) -> None:
    """In exact arithmetic: a slip of the pen in any number would show here."""
    solution, squares = exact_fit(case)
    np.testing.assert_allclose([float(b) for b in solution], case.estimates, rtol=2e-14)
    dof = len(case.y) - len(solution)
    assert float(squares / dof) ** 0.5 == pytest.approx(case.residual, rel=2e-14)


@pytest.mark.parametrize("block", [3, 1000])
def test_certified_values_through_blocks(case: Certified, block: int) -> None:
    x = np.array([[float(Fraction(value)) for value in row] for row in case.x])
    y = np.array([float(Fraction(value)) for value in case.y])
    if case.intercept:
        x = np.vstack([np.ones(len(y)), x])
    reduced = solve(x, y, block)
    assert_digits(reduced.solve(), case.estimates, case.digits)
    assert reduced.dof == len(y)
    if case.residual > 0.0:
        assert_digits(standard_deviations(reduced), case.deviations, case.digits)
        found = np.sqrt(reduced.remainder / (reduced.dof - len(x)))
        assert_digits(np.array([found]), [case.residual], case.digits)
    else:
        assert np.sqrt(reduced.remainder) < 1e-7 * np.linalg.norm(y)


@pytest.mark.parametrize("name", sorted(name for name, case in SETS.items() if case.intercept))
def test_certified_slopes_with_the_intercept_as_a_free_offset(name: str) -> None:
    """One run, its constant offset eliminated: slopes, deviations and degrees of freedom are the certified ones."""
    case = SETS[name]
    x = np.array([[float(Fraction(value)) for value in row] for row in case.x])
    y = np.array([float(Fraction(value)) for value in case.y])
    reduced = solve(x, y, 1000, free_offset=True)
    assert reduced.dof == len(y) - 1
    assert_digits(reduced.solve(), case.estimates[1:], case.digits)
    if case.residual > 0.0:
        assert_digits(standard_deviations(reduced), case.deviations[1:], case.digits)
