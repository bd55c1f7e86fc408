"""The tables of a fit's values: compliances as the stiffness people ask for, the others as they are."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from stiffcal.quantity import Units
from stiffcal.results.value_words import as_shown, remark, value_text
from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import place

if TYPE_CHECKING:
    from stiffcal.identification.answers.fit_results import IdentifiedParameter


def add_parameters(
    made: PageBuilder,
    parameters: Sequence[IdentifiedParameter],
    unclaimed: Collection[int] = (),
    shifted: Collection[str] = (),
    most: int | None = None,
) -> None:
    """Add identified parameters: compliances as the stiffness people ask for, the others as they are.

    Parameters
    ----------
    parameters : of a fit.
    unclaimed : joints whose compliance has a value and is not identified by these poses, as ``validate`` states.
    shifted : names of values that adding what the model lacks moves beyond their intervals, as ``diagnose`` states.
    most : values that are listed next to stiffness; None: all.
    """
    estimates = {one.name: as_shown(one, unclaimed, shifted) for one in parameters}
    units = Units((estimate.quantity, [estimate.value]) for estimate in estimates.values() if estimate.quantity)
    # The column on geometry only where a share is known.
    shared = any(parameter.from_geometry is not None for parameter in parameters)
    from_geometry = (number("share of geometry"),) if shared else ()
    for of_compliances, titles in (
        (True, ("effect", "place", number("stiffness, ± 95 %"))),
        (False, ("parameter", "place", number("value, ± 95 %"))),
    ):
        members = [parameter for parameter in parameters if parameter.is_compliance == of_compliances]
        # a line that says one more takes the room of that one
        shown = members if of_compliances or most is None or len(members) <= most + 1 else members[:most]
        rows = []
        for parameter in shown:
            estimate = estimates[parameter.name]
            unit = units.of(estimate.quantity or parameter.quantity)
            words = remark(estimate)
            rows.append(
                (
                    parameter.effect if of_compliances else parameter.name,
                    _place(parameter) if of_compliances else place(parameter.where),
                    value_text(estimate, unit),
                    *(_share_from_geometry(parameter),) * shared,
                    unit.name + (f"  {words}" if words else ""),
                )
            )
        made.table((*titles, *from_geometry, ""), rows)
        if len(shown) < len(members):
            made.say(f"  and {len(members) - len(shown)} more (identify --details)", "more")


def _share_from_geometry(parameter: IdentifiedParameter) -> str:
    """Return how much of the variance the geometry's tolerance makes, in per cent."""
    return "" if parameter.from_geometry is None else f"{100.0 * parameter.from_geometry:.0f} %"


def _place(parameter: IdentifiedParameter) -> str:
    """Return the place of a compliance, and its axis where its effect has several."""
    symbol = parameter.name.rpartition(".")[2]
    return place(parameter.where) + ("" if symbol == "c" else f", {symbol}")
