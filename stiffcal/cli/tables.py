"""Tables that more than one command shows."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from stiffcal.cli.wording import places
from stiffcal.printed_units import printed_unit
from stiffcal.results.value_words import on_limits
from stiffcal.wording import estimate, listing

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
    console: Console, parameters: Sequence[IdentifiedParameter], unclaimed: Collection[int] = ()
) -> None:
    """Draw identified parameters: compliances as the stiffness people ask for, the others as they are.

    Parameters
    ----------
    console : where to.
    parameters : of a fit.
    unclaimed : joints whose compliance has a value and is not identified by these poses, as ``validate`` states.
    """
    from stiffcal.identification.answers.before_after import stiffness_unit

    compliances = [parameter for parameter in parameters if parameter.is_compliance]
    not_compliances = [parameter for parameter in parameters if not parameter.is_compliance]
    # The column on geometry only where a share is known.
    shared = any(parameter.from_geometry is not None for parameter in parameters)
    from_geometry = ("share of geometry>",) if shared else ()
    if compliances:
        table = plain_table("effect", "place", "stiffness, ± 95 %>", *from_geometry, "")
        for parameter in compliances:
            unit, factor = printed_unit(stiffness_unit(parameter.unit))
            share = (share_from_geometry(parameter),) * shared
            cells = parameter.effect, _place(parameter), _stiffness(parameter, factor)
            table.add_row(*cells, *share, unit + (_not_firm(parameter) or _not_claimed(parameter, unclaimed)))
        console.print(table)
    if not_compliances:
        table = plain_table("parameter", "place", "value, ± 95 %>", *from_geometry, "")
        for parameter in not_compliances:
            unit, factor = printed_unit(parameter.unit, parameter.drift_follows)
            text = "not identifiable"
            if parameter.value is not None:
                text = estimate(parameter.value, parameter.interval, factor)
            table.add_row(
                parameter.name,
                places(parameter.where),
                f"{text} (fixed)" if parameter.fixed else text,
                *(share_from_geometry(parameter),) * shared,
                unit + (_not_firm(parameter) or _included(parameter)),
            )
        console.print(table)


def share_from_geometry(parameter: IdentifiedParameter) -> str:
    """Return how much of the variance the geometry's tolerance makes, in per cent."""
    return "" if parameter.from_geometry is None else f"{100.0 * parameter.from_geometry:.0f} %"


def _not_firm(parameter: IdentifiedParameter) -> str:
    if parameter.at_bound:
        return "  at the limit of its range"
    if parameter.rests_on:
        return f"  {on_limits(parameter.rests_on)}"
    return "  not significant (below 3σ)" if parameter.above_noise is False else ""


def _not_claimed(parameter: IdentifiedParameter, unclaimed: Collection[int]) -> str:
    joints = parameter.where.joints or []
    claimed = parameter.value is None or not set(joints).intersection(unclaimed)
    return "" if claimed else "  not identified by these poses"


def _included(parameter: IdentifiedParameter) -> str:
    """Return which conventions a value of geometry holds: then it is not that of the robot alone."""
    frames = [name for name in parameter.includes or () if name.startswith("frame.")]
    return f"  includes {listing(frames)}" if frames else ""


def _place(parameter: IdentifiedParameter) -> str:
    """Return the place of a compliance, and its axis where its effect has several."""
    symbol = parameter.name.rpartition(".")[2]
    return places(parameter.where) + ("" if symbol == "c" else f", {symbol}")


def _stiffness(parameter: IdentifiedParameter, factor: float) -> str:
    if parameter.value is None:
        return "not identifiable"
    # A compliance of zero: these data show no give at all, and only how stiff the joint is at least.
    if parameter.known_stiffness is None:
        low = (parameter.stiffness_interval or (None, None))[0]
        return estimate(None, (low, None), factor) if low else "rigid"
    text = estimate(parameter.known_stiffness, parameter.stiffness_interval, factor)
    return text + (" (fixed)" if parameter.fixed else "")
