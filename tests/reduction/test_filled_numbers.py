"""Numbers that are written where there is no reading are named with their column and rows; readings never are."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.signals.row_filter import parse_rows
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.quantities import unit
from stiffcal.reduction.logs.kept_rows import KeptRows, check_sizes
from stiffcal.reduction.logs.plausibility import LogQuality

COLUMNS = {
    "wrench": ("Fx", "Fy", "Fz"),
    "position.probe": ("X (mm)", "Y", "Z"),
    "joints": ("A1", "A2"),
    "temperature": ("T",),
}
UNITS = {
    **{column: unit("N", "force") for column in COLUMNS["wrench"]},
    **{column: unit("mm", "length") for column in COLUMNS["position.probe"]},
    **{column: unit("deg", "angle") for column in COLUMNS["joints"]},
    "T": unit("degC", "temperature"),
}
N = 200


def good(signal: str) -> Floats:
    """Return (c, N) readings in the units of the file: loads that are held, noise, two poses."""
    generator = np.random.default_rng(3)
    count = len(COLUMNS[signal])
    held = np.repeat([0.0, 1.0, -0.5, 0.0], N // 4)
    if signal == "wrench":
        return held * [[400.0], [20.0], [-300.0]] + generator.normal(scale=0.2, size=(count, N))
    if signal == "position.probe":
        return np.array([[2100.0], [-3.0], [0.4]]) + held * 2.0 + generator.normal(scale=0.01, size=(count, N))
    if signal == "joints":
        return np.repeat([[10.0, 80.0], [-90.0, -40.0]], N // 2, axis=1)
    return 21.0 + np.round(generator.normal(scale=0.2, size=(count, N)), 1)


def read(signal: str, values: Floats, sampled: bool = True, batches: int = 1) -> None:
    log = LogQuality("raw/a.csv", "line {}".format, sampled, COLUMNS, declared=UNITS)
    own = [UNITS[column] for column in COLUMNS[signal]]
    si = np.stack([row * of.factor + of.offset for row, of in zip(values, own, strict=True)])
    for part in np.array_split(np.arange(values.shape[1]), batches):
        log.update(part + 1, 0.01 * part.astype(np.float64), {signal: si[:, part]})
    log.summary()


def fault_of(signal: str, values: Floats, sampled: bool = True, batches: int = 1) -> Fault:
    with pytest.raises(InputError) as refused:
        read(signal, values, sampled, batches)
    (fault,) = refused.value.faults
    assert fault.code is FaultCode.READING_IMPLAUSIBLE
    return fault


@pytest.mark.parametrize("signal", list(COLUMNS))
@pytest.mark.parametrize("sampled", [True, False])
def test_readings_are_no_filled_numbers(signal: str, sampled: bool) -> None:
    read(signal, good(signal), sampled)
    read(signal, good(signal), sampled, batches=7)


@pytest.mark.parametrize("number", [-9999.0, 9999.99, -1e30, 99999.99, 32767.0, -999999.0, 3.4028234663852886e38])
@pytest.mark.parametrize("signal", list(COLUMNS))
def test_a_filled_number_is_named_with_a_condition_that_leaves_it_out(signal: str, number: float) -> None:
    values = good(signal)
    values[-1, [60, 61, 62, 150]] = number
    fault = fault_of(signal, values)
    column = COLUMNS[signal][-1]
    assert (fault.file, fault.place) == ("raw/a.csv", "line 61")
    assert f"column {column}:" in fault.reason
    assert "4 rows (61-63, 151)" in fault.reason
    _assert_left_out(fault, {column: values[-1]}, 4)


@pytest.mark.parametrize("number", [3.4028234663852886e38, -1.7976931348623157e308])
def test_a_number_that_is_larger_than_any_is_left_out_by_its_condition(number: float) -> None:
    values = good("position.probe")[0]
    values[[5, 6, 40]] = number
    with pytest.raises(InputError) as refused:
        check_sizes(KeptRows(np.arange(1, N + 1), {"X (mm)": values}, []), {"X (mm)": "raw/a.csv"})
    _assert_left_out(refused.value.faults[0], {"X (mm)": values}, 3)


@pytest.mark.parametrize("number", [-1000.0, 0.0, 7777.0])
def test_any_number_that_repeats_where_readings_do_not_is_one(number: float) -> None:
    values = good("position.probe")
    values[0, 30:36] = number
    _assert_left_out(fault_of("position.probe", values), {"X (mm)": values[0]}, 6)


def test_columns_with_their_own_rows_are_named_together() -> None:
    values = good("wrench")
    values[0, 10], values[1, 20:23], values[2, 20:22] = -9999.0, -9999.0, -9999.0
    fault = fault_of("wrench", values)
    assert "columns Fx and Fy" in fault.reason
    _assert_left_out(fault, dict(zip(COLUMNS["wrench"], values, strict=True)), 4)


def test_a_number_of_32_bits_is_left_out_by_a_range() -> None:
    values = good("wrench")
    values[0, 40:44] = np.float64(np.float32(9999.99))
    fault = fault_of("wrench", values)
    assert "Fx < " in fault.mend
    _assert_left_out(fault, {"Fx": values[0]}, 4)


def test_a_batch_of_nothing_but_filled_numbers_is_compared_with_those_before() -> None:
    values = good("wrench")
    values[:, 150:] = -9999.0
    assert fault_of("wrench", values, batches=4).place == "line 151"


@pytest.mark.parametrize("sampled", [True, False])
def test_loads_that_are_set_are_readings(sampled: bool) -> None:
    values = np.zeros((3, N))
    values[0, 50:100] = 999.0  # without noise: of a simulation, or typed
    read("wrench", values, sampled)
    values = np.tile(np.repeat([0.0, 100.0, 999.0, 1000.0], N // 4), (3, 1))
    read("wrench", values, sampled)


def _assert_left_out(fault: Fault, columns: dict[str, Floats], count: int) -> None:
    """Check that the condition in a mend leaves out so many rows, and no more."""
    text = fault.mend.split('rows = "')[1].split('"')[0]
    kept = np.ones(N, dtype=np.bool_)
    for condition in parse_rows(text):
        values = columns[condition.column]
        assert isinstance(condition.value, float)
        kept &= {"!=": values != condition.value, "<": values < condition.value, ">": values > condition.value}[
            condition.operator
        ]
    assert int((~kept).sum()) == count
