"""Tables that more than one command shows."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from stiffcal.cli.wording import places
from stiffcal.quantity import Units
from stiffcal.results.value_words import as_shown, remark, value_text

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from stiffcal.identification.answers.fit_results import IdentifiedParameter


def plain_table(*columns: str) -> Table:
    """Return an empty table without frame that splits no word; titles that end in `>` mark numbers, aligned right."""
    from rich import box

    from stiffcal.cli.narrow_table import NarrowTable

    table = NarrowTable(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for column in columns:
        table.add_column(column.removesuffix(">"), justify="right" if column.endswith(">") else "left", overflow="fold")
    return table


def show_parameters(
    console: Console,
    parameters: Sequence[IdentifiedParameter],
    unclaimed: Collection[int] = (),
    shifted: Collection[str] = (),
    most: int | None = None,
) -> None:
    """Draw identified parameters: compliances as the stiffness people ask for, the others as they are.

    Parameters
    ----------
    console : where to.
    parameters : of a fit.
    unclaimed : joints whose compliance has a value and is not identified by these poses, as ``validate`` states.
    shifted : names of values that adding what the model lacks moves beyond their intervals, as ``diagnose`` states.
    most : values that are listed next to stiffness; None: all.
    """
    estimates = {one.name: as_shown(one, unclaimed, shifted) for one in parameters}
    units = Units((estimate.quantity, [estimate.value]) for estimate in estimates.values() if estimate.quantity)
    # The column on geometry only where a share is known.
    shared = any(parameter.from_geometry is not None for parameter in parameters)
    from_geometry = ("share of geometry>",) if shared else ()
    for of_compliances, columns in (
        (True, ("effect", "place", "stiffness, ± 95 %>")),
        (False, ("parameter", "place", "value, ± 95 %>")),
    ):
        members = [parameter for parameter in parameters if parameter.is_compliance == of_compliances]
        table = plain_table(*columns, *from_geometry, "")
        # a line that says one more takes the room of that one
        shown = members if of_compliances or most is None or len(members) <= most + 1 else members[:most]
        for parameter in shown:
            estimate = estimates[parameter.name]
            unit = units.of(estimate.quantity or parameter.quantity)
            words = remark(estimate)
            table.add_row(
                parameter.effect if of_compliances else parameter.name,
                _place(parameter) if of_compliances else places(parameter.where),
                value_text(estimate, unit),
                *(share_from_geometry(parameter),) * shared,
                unit.name + (f"  {words}" if words else ""),
            )
        if members:
            console.print(table)
        if len(shown) < len(members):
            console.print(f"  and {len(members) - len(shown)} more (--details)")


def share_from_geometry(parameter: IdentifiedParameter) -> str:
    """Return how much of the variance the geometry's tolerance makes, in per cent."""
    return "" if parameter.from_geometry is None else f"{100.0 * parameter.from_geometry:.0f} %"


def _place(parameter: IdentifiedParameter) -> str:
    """Return the place of a compliance, and its axis where its effect has several."""
    symbol = parameter.name.rpartition(".")[2]
    return places(parameter.where) + ("" if symbol == "c" else f", {symbol}")
