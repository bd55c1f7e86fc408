"""What a log cannot be is refused with its row and column, and what is doubtful is remarked on."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.reduction.logs.plausibility import LogQuality


def watch(sampled: bool = True) -> LogQuality:
    return LogQuality(
        "raw/ft.csv", lambda row: f"line {row + 1}", sampled, {"wrench": ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")}
    )


def test_time_over_batches() -> None:
    log = watch()
    wrench = np.random.default_rng(0).normal(size=(6, 100))
    log.update(np.arange(1, 101), np.linspace(0.0, 0.99, 100), {"wrench": wrench})
    log.update(np.arange(101, 201), 5.0 + np.linspace(0.0, 0.99, 100), {"wrench": wrench})
    assert log.interval == pytest.approx(0.01)
    assert any("a gap of 4.01 s" in remark for remark in log.summary().remarks())
    with pytest.raises(InputError, match="line 202: time decreases: 3 s after 5.99 s"):
        log.update(np.arange(201, 301), 3.0 + np.linspace(0.0, 0.99, 100), {"wrench": wrench})


@pytest.mark.parametrize(
    ("begins", "says"),
    [(0.0, "starts anew at midnight"), (3600.0, "decreases"), (20_000 * 86400.0, "decreases")],  # the last with a date
)
def test_a_time_of_day_that_passes_midnight(begins: float, says: str) -> None:
    wrench = np.random.default_rng(0).normal(size=(6, 100))
    time = begins + (86399.505 + np.linspace(0.0, 0.99, 100)) % 86400.0
    with pytest.raises(InputError, match=f"line 52: time {says}"):
        watch().update(np.arange(1, 101), time, {"wrench": wrench})


def test_stuck_and_saturated_channels_are_remarked_on() -> None:
    log = watch()
    wrench = np.random.default_rng(1).normal(size=(6, 400))
    wrench[1] = 3.25
    wrench[2] = np.minimum(10.0 * np.sin(np.arange(400) / 40.0), 8.0)
    log.update(np.arange(1, 401), np.linspace(0.0, 3.99, 400), {"wrench": wrench})
    remarks = "\n".join(log.summary().remarks())
    assert "column Fy is constant at 3.25" in remarks
    assert "column Fz stays at its extreme" in remarks
    assert "Fx" not in remarks


@pytest.mark.parametrize(
    ("signal", "value", "words"),
    [
        ("joints", 90.0, "an angle of 90 rad"),
        ("wrench", 4e5, "a load of 4e\\+05 N"),
        ("translation", 1.0, "a displacement of 1 m"),
        ("position.target", 1800.0, "millimetres"),
        ("lengths", 5.0, "micrometres"),
        ("mass", 5e3, "a mass of 5000 kg in column 2; grams"),
    ],
)
def test_what_cannot_be_has_row_and_column(signal: str, value: float, words: str) -> None:
    values = np.zeros((3, 10))
    values[1, 7] = value
    with pytest.raises(InputError, match=f"line 8.*{words}"):
        watch(sampled=False).update(np.arange(0, 10), np.full(10, np.nan), {signal: values})


def test_a_payload_is_not_negative() -> None:
    masses = np.where(np.arange(10) == 7, -5.0, 0.0)[None]
    with pytest.raises(InputError, match="line 8: a mass of -5 kg"):
        watch(sampled=False).update(np.arange(0, 10), np.full(10, np.nan), {"mass": masses})
