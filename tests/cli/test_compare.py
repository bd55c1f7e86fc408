"""What `compare` shows carries the name of what it is."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO

from rich.console import Console

from stiffcal.cli.compare import show_comparison
from stiffcal.model.summary import Where
from stiffcal.validation.compare_result import Change, CompareResult, FittedValue


def test_a_stiffness_is_not_called_a_compliance() -> None:
    stiffness = FittedValue(value=1e-6, std=1e-8, stiffness=1e6, stiffness_std=1e4)
    plain = Change(
        name="joint-compliance.j2.c", effect="joint-compliance", where=Where(joints=[2]), unit="rad/(N·m)",
        before=stiffness, after=stiffness, change=0.0, relative=0.0, std=1e-8, p_value=0.5,
    )  # fmt: skip
    before, after = (FittedValue(value=value, std=None) for value in (1e-4, 2e-4))
    other = replace(plain, name="backlash.j2.b", unit="rad", before=before, after=after)
    result = CompareResult(
        warnings=[], before="a", after="b", parameters=[plain, other], only_before=[], only_after=[],
        p_value_all=None, changed=[], origin="own",
    )  # fmt: skip
    shown = StringIO()
    show_comparison(Console(file=shown, width=200), result)
    first, second = (
        line.split() for line in shown.getvalue().splitlines() if "j2" in line or "joint-" in line or "1e" in line
    )
    assert "stiffness" in first
    assert "c" not in first
    assert "b" in second
