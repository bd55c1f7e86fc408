"""What `compare` shows carries the name of what it is."""

from __future__ import annotations

from io import StringIO

from rich.console import Console

from stiffcal.cli.compare import show_comparison
from stiffcal.identification.before_after import EstimatedParameter, values_before_and_after
from stiffcal.model.summary import Where
from stiffcal.validation.compare_result import CompareResult


def test_a_stiffness_is_not_called_a_compliance() -> None:
    stiffness = EstimatedParameter(
        name="joint-compliance.j2.c", effect="joint-compliance", where=Where(joints=[2]), unit="N·m/rad", value=1e6,
        interval=[0.98e6, 1.02e6],
    )  # fmt: skip
    width = EstimatedParameter(
        name="backlash.j2.b", effect="backlash", where=Where(joints=[2]), unit="rad", value=1e-4, interval=None
    )
    result = CompareResult(
        warnings=[], before="a", after="b", parameters=[], only_before=[], only_after=[],
        before_after=values_before_and_after([stiffness, width], [stiffness, width]), p_value_all=None, changed=[],
        origin="own",
    )  # fmt: skip
    shown = StringIO()
    show_comparison(Console(file=shown, width=200), result)
    first, second = (line for line in shown.getvalue().splitlines() if "joint 2" in line)
    assert "stiffness" in first.split()
    assert "c" not in first.split()
    assert "(1.000 ± 0.020)·10⁶" in first
    assert "b" in second.split()
