"""Tables that more than one command shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stiffcal.cli.wording import interval, places, significant

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def plain_table(*columns: str) -> Table:
    """Return an empty table without frame; columns whose title ends in `>` are numbers and stand right."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for column in columns:
        right = column.endswith(">")
        table.add_column(column.removesuffix(">"), justify="right" if right else "left", overflow="fold", no_wrap=right)
    return table


def show_parameters(console: Console, parameters: Sequence[dict[str, Any]]) -> None:
    """Draw identified parameters: compliances as the stiffness people ask for, the others as they are.

    Parameters
    ----------
    console : where to.
    parameters : as in the `identify` document.
    """
    compliances = [p for p in parameters if "stiffness" in p]
    others = [p for p in parameters if "stiffness" not in p]
    if compliances:
        table = plain_table("effect", "place", "stiffness, ± 95 %>", "")
        for p in compliances:
            low, high = _ends(p.get("stiffness_interval"))
            table.add_row(p["effect"], _place(p), _stiffness(p, low, high), _stiffness_unit(p["unit"]) + _in_noise(p))
        console.print(table)
    if others:
        table = plain_table("parameter", "place", "value, ± 95 %>", "")
        for p in others:
            low, high = _ends(p.get("interval"))
            words = interval(p["value"], low, high) if p["value"] is not None else "cannot be told"
            table.add_row(
                p["name"], places(p["where"]), f"{words} (fixed)" if p["fixed"] else words, p["unit"] + _in_noise(p)
            )
        console.print(table)


def _in_noise(parameter: dict[str, Any]) -> str:
    return "  within the noise" if parameter.get("above_noise") is False else ""


def _place(parameter: dict[str, Any]) -> str:
    """Return where a compliance sits, and of which axis it is where its effect has several."""
    symbol = str(parameter["name"]).rpartition(".")[2]
    return places(parameter["where"]) + ("" if symbol == "c" else f", {symbol}")


def _stiffness(parameter: dict[str, Any], low: float | None, high: float | None) -> str:
    if parameter["value"] is None:
        return "cannot be told"
    # A compliance of zero: these data show no give at all, and only say how stiff the joint is at least.
    if parameter["stiffness"] is None:
        return f"above {significant(low)}" if low else "rigid"
    return interval(parameter["stiffness"], low, high) + (" (fixed)" if parameter["fixed"] else "")


def _ends(ends: Sequence[float | None] | None) -> tuple[float | None, float | None]:
    return (None, None) if ends is None else (ends[0], ends[1])


def _stiffness_unit(compliance_unit: str) -> str:
    return {"rad/(N·m)": "N·m/rad", "m/N": "N/m"}.get(compliance_unit, f"1/({compliance_unit})")
