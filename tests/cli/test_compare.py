"""What `compare` shows carries the name of what it is."""

from __future__ import annotations

from io import StringIO

from rich.console import Console

from stiffcal.cli.compare import show_comparison


def test_a_stiffness_is_not_called_a_compliance() -> None:
    row = {"name": "joint-compliance.j2.c", "effect": "joint-compliance", "where": {"joints": [2]}, "p_value": 0.5}
    seen = {"value": 1e-6, "std": 1e-8, "stiffness": 1e6, "stiffness_std": 1e4}
    plain = row | {"unit": "rad/(N·m)", "before": seen, "after": seen}
    other = row | {"name": "backlash.j2.b", "unit": "rad", "before": {"value": 1e-4}, "after": {"value": 2e-4}}
    shown = StringIO()
    document = {"parameters": [plain, other], "changed": [], "p_value_all": None}
    show_comparison(Console(file=shown, width=200), document)
    first, second = (
        line.split() for line in shown.getvalue().splitlines() if "j2" in line or "joint-" in line or "1e" in line
    )
    assert "stiffness" in first
    assert "c" not in first
    assert "b" in second
