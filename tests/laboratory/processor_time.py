"""What tests cost: processor seconds of each, its fixtures and child processes included, however busy the machine is.

Hooks of `tests/conftest.py`. Workers of pytest-xdist send theirs with the reports.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Generator
from dataclasses import dataclass, field
from functools import partial

import pytest

PROPERTY = "processor_seconds"
COLLECTING = "collecting_seconds"
LONGEST_S = 2.0
"""What takes longer and is quick by its marks is listed."""
MARKS = ("docs", "browser", "practice", "long")
"""Of what `make test` leaves out; a test with several of them counts to the first. All others are quick."""


@dataclass
class _Spent:
    """Processor seconds: of this process until the last report, of each test, and of all processes for collecting."""

    before: float = 0.0
    of_tests: defaultdict[str, float] = field(default_factory=partial(defaultdict, float))
    marks: dict[str, str] = field(default_factory=dict)
    collecting: float = 0.0
    not_sent: float = 0.0


_SPENT = _Spent()


def _used() -> float:
    """Return processor seconds of this process and of its children that have ended."""
    return sum(os.times()[:4])


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop() -> None:
    """Collection counts to no test. First, as the loop of a worker of pytest-xdist calls no hook after its own."""
    _SPENT.before = _SPENT.not_sent = _used()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note in each report what its phase took."""
    report = yield
    now = _used()
    report.user_properties.append((PROPERTY, now - _SPENT.before))
    _SPENT.before = now
    if _SPENT.not_sent:
        report.user_properties.append((COLLECTING, _SPENT.not_sent))
        _SPENT.not_sent = 0.0
    return report


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add up what the phases of a test took."""
    for name, seconds in report.user_properties:
        if name == PROPERTY and isinstance(seconds, float):
            _SPENT.of_tests[report.nodeid] += seconds
            _SPENT.marks[report.nodeid] = next((mark for mark in MARKS if mark in report.keywords), "quick")
        if name == COLLECTING and isinstance(seconds, float):
            _SPENT.collecting += seconds


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the sums, and the quick tests that took longest."""
    spent = _SPENT.of_tests
    quick = {name: seconds for name, seconds in spent.items() if _SPENT.marks[name] == "quick"}
    if spent:
        sums: defaultdict[str, float] = defaultdict(float)
        for name, seconds in spent.items():
            sums[_SPENT.marks[name]] += seconds
        listed = ", ".join(f"{mark} {seconds:.0f} s" for mark, seconds in sorted(sums.items()))
        sentence = f"processor time: {sum(sums.values()):.0f} s ({listed}); {_SPENT.collecting:.0f} s more to collect"
        terminalreporter.write_line(sentence)
    for name in sorted(quick, key=lambda name: -quick[name])[:20]:
        if quick[name] > LONGEST_S:
            terminalreporter.write_line(f"  {quick[name]:5.1f} s {name}")
